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
    about(a, dataset);
    /* What was not tried here before the stop has its records until then, or was stopped before this process was there. */
    if (a->it.stopped_until_ns == 0)
        a->it.stopped_from_ns = a->it.trying_since_ns > 0 ? from_ns : INT64_MIN;
    a->it.stopped_until_ns = until_ns;
}

void absence_tried(struct absence *a, const char *dataset, int64_t since_ns)
{
    about(a, dataset);
    if (a->it.trying_since_ns == 0)
        a->it.trying_since_ns = since_ns;
}

void absence_over(struct absence *a)
{
    a->it = (struct ttf_absence){0};
}

struct ttf_absence absence_of(struct absence *a, const char *dataset)
{
    about(a, dataset);
    return a->it;
}
