/* SPDX-License-Identifier: Apache-2.0 */
#include "calibration_of_run.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/growth.h"
#include "ttf/dataset/manifest.h"

/* What a dataset has of its own. */
struct own {
    unsigned folders;
    char recorded
        [65]; /* the last one that was brought there whole: behind its files comes its line */
    char of_picture[65]; /* of the last picture that has one */
};

static int count_folder(void *ctx, const char *name, bool is_dir)
{
    struct own *own = ctx;

    own->folders += is_dir && *name != '.';
    return 0;
}

static void take_id(const json_t *id, char ret[65])
{
    const char *text = json_string_value(id);

    if (text && *text != '\0')
        (void)snprintf(ret, 65, "%s", text);
}

/* ttf_growth_fn. 1: enough is known. */
static int take_line(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct own *own = ctx;
    const json_t *image;
    size_t i;

    (void)err;
    if (strcmp(line->type, "calibration") == 0) {
        take_id(json_object_get(line->json, "id"), own->recorded);
        return own->folders == 1;
    }
    json_array_foreach(json_object_get(line->json, "images"), i, image)
        take_id(json_object_get(image, "calibration"), own->of_picture);
    return 0;
}

/* A folder alone says little: a box that lost its power may have copied half of it. */
static int find_own(struct ttf_io *io, const char *dataset, struct own *ret, struct ttf_err *err)
{
    struct ttf_growth growth = {0};
    char path[CALIBRATION_PATH];
    int r;

    *ret = (struct own){0};
    (void)snprintf(path, sizeof path, "%.600s/calibration", dataset);
    r = io->ops->list(io, path, count_folder, ret);
    if (r < 0 && r != -ENOENT)
        return ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    if (ret->folders == 0)
        return 0;
    (void)snprintf(path, sizeof path, "%.600s/records.jsonl", dataset);
    r = ttf_growth_read(io, path, &growth, 0, take_line, ret, err);
    return r < 0 ? r : 0;
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

int calibration_of_run(struct calibrations *c, struct ttf_io *io, const char *dataset, bool exists,
                       char ret[CALIBRATION_PATH], struct ttf_err *err)
{
    struct own own;
    int r;

    if (!exists)
        return calibrations_in_use(c, ret, err);
    r = find_own(io, dataset, &own, err);
    if (r < 0)
        return r;
    if (own.recorded[0] == '\0') {
        r = is_calibrated(io, dataset, err);
        return r == 1 ? calibrations_in_use(c, ret, err) : r;
    }
    (void)snprintf(ret, CALIBRATION_PATH, "%.600s/calibration/%s", dataset,
                   own.of_picture[0] != '\0' ? own.of_picture : own.recorded);
    return 1;
}
