/* SPDX-License-Identifier: Apache-2.0 */
/* samples_read.c: samples.json as people and their tools left it. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "json_read.h"
#include "samples_private.h"
#include "ttf/dataset/json_parse.h"

const struct ttf_sample_region *ttf_samples_find(const struct ttf_sample_region *samples,
                                                 unsigned n, const char *id)
{
    for (unsigned i = 0; i < n; i++)
        if (strcmp(samples[i].id, id) == 0)
            return &samples[i];
    return NULL;
}

bool ttf_sample_rect_is_within(const struct ttf_sample_rect *region, int64_t width, int64_t height)
{
    return region->x >= 0 && region->y >= 0 && region->width > 0 && region->height > 0 &&
           region->width <= width && region->height <= height &&
           region->x <= width - region->width && region->y <= height - region->height;
}

static void read_region(struct ttf_json_in *in, const json_t *sample, struct ttf_sample_rect *ret)
{
    const json_t *region = ttf_in_object(in, sample, "region", TTF_JSON_REQUIRED);
    char at[sizeof(in->at)];

    memcpy(at, in->at, sizeof(at));
    ttf_in_at(in, "%.90sregion.", at);
    ret->x = ttf_in_int(in, region, "x", 0, INT32_MAX, 0, TTF_JSON_REQUIRED);
    ret->y = ttf_in_int(in, region, "y", 0, INT32_MAX, 0, TTF_JSON_REQUIRED);
    ret->width = ttf_in_int(in, region, "width", 1, INT32_MAX, 0, TTF_JSON_REQUIRED);
    ret->height = ttf_in_int(in, region, "height", 1, INT32_MAX, 0, TTF_JSON_REQUIRED);
}

static void read_samples(struct ttf_json_in *in, const json_t *list, size_t n,
                         struct ttf_sample_region *ret)
{
    for (size_t i = 0; i < n && !in->code; i++) {
        const json_t *sample = json_array_get(list, i);

        ttf_in_at(in, "samples[%zu].", i);
        ttf_in_text(in, sample, "id", ret[i].id, sizeof(ret->id), TTF_JSON_REQUIRED);
        ttf_in_text(in, sample, "title", ret[i].title, sizeof(ret->title), TTF_JSON_CUT);
        ttf_in_text(in, sample, "treatment", ret[i].treatment, sizeof(ret->treatment),
                    TTF_JSON_CUT);
        if (!in->code && ttf_samples_find(ret, (unsigned)i, ret[i].id))
            ttf_in_wrong(in, "id", "'%s' is there twice", ret[i].id);
        read_region(in, sample, &ret[i].region);
    }
}

int ttf_samples_parse(const char *text, size_t n, struct ttf_sample_region **ret, unsigned *ret_n,
                      json_t **ret_root, struct ttf_err *err)
{
    struct ttf_json_in in = {.where = "samples.json", .wrong = -EINVAL, .err = err};
    struct ttf_sample_region *samples;
    json_error_t parse;
    const json_t *list;
    json_t *root;
    size_t count;
    int r = ttf_json_parse(text, n, &root, &parse);

    if (r == -ENOMEM)
        return ttf_err_set(err, r, "samples.json", "no memory");
    if (r)
        return ttf_err_set(err, r, "samples.json", "it is not JSON: %s", parse.text);
    list = ttf_in_array(&in, root, "samples", TTF_JSON_REQUIRED);
    count = json_array_size(list);
    if (count > TTF_SAMPLES_MAX)
        ttf_in_wrong(&in, "samples", "has more than %u", TTF_SAMPLES_MAX);
    samples = calloc(count + 1, sizeof(*samples));
    if (!samples) {
        json_decref(root);
        return ttf_err_set(err, -ENOMEM, "samples.json", "no memory");
    }
    if (!in.code)
        read_samples(&in, list, count, samples);
    if (in.code || !ret_root)
        json_decref(root);
    if (in.code) {
        free(samples);
        return in.code;
    }
    if (ret_root)
        *ret_root = root;
    *ret = samples;
    *ret_n = (unsigned)count;
    return 0;
}

int ttf_samples_read(struct ttf_io *io, const char *path, struct ttf_sample_region **ret,
                     unsigned *ret_n, struct ttf_err *err)
{
    char *file = ttf_path_format("%s/samples.json", path);
    struct ttf_io_stat st;
    char *text = NULL;
    size_t n = 0;
    int r = file ? io->ops->stat(io, file, &st) : -ENOMEM;

    *ret = NULL;
    *ret_n = 0;
    if (r == 0)
        r = ttf_io_slurp(io, file, TTF_SAMPLES_BYTES_MAX, &text, &n, err);
    else if (r != -ENOENT)
        ttf_err_set(err, r, path, "samples.json cannot be read: %s", strerrordesc_np(-r));
    if (r == 0)
        r = ttf_samples_parse(text, n, ret, ret_n, NULL, err);
    free(text);
    free(file);
    return r == -ENOENT ? 0 : r;
}
