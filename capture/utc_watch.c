/* SPDX-License-Identifier: Apache-2.0 */
#include "utc_watch.h"

void ttf_utc_watch_init(struct ttf_utc_watch *watch, const struct ttf_utc *utc)
{
    watch->offset_ns = utc->utc_ns - utc->boot_ns;
    watch->trust = utc->trust;
    watch->steps = utc->steps;
}

bool ttf_utc_watch_look(struct ttf_utc_watch *watch, const struct ttf_utc *utc,
                        struct ttf_utc_news *ret)
{
    int64_t step = utc->utc_ns - utc->boot_ns - watch->offset_ns;

    ret->step_ns = step;
    ret->stepped =
        step >= TTF_UTC_STEP_NS || step <= -TTF_UTC_STEP_NS || utc->steps != watch->steps;
    ret->more_trusted = utc->trust > watch->trust;
    ttf_utc_watch_init(watch, utc);
    return ret->stepped || ret->more_trusted;
}

int64_t ttf_utc_watch_at(const struct ttf_utc_watch *watch, int64_t boot_ns)
{
    return watch->trust == TTF_TRUST_NONE || boot_ns == TTF_NS_UNKNOWN ? TTF_NS_UNKNOWN
                                                                       : boot_ns + watch->offset_ns;
}
