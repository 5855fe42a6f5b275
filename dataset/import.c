/* SPDX-License-Identifier: Apache-2.0 */
/* import.c: frames from a source become the slots of a new, sealed dataset. */
#include "ttf/dataset/import.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export_staging.h"
#include "image_file_codecs.h"
#include "import_source.h"
#include "manifest_rules.h"
#include "ttf/dataset/writer.h"

struct import_run {
    struct ttf_io *io;
    const struct ttf_import_config *config;
    struct import_list list;
    struct import_source *source;
    int64_t interval_ns;
    struct ttf_image_range range; /* of floats, found or given */
    struct ttf_stream stream;
    struct staging staging;
    struct ttf_writer *writer;
    /* the first frame, which all others have to be like */
    uint32_t full_width, full_height; /* before cropping */
    enum ttf_sample first_format;
    char first_name[200];
    /* of the frame at hand */
    struct linear_map map;
    struct ttf_image_info map_info; /* that the map was made for */
    struct ttf_pixbuf linear;
    int64_t taken_utc_ns;
    struct ttf_import_result result;
};

static int open_source(struct import_run *run, struct ttf_err *err)
{
    if (run->source)
        run->source->ops->destroy(run->source);
    run->source = NULL;
    if (run->list.is_video)
        return import_video(run->config, &run->source, err);
    return import_pictures(&run->list, run->io, &run->source, err);
}

static void widen_range(const struct ttf_pixbuf *pixels, struct ttf_image_range *range)
{
    for (uint32_t y = 0; y < pixels->height; y++) {
        const float *row = ttf_pixbuf_row(pixels, y);

        for (size_t i = 0; i < (size_t)pixels->width * pixels->samples; i++) {
            double value = (double)row[i];

            if (isfinite(value)) {
                range->lo = fmin(range->lo, value);
                range->hi = fmax(range->hi, value);
            }
        }
    }
}

/* Floats have no full scale: a walk over all frames finds the least and the greatest value. */
static int find_range(struct import_run *run, struct ttf_err *err)
{
    struct ttf_image_range range = {INFINITY, -INFINITY};
    struct ttf_image_info info;
    struct ttf_pixbuf pixels;
    const char *name;
    int code;

    if (run->config->range.hi > run->config->range.lo) {
        run->range = run->config->range;
        return 0;
    }
    while ((code = run->source->ops->next(run->source, &pixels, &info, &name, err)) > 0) {
        bool floats = pixels.format == TTF_SAMPLE_F32;

        if (floats)
            widen_range(&pixels, &range);
        ttf_pixbuf_free(&pixels);
        if (!floats)
            break; /* by the first frame; a mixture is refused later */
    }
    if (code < 0)
        return code;
    run->range = (struct ttf_image_range){0.0, 1.0};
    if (range.lo < 0.0 || range.hi > 1.0) {
        if (run->config->transfer == TTF_TRANSFER_SRGB)
            return ttf_err_set(err, -EINVAL, run->config->inputs[0],
                               "floats from %g to %g are no sRGB codes, which lie in 0 to 1",
                               range.lo, range.hi);
        run->range = range;
        if (!(range.hi > range.lo)) /* all the same: some room that a double tells from it */
            run->range.hi = range.lo + fmax(1.0, fabs(range.lo) * 1e-6);
    }
    return open_source(run, err);
}

/* Checks that a frame is like the first one. */
static int check_frame(struct import_run *run, const struct ttf_pixbuf *pixels, const char *name,
                       struct ttf_err *err)
{
    if (pixels->width != run->full_width || pixels->height != run->full_height)
        ttf_err_set(err, -EINVAL, name, "is %u x %u pixels, but %s is %u x %u", pixels->width,
                    pixels->height, run->first_name, run->full_width, run->full_height);
    else if (run->stream.samples == 1 && pixels->samples > 2)
        ttf_err_set(err, -EINVAL, name, "is in colour, but %s is grey", run->first_name);
    else if ((pixels->format == TTF_SAMPLE_F32) != (run->first_format == TTF_SAMPLE_F32))
        ttf_err_set(err, -EINVAL, name, "holds %s samples, but %s holds %s",
                    ttf_sample_name(pixels->format), run->first_name,
                    ttf_sample_name(run->first_format));
    else
        return 0;
    ttf_err_hint(err, "all pictures of a sequence have to be alike; leave the odd one out");
    return -EINVAL;
}

