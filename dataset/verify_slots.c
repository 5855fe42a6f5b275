/* SPDX-License-Identifier: Apache-2.0 */
/* verify: which slots are concerned when a line or a file that is no image is damaged. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "verify_private.h"

void ttf_verify_use(struct ttf_verify_run *run, const char *folder, int64_t slot)
{
    struct ttf_verify_use *grown;
    unsigned i;

    for (i = run->n_uses; i-- > 0;) /* the one in use now is the last, mostly */
        if (strcmp(run->uses[i].folder, folder) == 0) {
            run->uses[i].last = slot;
            return;
        }
    grown = reallocarray(run->uses, run->n_uses + 1, sizeof(*grown));
    if (!grown) {
        run->failed = -ENOMEM;
        return;
    }
    run->uses = grown;
    grown[run->n_uses] = (struct ttf_verify_use){.first = slot, .last = slot};
    snprintf(grown[run->n_uses].folder, sizeof(grown->folder), "%s", folder);
    run->n_uses++;
}

/*
 * What the line says of its slot may be just what is wrong, so its place counts: it is of
 * the slot that is due there. A line that is of no slot has no "due_ns" and no such type.
 */
void ttf_verify_bad_line(struct ttf_verify_run *run, const char *line, size_t n)
{
    static const char type[] = "\"type\":\"slot\"", due[] = "\"due_ns\":";
    struct ttf_verify_report *report = run->report;
    unsigned at = report->n_findings - 1;

    if (!line ||
        (!memmem(line, n, type, sizeof(type) - 1) && !memmem(line, n, due, sizeof(due) - 1)))
        return;
    if (run->bad_to != at)
        run->bad_from = at;
    run->bad_to = at + 1;
    report->findings[at].slot = report->findings[at].last_slot =
        run->next_index + (int64_t)(at - run->bad_from);
}

/* Indices may have holes: then several slots may be meant. */
void ttf_verify_next_slot(struct ttf_verify_run *run, int64_t index)
{
    unsigned i, n = run->bad_to - run->bad_from;

    if (n > 0 && index > run->next_index && index != run->next_index + (int64_t)n)
        for (i = run->bad_from; i < run->bad_to; i++) {
            run->report->findings[i].slot = run->next_index;
            run->report->findings[i].last_slot = index - 1;
        }
    run->bad_from = run->bad_to = 0;
}

void ttf_verify_name_slots(struct ttf_verify_run *run)
{
    struct ttf_verify_finding *finding;
    unsigned i, k;

    for (i = 0; i < run->report->n_findings; i++)
        for (k = 0; k < run->n_uses; k++) {
            finding = &run->report->findings[i];
            if (strncmp(finding->file, run->uses[k].folder, strlen(run->uses[k].folder)) != 0)
                continue;
            finding->slot = run->uses[k].first;
            finding->last_slot = run->uses[k].last;
        }
}
