/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "preview.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/manifest.h"

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
    for (unsigned i = 0; i < record.n_images; i++) {
        if (record.images[i].n_files == 0)
            continue;
        subject->images++;
        subject->last_index = record.index;
        break;
    }
    ttf_slot_record_free(&record);
    return 0;
}

static int begin(struct ttf_io *io, const char *folder, const char *name,
                 struct preview_subject *subject, struct ttf_err *err)
{
    struct ttf_manifest *manifest = malloc(sizeof *manifest);
    int r;

    if (!manifest)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    memset(subject, 0, sizeof *subject);
    (void)snprintf(subject->path, sizeof subject->path, "%s/%s", folder, name);
    r = ttf_manifest_load(io, subject->path, manifest, err);
    if (r == 0) {
        (void)snprintf(subject->name, sizeof subject->name, "%s", name);
        (void)snprintf(subject->uuid, sizeof subject->uuid, "%s", manifest->uuid);
    }
    free(manifest);
    return r;
}

int preview_find(struct ttf_io *io, const char *folder, struct preview_subject *subject,
                 struct ttf_err *err)
{
    char path[4300], newest[65];
    int r = ttf_growth_newest(io, folder, newest);

    if (r == -ENOENT)
        return r;
    if (r < 0)
        return ttf_err_set(err, r, folder, "cannot be listed");
    if (strcmp(newest, subject->name) != 0) {
        r = begin(io, folder, newest, subject, err);
        if (r < 0)
            return r;
    }
    (void)snprintf(path, sizeof path, "%s/records.jsonl", subject->path);
    r = ttf_growth_read(io, path, &subject->growth, 0, take_line, subject, err);
    if (r < 0)
        memset(subject, 0,
               sizeof *subject); /* it is another one by now: from its beginning, next time */
    return r;
}
