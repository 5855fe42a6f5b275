/* SPDX-License-Identifier: Apache-2.0 */
/* What must hold of a run of chaos after each boot, however that ended. */
#include "chaos.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "second_run.h"
#include "ttf/dataset/verify.h"

/* Whole lines that were there must be there for ever; alone: and nobody added one. */
static void check_grown(struct chaos *c, unsigned storage, const char *name, bool alone,
                        char **before)
{
    char dataset[128], path[160];
    char *now = NULL;
    char *end;
    size_t bytes;

    chaos_part_path(c, storage, dataset);
    snprintf(path, sizeof(path), "%s/%s", dataset, name);
    if (ttf_io_slurp(ttf_io_posix(), path, 1 << 26, &now, &bytes, NULL) < 0) {
        if (*before)
            chaos_fail(c, "storage %u: %s is gone", storage, name);
        return;
    }
    end = strrchr(now, '\n');
    if (end)
        end[1] = '\0';
    else
        now[0] = '\0';
    if (*before && strncmp(now, *before, strlen(*before)) != 0)
        chaos_fail(c, "storage %u: %s lost or changed lines", storage, name);
    if (*before && alone && strlen(now) != strlen(*before))
        chaos_fail(c, "storage %u: %s has grown, and the run was not there any more", storage,
                   name);
    free(*before);
    *before = now;
}

void chaos_check_verify(struct chaos *c, unsigned storage, bool deep, bool clean)
{
    struct ttf_verify_options options = {.deep = deep};
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    char path[128];
    bool here = storage == c->second.begun;
    int r;

    chaos_part_path(c, storage, path);
    r = ttf_verify(ttf_io_posix(), path, &options, &report, &err);
    if (r < 0) {
        chaos_fail(c, "verify of storage %u: %d: %s: %s", storage, r, err.where, err.what);
        return;
    }
    for (unsigned i = 0; i < report.n_findings; i++) {
        const struct ttf_verify_finding *f = &report.findings[i];

        if (f->severity != TTF_FINDING_LEFTOVER && (f->severity == TTF_FINDING_DAMAGE || clean))
            chaos_fail(c, "verify of storage %u: %s: %s: %s", storage,
                       ttf_severity_name(f->severity), f->file, f->text);
    }
    /* If the seal's last sync fails, it may be there all the same. */
    if (here && c->run.code == 0 && !c->killed && report.sealed != c->run.result.sealed)
        chaos_fail(c, "sealed %d, but the session said %d", report.sealed, c->run.result.sealed);
    if (!here && report.sealed)
        chaos_fail(c, "storage %u is sealed, and the run is not there", storage);
    ttf_verify_report_free(&report);
}

/* Unless it was cut off in the middle of it, or what it has moved to fails as well, it says there why. */
static void check_said(struct chaos *c)
{
    struct sim_run second = second_run_of(&c->run);

    if (c->run.alarms == 0)
        chaos_fail(c, "it moved, and nobody was told");
    if (!c->troubled[1] && sim_run_events(&second, "storage", NULL) == 0)
        chaos_fail(c, "it moved, and no event says why");
}

/* The run's way from one storage to the other, as far as this boot had part in it. */
static void check_move(struct chaos *c, bool was_begun)
{
    const struct sim_run *run = &c->run;

    if (was_begun && !c->second.begun)
        chaos_fail(c, "the run had been gone on with in the second storage, and is not there");
    if (c->second.begun && !c->troubled[0])
        chaos_fail(c, "it moved to the second storage, and nothing was wrong with the first");
    if (run->code == 0 && !c->killed && run->result.second_storage != c->second.begun)
        chaos_fail(c, "it ended in the second storage: %d; it said %d", c->second.begun,
                   run->result.second_storage);
    if (c->second.begun && !was_begun && run->code != -ESHUTDOWN && !c->killed)
        check_said(c);
}

/* What fails in the first ends no run that was begun, as long as the second is well: but for a seal that is all that is missing. */
static void check_ended(struct chaos *c, const struct chaos_parts *parts)
{
    const struct sim_run *run = &c->run;
    bool storage = run->code == -EIO || run->code == -ENOSPC || run->code == -EROFS;

    if (!c->second.named || c->troubled[1] || !storage || parts->n == 0 ||
        ttf_reader_summary(parts->part[0].reader)->n_segments == 0 ||
        strcmp(run->err.where, "main") == 0) /* a camera's */
        return;
    if (run->result.total == 0 || chaos_parts_last(parts) + 1 < run->result.total)
        chaos_fail(c, "it ended with %d, and the second storage is well: %s: %s", run->code,
                   run->err.where, run->err.what);
}

/* What was told of each slot is what its record says. */
static void check_told(struct chaos *c, const struct chaos_parts *parts)
{
    for (unsigned i = 0; i < parts->n; i++)
        for (int64_t k = 0; k < parts->part[i].slots; k++) {
            enum ttf_result result;
            int64_t index;

            if (ttf_reader_brief(parts->part[i].reader, k, &index, &result) == 0 &&
                index < CHAOS_TOLD_MAX && c->told_result[index] != 0 &&
                c->told_result[index] != (char)result + 1)
                chaos_fail(c, "slot %lld was told as %s, its record says %s", (long long)index,
                           ttf_result_name((enum ttf_result)(c->told_result[index] - 1)),
                           ttf_result_name(result));
        }
}

static void check_last(struct chaos *c, const struct chaos_parts *parts)
{
    int64_t last = chaos_parts_last(parts);

    if (last < c->told)
        chaos_fail(c, "slot %lld was told, %lld is the last", (long long)c->told, (long long)last);
    /* A record that reached the disk while the power went was not told any more. */
    c->told = last;
}

void chaos_check_boot(struct chaos *c)
{
    const bool was_begun = c->second.begun;
    struct chaos_parts parts;

    if (!chaos_part_exists(c, 0) && !c->second.gone) {
        if (c->told >= 0 || c->kept[0].records)
            chaos_fail(c, "the dataset is gone");
        return;
    }
    if (!chaos_parts_open(c, &parts))
        return;
    c->second.begun = parts.n > 0 && parts.part[parts.n - 1].storage == 1;
    check_move(c, was_begun);
    check_ended(c, &parts);
    for (unsigned storage = 0; storage < 2; storage++) {
        if (!chaos_part_exists(c, storage))
            continue;
        check_grown(c, storage, "records.jsonl", storage == 0 && was_begun,
                    &c->kept[storage].records);
        check_grown(c, storage, "events.jsonl", storage == 0 && was_begun,
                    &c->kept[storage].events);
        chaos_check_verify(c, storage, false, false);
    }
    check_told(c, &parts);
    check_last(c, &parts);
    if (!c->second.gone) /* else some of it may be there */
        chaos_asks_check(c, &parts);
    chaos_parts_close(&parts);
}
