/* SPDX-License-Identifier: Apache-2.0 */
#include "late_events.h"

#include <stdio.h>
#include <string.h>

/* One that tells of others is as many as they. */
static void lose(struct ttf_lost *lost, const struct ttf_job *event)
{
    struct ttf_lost one = event->lost;

    if (one.n == 0)
        one = (struct ttf_lost){.n = 1,
                                .first_ns = event->at_ns,
                                .first_utc_ns = event->at_utc_ns,
                                .last_ns = event->at_ns};
    if (lost->n == 0) {
        *lost = one;
        return;
    }
    lost->n += one.n;
    lost->last_ns = one.last_ns;
}

void ttf_late_events_lost(struct ttf_job *ret, const struct ttf_lost *lost)
{
    *ret = (struct ttf_job){.kind = TTF_JOB_EVENT,
                            .lost = *lost,
                            .at_ns = lost->first_ns,
                            .at_utc_ns = lost->first_utc_ns};
    snprintf(ret->event, sizeof(ret->event), "lost");
    snprintf(ret->text, sizeof(ret->text),
             "%u event%s lost, within %.0f s: the storage took none, and no more could wait",
             lost->n, lost->n == 1 ? " is" : "s are",
             (double)(lost->last_ns - lost->first_ns) / 1e9);
}

void ttf_late_events_keep(struct ttf_late_events *late, const struct ttf_job *event)
{
    struct ttf_lost lost = {0};

    if (late->n < TTF_LATE_EVENTS) {
        late->wait[late->n++] = *event;
        return;
    }
    if (late->n > TTF_LATE_EVENTS)
        lost = late->wait[TTF_LATE_EVENTS].lost;
    lose(&lost, event);
    ttf_late_events_lost(&late->wait[TTF_LATE_EVENTS], &lost);
    late->n = TTF_LATE_EVENTS + 1;
}

void ttf_late_events_drop_first(struct ttf_late_events *late)
{
    late->n--;
    memmove(&late->wait[0], &late->wait[1], late->n * sizeof(late->wait[0]));
}

struct ttf_lost ttf_late_events_all(const struct ttf_late_events *late)
{
    struct ttf_lost all = {0};

    for (unsigned i = 0; i < late->n; i++)
        lose(&all, &late->wait[i]);
    return all;
}
