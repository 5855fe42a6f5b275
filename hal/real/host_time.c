/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/host_time.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

#define LATEST_NS      (INT64_C(4102444800) * TTF_NS_PER_S) /* 2100 */
#define UNCERTAINTY_NS (2 * TTF_NS_PER_S)                   /* of a PC, and of its word's way */
#define DRIFT_PPM      100                                  /* of a crystal that nobody corrects */

struct ttf_host_time {
    pthread_mutex_t lock;
    bool known;
    int64_t boot_ns, utc_ns; /* as it was said */
};

struct ttf_host_time *ttf_host_time_create(void)
{
    struct ttf_host_time *h = calloc(1, sizeof *h);

    if (h && pthread_mutex_init(&h->lock, NULL) != 0) {
        free(h);
        return NULL;
    }
    return h;
}

void ttf_host_time_destroy(struct ttf_host_time *h)
{
    if (!h)
        return;
    (void)pthread_mutex_destroy(&h->lock);
    free(h);
}

int ttf_host_time_offer(struct ttf_host_time *h, struct ttf_clock *clock, int64_t utc_ns,
                        struct ttf_err *err)
{
    struct ttf_utc own;
    int r = 0;

    if (utc_ns < TTF_UTC_EARLIEST_NS || utc_ns > LATEST_NS)
        return ttf_err_set(err, -EINVAL, "utc_ns", "lies before 2024 or after 2100");
    ttf_clock_utc(clock, &own);
    if (own.trust != TTF_TRUST_NONE && own.trust != TTF_TRUST_HOST)
        return ttf_err_set(err, -EALREADY, NULL, "the box has a better clock (%s)",
                           ttf_trust_name(own.trust));
    (void)pthread_mutex_lock(&h->lock);
    if (h->known && own.boot_ns - h->boot_ns < TTF_HOST_TIME_LASTS_NS) {
        r = ttf_err_set(err, -EALREADY, NULL, "a PC has told it the time already");
    } else {
        h->known = true;
        h->boot_ns = own.boot_ns;
        h->utc_ns = utc_ns;
    }
    (void)pthread_mutex_unlock(&h->lock);
    return r;
}

void ttf_host_time_apply(struct ttf_host_time *h, struct ttf_utc *utc)
{
    if (utc->trust != TTF_TRUST_NONE)
        return;
    (void)pthread_mutex_lock(&h->lock);
    if (h->known) {
        int64_t passed_ns = utc->boot_ns - h->boot_ns;

        utc->utc_ns = h->utc_ns + passed_ns;
        utc->trust = TTF_TRUST_HOST;
        utc->uncertainty_ns = UNCERTAINTY_NS + passed_ns / (1000000 / DRIFT_PPM);
    }
    (void)pthread_mutex_unlock(&h->lock);
}
