/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "preview.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/manifest.h"

#define NEWEST_LOOKED_AT 8

static bool has(const struct ttf_slot_record *record, const char *role)
{
    for (unsigned i = 0; i < record->n_images; i++) {
        for (unsigned k = 0; k < record->images[i].n_files; k++) {
            if (strcmp(record->images[i].files[k].role, role) == 0)
                return true;
        }
    }
    return false;
}

static int take_line(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct preview_subject *subject = ctx;
    struct ttf_slot_record record;
    int r;

    if (strcmp(line->type, "slot") != 0) {
        subject->ended = strcmp(line->type, "end") == 0;
        return 0;
    }
    subject->ended = false;
    r = ttf_growth_slot(line, &record, err);
    if (r < 0)
        return r == -ENOMEM ? r : 0;
    if (has(&record, "developed")) {
        subject->images++;
        subject->last_index = record.index;
    } else if (has(&record, "raw")) {
        subject->raw++;
    }
    ttf_slot_record_free(&record);
    return 0;
}

/* What is known of another one stays where this one's manifest cannot be read. */
static int begin(struct ttf_io *io, const char *folder, const char *name,
                 struct preview_subject *subject, struct ttf_err *err)
{
    struct ttf_manifest *manifest = malloc(sizeof *manifest);
    char path[sizeof subject->path];
    int r;

    if (!manifest)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    r = ttf_manifest_load(io, path, manifest, err);
    if (r == 0) {
        memset(subject, 0, sizeof *subject);
        memcpy(subject->path, path, sizeof path);
        (void)snprintf(subject->name, sizeof subject->name, "%s", name);
        (void)snprintf(subject->uuid, sizeof subject->uuid, "%s", manifest->uuid);
    }
    free(manifest);
    return r;
}

/* The newest whose manifest can be read; that of the subject is known to be one. */
static int choose(struct ttf_io *io, const char *folder, struct preview_subject *subject,
                  struct ttf_err *err)
{
    char passed_over[65] = "", name[65];
    int r = -ENOENT;

    for (unsigned i = 0; i < NEWEST_LOOKED_AT && r != 0; i++) {
        struct ttf_err why = {0};
        int found = ttf_growth_nth_newest(io, folder, i, name);

        if (found < 0)
            return i > 0 && found == -ENOENT ? r : ttf_err_set(err, found, folder, "has none");
        r = strcmp(name, subject->name) == 0 ? 0 : begin(io, folder, name, subject, &why);
        if (r == -ENOMEM)
            return ttf_err_set(err, r, NULL, "no memory");
        if (r < 0 && i == 0)
            memcpy(passed_over, name, sizeof passed_over);
        if (r < 0 && err)
            *err = why;
    }
    memcpy(subject->passed_over, passed_over, sizeof subject->passed_over);
    return r;
}

int preview_find(struct ttf_io *io, const char *folder, struct preview_subject *subject,
                 struct ttf_err *err)
{
    char path[4300];
    int r = choose(io, folder, subject, err);

    if (r < 0)
        return r;
    if (err)
        *err = (struct ttf_err){0};
    (void)snprintf(path, sizeof path, "%s/records.jsonl", subject->path);
    r = ttf_growth_read(io, path, &subject->growth, 0, take_line, subject, err);
    if (r < 0)
        memset(subject, 0,
               sizeof *subject); /* it is another one by now: from its beginning, next time */
    return r;
}
