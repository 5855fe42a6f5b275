/* SPDX-License-Identifier: Apache-2.0 */
#include "steer.h"

#include <string.h>

void lc_steer_init(struct lc_steer *s, int64_t least_ns, int64_t most_ns, int64_t base_ns,
                   unsigned delay)
{
    memset(s, 0, sizeof(*s));
    s->least_ns = least_ns;
    s->most_ns = most_ns;
    s->base_ns = base_ns;
    s->delay = delay;
    for (unsigned i = 0; i < LC_STEER_REMEMBERED; i++)
        s->asked_ns[i] = base_ns;
}

void lc_steer_begin(struct lc_steer *s, int64_t target_ns)
{
    s->on = true;
    s->target_ns = target_ns;
    s->known = false;
}

void lc_steer_end(struct lc_steer *s)
{
    s->on = false;
}

void lc_steer_arrived(struct lc_steer *s, uint64_t number, int64_t middle_ns)
{
    s->known = true;
    s->last = number;
    s->last_middle_ns = middle_ns;
}

/* Of request n, also of those before the first. */
static int64_t asked(const struct lc_steer *s, int64_t n)
{
    return n < 0 ? s->base_ns : s->asked_ns[n % LC_STEER_REMEMBERED];
}

/* The middle of the first frame that the next request's duration moves. */
static int64_t predicted_ns(const struct lc_steer *s)
{
    int64_t middle = s->last_middle_ns;

    for (int64_t n = (int64_t)s->last - s->delay; n < (int64_t)s->queued; n++)
        middle += asked(s, n);
    return middle;
}

/* So many frames of one length as are no shorter than `usual`; where that is too long, of one more and shorter. */
static int64_t fitting_ns(int64_t rest, int64_t usual, int64_t least, int64_t most)
{
    int64_t n = rest / usual;

    if (n >= 1 && rest / n <= most)
        return rest / n;
    if (rest / (n + 1) >= least)
        return rest / (n + 1);
    return usual;
}

int64_t lc_steer_next(struct lc_steer *s, int64_t floor_ns)
{
    int64_t least = s->least_ns > floor_ns ? s->least_ns : floor_ns;
    int64_t usual = s->base_ns > least ? s->base_ns : least;
    int64_t duration = usual;

    if (usual > s->most_ns)
        usual = duration = s->most_ns;
    if (s->on && s->known) {
        int64_t rest = s->target_ns - predicted_ns(s);

        if (rest > 0)
            duration = fitting_ns(rest, usual, least, s->most_ns);
    }
    s->asked_ns[s->queued % LC_STEER_REMEMBERED] = duration;
    s->queued++;
    return duration;
}