static int set_region(struct import_run *run, const struct ttf_pixbuf *pixels, const char *name,
                      struct ttf_err *err)
{
    const struct ttf_region *region = &run->config->region;

    if (region->width == 0) {
        run->stream.width = pixels->width;
        run->stream.height = pixels->height;
        return 0;
    }
    if (region->height == 0 || region->x >= pixels->width || region->y >= pixels->height ||
        region->width > pixels->width - region->x || region->height > pixels->height - region->y)
        return ttf_err_set(
            err, -EINVAL, name, "the region %ux%u at %u, %u does not lie inside of %u x %u pixels",
            region->width, region->height, region->x, region->y, pixels->width, pixels->height);
    run->stream.width = region->width;
    run->stream.height = region->height;
    return 0;
}

static void set_encoding(struct import_run *run)
{
    struct ttf_stream *stream = &run->stream;

    stream->encoding = (struct ttf_encoding){.pedestal = 0.0, .scale = 65535.0};
    if (run->first_format == TTF_SAMPLE_F32 && (run->range.lo != 0.0 || run->range.hi != 1.0)) {
        stream->encoding.scale = 65535.0 / (run->range.hi - run->range.lo);
        stream->encoding.pedestal = 0.0 - run->range.lo * stream->encoding.scale;
    }
}

/* "000.png to 099.png, 100 files" */
static void describe_source(const struct import_run *run, char *ret, size_t size)
{
    const struct import_list *list = &run->list;
    const char *first = list->is_video ? run->config->inputs[0] : list->frame[0].path;

    if (run->config->n_inputs == 1)
        snprintf(ret, size, "%.200s", staging_base(first));
    else
        snprintf(ret, size, "%.100s to %.100s, %zu files", staging_base(first),
                 staging_base(list->frame[list->n - 1].path), run->config->n_inputs);
}

static int write_segment(struct import_run *run, struct ttf_err *err)
{
    struct ttf_segment segment = {.origin_utc_ns = TTF_NS_UNKNOWN,
                                  .uncertainty_ns = TTF_NS_UNKNOWN,
                                  .interval_ns = run->interval_ns,
                                  .plan = -1,
                                  .zone_offset_s = run->config->zone_offset_s};

    if (run->list.timed)
        segment.origin_utc_ns = run->list.frame[0].taken_utc_ns;
    else if (run->config->origin_utc_ns != 0)
        segment.origin_utc_ns = run->config->origin_utc_ns;
    /* A foreign clock: nobody here can vouch for it. */
    memcpy(segment.trust, "none", sizeof("none"));
    if (run->config->zone_offset_s == 0)
        memcpy(segment.zone, "UTC", sizeof("UTC"));
    return ttf_writer_segment(run->writer, &segment, err);
}

static int begin_dataset(struct import_run *run, const struct ttf_pixbuf *pixels, const char *name,
                         struct ttf_err *err)
{
    const struct ttf_import_config *config = run->config;
    struct ttf_stream *stream = &run->stream;
    struct ttf_manifest manifest;
    int code = ttf_manifest_init(&manifest, err);

    if (code)
        return code;
    run->full_width = pixels->width;
    run->full_height = pixels->height;
    run->first_format = pixels->format;
    snprintf(run->first_name, sizeof(run->first_name), "%.*s", (int)sizeof(run->first_name) - 1,
             staging_base(name));
    snprintf(stream->id, sizeof(stream->id), "%s", config->stream ? config->stream : "main");
    memcpy(stream->quantity, "radiance", sizeof("radiance"));
    memcpy(stream->unit, "1", sizeof("1"));
    stream->samples = pixels->samples >= 3 ? 3 : 1;
    stream->format = TTF_SAMPLE_U16;
    memcpy(stream->colour_space, "linear-srgb", sizeof("linear-srgb"));
    stream->mm_per_px = config->mm_per_px;
    stream->primary = true;
    set_encoding(run);
    code = set_region(run, pixels, name, err);
    if (code)
        return code;
    snprintf(manifest.title, sizeof(manifest.title), "%s",
             config->title ? config->title : staging_base(run->staging.final));
    describe_source(run, manifest.source, sizeof(manifest.source));
    manifest.n_streams = 1;
    manifest.streams[0] = *stream;
    code = ttf_writer_create(run->io, run->staging.temp, &manifest, NULL, NULL, &run->writer, err);
    return code ? code : write_segment(run, err);
}

