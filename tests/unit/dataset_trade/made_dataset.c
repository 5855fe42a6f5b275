/* SPDX-License-Identifier: Apache-2.0 */
#include "made_dataset.h"

#include <stdio.h>
#include <string.h>

#include "trade_test.h"
#include "ttf/dataset/tiff.h"

static const struct ttf_encoding captured = {.pedestal = TTF_PEDESTAL, .scale = TTF_SCALE};

void add_stream(struct ttf_manifest *manifest, const char *id, uint32_t samples,
                enum ttf_sample format)
{
    struct ttf_stream *stream = &manifest->streams[manifest->n_streams++];

    snprintf(stream->id, sizeof(stream->id), "%s", id);
    snprintf(stream->quantity, sizeof(stream->quantity), "reflectance");
    snprintf(stream->unit, sizeof(stream->unit), "1");
    snprintf(stream->colour_space, sizeof(stream->colour_space), "linear-srgb");
    stream->width = MADE_W;
    stream->height = MADE_H;
    stream->samples = samples;
    stream->format = format;
    stream->encoding = captured;
    if (format == TTF_SAMPLE_U8)
        stream->encoding = (struct ttf_encoding){.pedestal = 0, .scale = 255};
    if (format == TTF_SAMPLE_F16 || format == TTF_SAMPLE_F32)
        stream->encoding = (struct ttf_encoding){.pedestal = 0, .scale = 1};
    stream->primary = manifest->n_streams == 1;
}

struct ttf_writer *create(const char *path, const struct ttf_manifest *manifest)
{
    struct ttf_writer *writer = NULL;
    struct ttf_err err = {0};

    if (ttf_writer_create(ttf_io_posix(), path, manifest, NULL, NULL, &writer, &err))
        fail_msg("%s: %s", err.where, err.what);
    return writer;
}

void add_segment(struct ttf_writer *writer, int number, int64_t first, int64_t utc_ns)
{
    struct ttf_segment segment = {.segment = number,
                                  .first_index = first,
                                  .origin_ns = (number + 1) * TTF_NS_PER_H, /* of its own boot */
                                  .origin_utc_ns = utc_ns,
                                  .trust = "ntp",
                                  .uncertainty_ns = TTF_NS_UNKNOWN,
                                  .interval_ns = TTF_NS_PER_MIN,
                                  .plan = -1,
                                  .zone = "UTC"};
    struct ttf_err err = {0};

    if (utc_ns == TTF_NS_UNKNOWN)
        memcpy(segment.trust, "none", sizeof("none"));
    if (ttf_writer_segment(writer, &segment, &err))
        fail_msg("%s: %s", err.where, err.what);
}

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct ttf_pixbuf *pixels = ctx;
    const struct ttf_tiff_spec spec = {.icc = pixels->format == TTF_SAMPLE_F32 ? TTF_ICC_NONE
                                                                               : TTF_ICC_LINEAR,
                                       .times = {.start_utc_ns = TTF_NS_UNKNOWN}};

    return ttf_tiff_write(io, file, ctx, &spec, err);
}

static void add_file(struct ttf_writer *writer, struct ttf_image *image, int64_t index,
                     const char *role, struct ttf_pixbuf *pixels)
{
    struct ttf_err err = {0};

    if (pixels && ttf_writer_file(writer, role, image->stream, index, image->bracket, "tif",
                                  produce, pixels, &image->files[image->n_files++], &err))
        fail_msg("%s: %s", err.where, err.what);
}

void add_slot(struct ttf_writer *writer, int64_t index, int segment, int64_t due_ns,
              const struct shot *shots, unsigned n)
{
    struct ttf_slot_record record;
    struct ttf_err err = {0};

    ttf_slot_record_init(&record);
    record.index = index;
    record.segment = segment;
    record.due_ns = due_ns;
    assert_int_equal(ttf_slot_record_images(&record, n), 0);
    for (unsigned i = 0; i < n; i++) {
        struct ttf_image *image = &record.images[i];

        snprintf(image->stream, sizeof(image->stream), "%s", shots[i].stream);
        image->bracket = shots[i].bracket;
        image->relative_exposure = shots[i].relative_exposure;
        if (!shots[i].pixels) {
            record.result = TTF_RESULT_PARTIAL;
            snprintf(record.reason, sizeof(record.reason), "lamp off");
            snprintf(image->lacking, sizeof(image->lacking), "lamp off");
            continue;
        }
        image->n_averaged = 1;
        add_file(writer, image, index, "developed", shots[i].pixels);
    }
    if (ttf_writer_commit(writer, &record, &err))
        fail_msg("%s: %s", err.where, err.what);
    ttf_slot_record_free(&record);
}

void add_slot_beside(struct ttf_writer *writer, int64_t index, int64_t due_ns,
                     struct ttf_pixbuf *pixels, struct ttf_pixbuf *uncertainty,
                     struct ttf_pixbuf *mask)
{
    struct ttf_slot_record record;
    struct ttf_image *image;
    struct ttf_err err = {0};

    ttf_slot_record_init(&record);
    record.index = index;
    record.due_ns = due_ns;
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    image = &record.images[0];
    snprintf(image->stream, sizeof(image->stream), "main");
    image->n_averaged = 1;
    add_file(writer, image, index, "developed", pixels);
    add_file(writer, image, index, "uncertainty", uncertainty);
    add_file(writer, image, index, "mask", mask);
    if (ttf_writer_commit(writer, &record, &err))
        fail_msg("%s: %s", err.where, err.what);
    ttf_slot_record_free(&record);
}

struct ttf_reader *open_reader(const char *path)
{
    struct ttf_reader *reader = NULL;
    struct ttf_err err = {0};

    if (ttf_reader_open(ttf_io_posix(), path, &reader, &err))
        fail_msg("%s: %s", err.where, err.what);
    return reader;
}
