/* SPDX-License-Identifier: Apache-2.0 */
#include "calibration_of_run.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/reader.h"

struct own {
    unsigned n;
    char id[65];
};

static int take_own(void *ctx, const char *name, bool is_dir)
{
    struct own *own = ctx;

    if (is_dir && *name != '.' && strlen(name) < sizeof own->id) {
        own->n++;
        memcpy(own->id, name, strlen(name) + 1);
    }
    return 0;
}

/* It was to have one: pictures of a flat are reflectance. */
static int is_calibrated(struct ttf_io *io, const char *dataset, struct ttf_err *err)
{
    struct ttf_manifest *manifest = calloc(1, sizeof *manifest);
    int r;

    if (!manifest)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = ttf_manifest_load(io, dataset, manifest, err);
    for (unsigned i = 0; r == 0 && i < manifest->n_streams; i++)
        r = strcmp(manifest->streams[i].quantity, "reflectance") == 0;
    free(manifest);
    return r;
}

/* The calibration of the last picture that has one, if any has. */
static int find_last(struct ttf_reader *reader, struct own *own, struct ttf_err *err)
{
    int64_t i = ttf_reader_summary(reader)->slots;
    bool found = false;
    int r = 0;

    while (r == 0 && !found && i-- > 0) {
        struct ttf_slot_record record;

        ttf_slot_record_init(&record);
        r = ttf_reader_slot(reader, i, &record, err);
        for (unsigned k = 0; r == 0 && !found && k < record.n_images; k++) {
            found = *record.images[k].calibration != '\0';
            if (found)
                (void)snprintf(own->id, sizeof own->id, "%s", record.images[k].calibration);
        }
        ttf_slot_record_free(&record);
    }
    return r;
}

static int choose_last(struct ttf_io *io, const char *dataset, struct own *own, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    int r = ttf_reader_open(io, dataset, &reader, err);

    if (r < 0)
        return r;
    r = find_last(reader, own, err);
    ttf_reader_close(reader);
    return r;
}

int calibration_of_run(struct calibrations *c, struct ttf_io *io, const char *dataset, bool exists,
                       char ret[CALIBRATION_PATH], struct ttf_err *err)
{
    struct own own = {0};
    char folder[CALIBRATION_PATH];
    int r;

    if (!exists)
        return calibrations_in_use(c, ret, err);
    (void)snprintf(folder, sizeof folder, "%.600s/calibration", dataset);
    r = io->ops->list(io, folder, take_own, &own);
    if (r < 0 && r != -ENOENT)
        return ttf_err_set(err, r, folder, "cannot be read: %s", strerrordesc_np(-r));
    if (own.n == 0) {
        r = is_calibrated(io, dataset, err);
        return r == 1 ? calibrations_in_use(c, ret, err) : r;
    }
    r = own.n > 1 ? choose_last(io, dataset, &own, err) : 0;
    if (r < 0)
        return r;
    (void)snprintf(ret, CALIBRATION_PATH, "%.600s/calibration/%s", dataset, own.id);
    return 1;
}
