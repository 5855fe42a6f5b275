/* SPDX-License-Identifier: Apache-2.0 */
#include "absence.h"

#include <stdio.h>
#include <string.h>

static void about(struct absence *a, const char *dataset)
{
    if (strcmp(a->dataset, dataset) == 0)
        return;
    *a = (struct absence){0};
    (void)snprintf(a->dataset, sizeof a->dataset, "%s", dataset);
}

void absence_rested(struct absence *a, const char *dataset, int64_t from_ns, int64_t until_ns)
{
    struct ttf_absence *it = &a->it;

    about(a, dataset);
    if (it->n_stops > 0 && !a->tried) { /* gone on with, and stopped again before it was tried */
        it->stops[it->n_stops - 1].until_ns = until_ns;
        return;
    }
    if (it->n_stops == TTF_ABSENCE_STOPS) /* the oldest is told as time in which it was tried */
        memmove(&it->stops[0], &it->stops[1], --it->n_stops * sizeof it->stops[0]);
    /* What was not tried here before the stop has its records until then, or was stopped before this process was there. */
    it->stops[it->n_stops++] = (struct ttf_absence_stop){
        .from_ns = it->trying_since_ns > 0 ? from_ns : INT64_MIN, .until_ns = until_ns};
    a->tried = false;
}

void absence_tried(struct absence *a, const char *dataset, int64_t since_ns)
{
    about(a, dataset);
    a->tried = true;
    if (a->it.trying_since_ns == 0)
        a->it.trying_since_ns = since_ns;
}

void absence_over(struct absence *a)
{
    a->it = (struct ttf_absence){0};
    a->tried = false;
}

struct ttf_absence absence_of(struct absence *a, const char *dataset)
{
    about(a, dataset);
    return a->it;
}