/* The kept part of a frame as linear codes in run->linear. */
static int make_linear(struct import_run *run, const struct ttf_pixbuf *pixels,
                       const struct ttf_image_info *info, struct ttf_err *err)
{
    const struct ttf_stream *stream = &run->stream;
    const struct ttf_region *region = &run->config->region;
    const struct ttf_image_info *made = &run->map_info;
    struct ttf_pixbuf part;
    int code = 0;

    if (made->bits != info->bits || made->format != info->format ||
        made->transfer != info->transfer || run->result.frames == 0) {
        linear_map_free(&run->map);
        code = linear_map_init(&run->map, info, run->config->transfer, &run->range);
        run->map_info = *info;
    }
    if (!code && !run->linear.data)
        code = ttf_pixbuf_alloc(&run->linear, stream->width, stream->height, stream->samples,
                                TTF_SAMPLE_U16);
    if (!code)
        code = ttf_pixbuf_view(pixels, region->width ? region->x : 0, region->width ? region->y : 0,
                               stream->width, stream->height, &part);
    if (code)
        return ttf_err_set(err, code, NULL, "the frame cannot be converted: %s",
                           strerrordesc_np(-code));
    for (uint32_t y = 0; y < part.height; y++)
        linear_map_row(&run->map, ttf_pixbuf_row(&part, y), part.format, part.width, part.samples,
                       ttf_pixbuf_row(&run->linear, y), stream->samples);
    return 0;
}

static double mean_level(const struct import_run *run)
{
    const struct ttf_encoding *encoding = &run->stream.encoding;
    const struct ttf_pixbuf *linear = &run->linear;
    uint64_t sum = 0, n = (uint64_t)linear->width * linear->samples;

    for (uint32_t y = 0; y < linear->height; y++) {
        const uint16_t *row = ttf_pixbuf_row(linear, y);

        for (uint64_t i = 0; i < n; i++)
            sum += row[i];
    }
    return ((double)sum / (double)(n * linear->height) - encoding->pedestal) / encoding->scale;
}

static int produce_tiff(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct import_run *run = ctx;
    struct ttf_tiff_spec spec = {
        .icc = TTF_ICC_LINEAR,
        .times = {.start_utc_ns = run->taken_utc_ns, .zone_offset_s = run->config->zone_offset_s}};

    return ttf_tiff_write(io, file, &run->linear, &spec, err);
}

static int commit_missed(struct import_run *run, int64_t from, int64_t to, struct ttf_err *err)
{
    int code = 0;

    for (int64_t slot = from; slot < to && !code; slot++) {
        struct ttf_slot_record record;

        ttf_slot_record_init(&record);
        record.index = slot;
        record.due_ns = slot * run->interval_ns;
        record.result = TTF_RESULT_MISSED;
        snprintf(record.reason, sizeof(record.reason), "no image in the source");
        code = ttf_writer_commit(run->writer, &record, err);
        ttf_slot_record_free(&record);
        run->result.missed++;
    }
    return code;
}

static int commit_frame(struct import_run *run, int64_t slot, struct ttf_err *err)
{
    struct ttf_slot_record record;
    struct ttf_image *image;
    int code;

    ttf_slot_record_init(&record);
    record.index = slot;
    record.due_ns = slot * run->interval_ns;
    record.result = TTF_RESULT_CAPTURED;
    if (run->taken_utc_ns != TTF_NS_UNKNOWN)
        record.middle_ns = run->taken_utc_ns - run->list.frame[0].taken_utc_ns;
    code = ttf_slot_record_images(&record, 1);
    if (code) {
        ttf_slot_record_free(&record);
        return ttf_err_set(err, code, NULL, "no memory for a record");
    }
    image = &record.images[0];
    memcpy(image->stream, run->stream.id, sizeof(image->stream));
    image->n_averaged = 1;
    image->mean_level = mean_level(run);
    image->n_files = 1;
    code = ttf_writer_file(run->writer, "developed", run->stream.id, slot, -1, "tif", produce_tiff,
                           run, &image->files[0], err);
    if (!code)
        code = ttf_writer_commit(run->writer, &record, err);
    ttf_slot_record_free(&record);
    return code;
}

