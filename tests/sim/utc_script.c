/* SPDX-License-Identifier: Apache-2.0 */
#include "utc_script.h"

#include "ttf/base/time.h"
#include "ttf/hal/sim.h"

/* A clock that shows less than this was never set: nobody vouches for it. */
#define PLAUSIBLE_UTC_NS (INT64_C(1704067200) * TTF_NS_PER_S)

/* A clock that nobody set shows any time: here days ahead, so that whoever believes it loses slots. */
#define NEVER_SET_NS (5 * TTF_NS_PER_DAY)

int64_t utc_script_uncertainty_ns(enum ttf_trust trust)
{
    switch (trust) {
    case TTF_TRUST_RTC:
        return 2 * TTF_NS_PER_S;
    case TTF_TRUST_NTP:
        return 10 * TTF_NS_PER_MS;
    case TTF_TRUST_HOST:
        return 200 * TTF_NS_PER_MS;
    default:
        return TTF_NS_UNKNOWN;
    }
}

int64_t utc_script_offset_ns(const struct utc_script *script, int64_t power_on_ns, int64_t at_ns,
                             enum ttf_trust *ret_trust)
{
    int64_t offset = script->start_utc_ns;

    *ret_trust = TTF_TRUST_NONE;
    if (power_on_ns > 0 && !script->kept) {
        if (script->given_again_ns == 0 || at_ns - power_on_ns < script->given_again_ns)
            return offset + NEVER_SET_NS;
        *ret_trust = TTF_TRUST_NTP;
        return offset;
    }
    if (script->trusted_at_ns == TTF_NS_NEVER || at_ns < script->trusted_at_ns)
        return offset + NEVER_SET_NS;
    if (at_ns >= script->step_at_ns)
        offset += script->step_ns;
    if (offset + at_ns >= PLAUSIBLE_UTC_NS)
        *ret_trust = script->trust;
    return offset;
}

static void scripted_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    const struct utc_script *script = (const struct utc_script *)clock->ops;
    int64_t boot = ttf_clock_now_ns(clock);
    int64_t at = ttf_sim_elapsed_ns(script->box, boot);

    ret->boot_ns = boot;
    ret->utc_ns = at + utc_script_offset_ns(script, script->power_on_ns, at, &ret->trust);
    ret->uncertainty_ns = utc_script_uncertainty_ns(ret->trust);
    ret->steps = 0; /* who looks must notice */
}

void utc_script_play(struct utc_script *script, struct ttf_box *box, int64_t power_on_ns)
{
    script->ops = *box->clock->ops;
    script->ops.utc = scripted_utc;
    script->box = box;
    script->power_on_ns = power_on_ns;
    box->clock->ops = &script->ops;
}
