/* SPDX-License-Identifier: Apache-2.0 */
#include "clock_utc.h"

#include <string.h>

#include "ttf/base/time.h"

#define RTC_UNCERTAINTY_NS TTF_NS_PER_S
#define NTP_UNCERTAINTY_NS (10 * TTF_NS_PER_MS)
/* However many steps: 60 years, so that UTC stays within its type. */
#define STEPPED_MAX_S      (INT64_C(60) * 366 * 86400)

int sim_utc_init(struct sim_utc *utc, const struct ttf_sim_config *config,
                 const struct sim_faults *faults)
{
    memset(utc, 0, sizeof(*utc));
    utc->config = config;
    utc->faults = faults;
    for (unsigned i = 0; i < TTF_SIM_FAULTS_MAX; i++)
        utc->cursor[i].minute = -1;
    return -pthread_mutex_init(&utc->lock, NULL);
}

void sim_utc_finish(struct sim_utc *utc)
{
    pthread_mutex_destroy(&utc->lock);
}

/* Random steps of fault i up to `elapsed`: [since this boot], [all]. */
static void follow(struct sim_utc *utc, unsigned i, int64_t elapsed, bool since_boot)
{
    const struct sim_faults *f = utc->faults;

    if (utc->cursor[i].minute < 0)
        utc->cursor[i].minute = since_boot ? f->power_on_ns / TTF_NS_PER_MIN : 0;
    while ((utc->cursor[i].minute + 1) * TTF_NS_PER_MIN <= elapsed) {
        int64_t at = ++utc->cursor[i].minute * TTF_NS_PER_MIN;

        if (at < f->fault[i].at_ns || !sim_fault_at_minute(f, i, utc->cursor[i].minute))
            continue;
        utc->cursor[i].sum_s += f->fault[i].amount;
        utc->cursor[i].count += at > f->power_on_ns;
    }
}

int64_t sim_utc_stepped_ns(struct sim_utc *utc, int64_t boot_ns, bool since_boot,
                           uint32_t *ret_count)
{
    const struct sim_faults *f = utc->faults;
    int64_t elapsed = boot_ns + utc->elapsed_offset_ns, sum_s = 0;
    uint32_t count = 0;

    pthread_mutex_lock(&utc->lock);
    for (unsigned i = 0; i < f->n; i++) {
        const struct ttf_fault *fault = &f->fault[i];

        if (fault->kind != TTF_FAULT_CLOCK_STEP)
            continue;
        if (fault->rate_per_million > 0) {
            follow(utc, i, elapsed, since_boot);
            sum_s += utc->cursor[i].sum_s;
            count += utc->cursor[i].count;
        } else if (fault->at_ns <= elapsed && (!since_boot || fault->at_ns > f->power_on_ns)) {
            sum_s += fault->amount;
            count += fault->at_ns > f->power_on_ns;
        }
    }
    pthread_mutex_unlock(&utc->lock);
    *ret_count = count;
    if (sum_s > STEPPED_MAX_S)
        sum_s = STEPPED_MAX_S;
    if (sum_s < -STEPPED_MAX_S)
        sum_s = -STEPPED_MAX_S;
    return sum_s * TTF_NS_PER_S;
}

void sim_utc_at(struct sim_utc *utc, int64_t boot_ns, struct ttf_utc *ret)
{
    const struct ttf_sim_config *c = utc->config;
    int64_t elapsed = boot_ns + utc->elapsed_offset_ns;
    int64_t up = elapsed - c->power_on_ns;
    bool lost = c->power_on_ns > 0 && !c->rtc;
    int64_t stepped = sim_utc_stepped_ns(utc, boot_ns, lost, &ret->steps);

    ret->boot_ns = boot_ns;
    if (lost && (c->utc_back_ns == 0 || up < c->utc_back_ns)) {
        /* Without a battery the clock begins again where its image was made. */
        ret->utc_ns = c->start_utc_ns + up + stepped;
        ret->trust = TTF_TRUST_NONE;
        ret->uncertainty_ns = TTF_NS_UNKNOWN;
        return;
    }
    ret->utc_ns = c->start_utc_ns + elapsed + stepped;
    ret->trust = c->rtc ? TTF_TRUST_RTC : TTF_TRUST_NTP;
    ret->uncertainty_ns = c->rtc ? RTC_UNCERTAINTY_NS : NTP_UNCERTAINTY_NS;
    ret->steps += lost;
}