static int add_frame(struct import_run *run, const struct ttf_pixbuf *pixels,
                     const struct ttf_image_info *info, const char *name, struct ttf_err *err)
{
    int64_t slot = run->result.frames;
    int code;

    if (run->writer)
        code = check_frame(run, pixels, name, err);
    else
        code = begin_dataset(run, pixels, name, err);
    if (!code)
        code = make_linear(run, pixels, info, err);
    if (code)
        return code;
    run->taken_utc_ns = TTF_NS_UNKNOWN;
    if (!run->list.is_video) {
        const struct import_frame *frame = &run->list.frame[run->result.frames];

        slot = frame->slot;
        run->taken_utc_ns = frame->taken_utc_ns;
    }
    code = commit_missed(run, run->result.frames + run->result.missed, slot, err);
    if (!code)
        code = commit_frame(run, slot, err);
    run->result.frames++;
    run->result.alpha_dropped |=
        pixels->samples == 2 || pixels->samples == 4 || info->alpha_left_out;
    run->result.foreign_profile |= info->foreign_profile;
    return code;
}

static int add_all(struct import_run *run, struct ttf_err *err)
{
    const struct ttf_import_config *config = run->config;
    struct ttf_image_info info;
    struct ttf_pixbuf pixels;
    const char *name = NULL;
    int code;

    while ((code = run->source->ops->next(run->source, &pixels, &info, &name, err)) > 0) {
        code = add_frame(run, &pixels, &info, name, err);
        ttf_pixbuf_free(&pixels);
        if (code)
            return code;
        if (config->progress &&
            config->progress(config->progress_ctx, run->result.frames, run->source->total))
            return ttf_err_set(err, -ECANCELED, NULL, "the import was stopped");
    }
    if (!code && run->result.frames == 0)
        code = ttf_err_set(err, -EINVAL, config->inputs[0], "there is no frame in it");
    return code;
}

static int import_run(struct import_run *run, struct ttf_err *err)
{
    int code = import_list_make(&run->list, run->io, run->config, err);

    run->interval_ns = run->config->interval_ns;
    if (!code)
        code = open_source(run, err);
    if (!code && run->list.is_video && run->interval_ns == 0)
        run->interval_ns = run->source->frame_ns;
    if (!code)
        code = import_list_slots(&run->list, &run->interval_ns, err);
    if (!code && !run->list.is_video)
        code = find_range(run, err);
    if (!code)
        code = staging_begin(&run->staging, run->io, run->config->output, true, err);
    if (!code)
        code = add_all(run, err);
    if (!code)
        code = ttf_writer_seal(run->writer, "count", run->result.digest, err);
    ttf_writer_close(run->writer);
    if (code) {
        staging_name_final(&run->staging, err);
        staging_discard(&run->staging);
    } else {
        code = staging_commit(&run->staging, err);
    }
    return code;
}

/* Asked here because it is made under another name, which nobody typed. */
static bool good_name(const char *path)
{
    char name[66];
    size_t n = strlen(path);
    const char *at;

    while (n > 1 && path[n - 1] == '/')
        n--;
    for (at = path + n; at > path && at[-1] != '/';)
        at--;
    if ((size_t)(path + n - at) >= sizeof(name))
        return false;
    memcpy(name, at, (size_t)(path + n - at));
    name[path + n - at] = '\0';
    return ttf_name_ok(name);
}

int ttf_import(struct ttf_io *io, const struct ttf_import_config *config,
               struct ttf_import_result *ret, struct ttf_err *err)
{
    struct import_run *run;
    int code;

    if (!config->output || !good_name(config->output)) {
        ttf_err_set(err, -EINVAL, config->output, "is no name of a dataset");
        ttf_err_hint(err, "a dataset's name is 1 to 64 of A-Z a-z 0-9 . _ and -");
        return -EINVAL;
    }
    if (config->interval_ns < 0)
        return ttf_err_set(err, -EINVAL, NULL, "the interval is negative");
    run = calloc(1, sizeof(*run));
    if (!run)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to import");
    run->io = io;
    run->config = config;
    code = import_run(run, err);
    if (!code && ret) {
        *ret = run->result;
        ret->interval_ns = run->interval_ns;
        ret->width = run->stream.width;
        ret->height = run->stream.height;
        ret->samples = run->stream.samples;
    }
    if (run->source)
        run->source->ops->destroy(run->source);
    import_list_free(&run->list);
    linear_map_free(&run->map);
    ttf_pixbuf_free(&run->linear);
    free(run);
    return code;
}
