/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A sliding window's time on, from a bounded list of spans. When the list is
 * full, two neighbouring spans become one of their summed length that ends where
 * the later one ended: the earlier one's time is taken to have been later than
 * it was, so it leaves the window later. No window that ends after it thus counts less
 * than the truth. The pair is chosen that adds least (time moved x distance).
 */
#include "duty.h"

#include <string.h>

#include "ttf/base/time.h"

bool duty_limited(const struct ttf_lamp_info *info)
{
    return info->max_duty_permille < TTF_LAMP_FULL && info->duty_window_ns > 0;
}

int64_t duty_limit_ns(const struct ttf_lamp_info *info)
{
    int64_t window = info->duty_window_ns, duty = info->max_duty_permille;

    return window / TTF_LAMP_FULL * duty + window % TTF_LAMP_FULL * duty / TTF_LAMP_FULL;
}

static int64_t overlap(int64_t from, int64_t to, int64_t window_from, int64_t window_to)
{
    if (from < window_from)
        from = window_from;
    if (to > window_to)
        to = window_to;
    return to > from ? to - from : 0;
}

int64_t duty_used_ns(const struct ttf_lamp_info *info, const struct ttf_guardian_lamp *lamp,
                     int64_t at_ns)
{
    int64_t from = at_ns - info->duty_window_ns, used = 0;

    for (unsigned i = 0; i < lamp->n_spans; i++)
        used += overlap(lamp->spans[i].from_ns, lamp->spans[i].to_ns, from, at_ns);
    if (lamp->on_since_ns != TTF_NS_UNKNOWN)
        used += overlap(lamp->on_since_ns, at_ns, from, at_ns);
    return used;
}

/* The first instant after t at which the window's old end enters or leaves a span. */
static int64_t next_bend(int64_t window, const struct ttf_guardian_lamp *lamp, int64_t t,
                         bool *ret_leaving)
{
    int64_t bend = lamp->on_since_ns + window; /* the running stretch itself */

    *ret_leaving = t >= bend;
    for (unsigned i = 0; i < lamp->n_spans; i++) {
        int64_t enter = lamp->spans[i].from_ns + window, leave = lamp->spans[i].to_ns + window;

        if (enter > t && enter < bend)
            bend = enter;
        if (enter <= t && leave > t) {
            *ret_leaving = true;
            if (leave < bend)
                bend = leave;
        }
    }
    return bend;
}

int64_t duty_exhausted_ns(const struct ttf_lamp_info *info, const struct ttf_guardian_lamp *lamp,
                          int64_t now_ns)
{
    int64_t limit = duty_limit_ns(info), t = now_ns;
    int64_t used = duty_used_ns(info, lamp, t);

    /* Between bends, time on grows as fast as time, or not at all. */
    while (used < limit) {
        bool leaving;
        int64_t bend = next_bend(info->duty_window_ns, lamp, t, &leaving);

        if (bend <= t)
            return t; /* on for a whole window: cannot be below the limit */
        if (!leaving) {
            if (bend - t >= limit - used)
                return t + (limit - used);
            used += bend - t;
        }
        t = bend;
    }
    return t;
}

static void merge(struct ttf_guardian_lamp *lamp, unsigned i)
{
    int64_t length = lamp->spans[i].to_ns - lamp->spans[i].from_ns;

    lamp->spans[i + 1].from_ns -= length;
    memmove(&lamp->spans[i], &lamp->spans[i + 1], (lamp->n_spans - i - 1) * sizeof(lamp->spans[0]));
    lamp->n_spans--;
}

static unsigned cheapest_pair(const struct ttf_guardian_lamp *lamp)
{
    unsigned best = 0;
    double best_cost = -1;

    for (unsigned i = 0; i + 1 < lamp->n_spans; i++) {
        double length = (double)(lamp->spans[i].to_ns - lamp->spans[i].from_ns);
        double gap = (double)(lamp->spans[i + 1].from_ns - lamp->spans[i].to_ns);

        if (best_cost < 0 || length * gap < best_cost) {
            best_cost = length * gap;
            best = i;
        }
    }
    return best;
}

void duty_record(const struct ttf_lamp_info *info, struct ttf_guardian_lamp *lamp, int64_t from_ns,
                 int64_t to_ns)
{
    unsigned gone = 0;

    if (!duty_limited(info) || to_ns <= from_ns)
        return;
    while (gone < lamp->n_spans && lamp->spans[gone].to_ns <= to_ns - info->duty_window_ns)
        gone++;
    if (gone > 0) {
        lamp->n_spans -= gone;
        memmove(&lamp->spans[0], &lamp->spans[gone], lamp->n_spans * sizeof(lamp->spans[0]));
    }
    if (lamp->n_spans == TTF_GUARDIAN_SPANS)
        merge(lamp, cheapest_pair(lamp));
    lamp->spans[lamp->n_spans].from_ns = from_ns;
    lamp->spans[lamp->n_spans].to_ns = to_ns;
    lamp->n_spans++;
}
