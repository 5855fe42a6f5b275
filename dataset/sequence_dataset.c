/* SPDX-License-Identifier: Apache-2.0 */
/* sequence_dataset.c: the developed images of one stream, read by rows from their TIFFs. */
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "sequence_frames.h"
#include "ttf/base/checked.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/tiff.h"

/*
 * Open files kept: a walk down all rows of a few frames does not open them anew each time. Each holds a decoded
 * strip, so one whose last row was read is closed, and so is one that a walk over other frames has left behind.
 */
#define OPEN_MAX 16
#define USES_MAX (4 * OPEN_MAX) /* of others: then it is left behind */

struct open_file {
    struct ttf_tiff_reader *tiff; /* NULL: slot is free */
    uint32_t t;
    uint64_t used; /* larger is later */
    bool busy;     /* some thread reads from it */
};

struct dataset_sequence {
    struct ttf_sequence base; /* first: downcast by address */
    struct ttf_io *io;
    struct sequence_frames frames;
    uint32_t samples;             /* of the files */
    enum ttf_sample format;       /* of rows as they are read: F32 also of F16 files */
    struct ttf_encoding encoding; /* of the files */
    pthread_mutex_t lock;         /* guards what follows */
    uint64_t uses;
    struct open_file open[OPEN_MAX];
};

static int open_frame(const struct dataset_sequence *dataset, uint32_t t,
                      struct ttf_tiff_reader **ret, struct ttf_err *err)
{
    const char *path = dataset->frames.path[t];
    struct ttf_tiff_reader *tiff;
    const struct ttf_tiff_info *info;
    int code = ttf_tiff_reader_open(dataset->io, path, &tiff, err);

    if (code)
        return code;
    info = ttf_tiff_reader_info(tiff);
    if (info->width != dataset->base.width || info->height != dataset->base.height ||
        info->samples != dataset->samples || info->format != dataset->format) {
        code = ttf_err_set(err, -TTF_EDAMAGED, path,
                           "the image is %u x %u x %u %s, but its stream is %u x %u x %u %s",
                           info->width, info->height, info->samples, ttf_sample_name(info->format),
                           dataset->base.width, dataset->base.height, dataset->samples,
                           ttf_sample_name(dataset->format));
        ttf_tiff_reader_close(tiff);
        return code;
    }
    *ret = tiff;
    return 0;
}

/* Takes an idle open file of frame t out of the cache, marked busy; NULL if there is none. */
static struct ttf_tiff_reader *take_open(struct dataset_sequence *dataset, uint32_t t)
{
    struct ttf_tiff_reader *tiff = NULL;

    pthread_mutex_lock(&dataset->lock);
    for (int i = 0; i < OPEN_MAX && !tiff; i++) {
        struct open_file *file = &dataset->open[i];

        if (file->tiff && !file->busy && file->t == t) {
            file->busy = true;
            tiff = file->tiff;
        }
    }
    pthread_mutex_unlock(&dataset->lock);
    return tiff;
}

/* The place of a file in the cache; of one that is not in it, the place that it may have. NULL: all are busy. */
static struct open_file *place_for(struct dataset_sequence *dataset,
                                   const struct ttf_tiff_reader *tiff)
{
    struct open_file *best = NULL;

    for (int i = 0; i < OPEN_MAX; i++) {
        struct open_file *file = &dataset->open[i];

        if (file->tiff == tiff)
            return file;
        if (!file->busy && (!best || file->used < best->used))
            best = file;
    }
    return best;
}

/* Takes a file that was left behind out of the cache, to be closed; NULL: there is none. */
static struct ttf_tiff_reader *take_left(struct dataset_sequence *dataset)
{
    for (int i = 0; i < OPEN_MAX; i++) {
        struct open_file *file = &dataset->open[i];
        struct ttf_tiff_reader *tiff = file->tiff;

        if (tiff && !file->busy && dataset->uses - file->used > USES_MAX) {
            *file = (struct open_file){0};
            return tiff;
        }
    }
    return NULL;
}

/* Gives a file back (done: it is not to be used again); what falls out of the cache is closed. */
static void give_back(struct dataset_sequence *dataset, uint32_t t, struct ttf_tiff_reader *tiff,
                      bool done)
{
    struct ttf_tiff_reader *drop = tiff;
    struct open_file *place;

    pthread_mutex_lock(&dataset->lock);
    place = place_for(dataset, tiff);
    if (place && place->tiff == tiff && done) {
        *place = (struct open_file){0};
    } else if (place && !done) {
        drop = place->tiff != tiff ? place->tiff : NULL;
        *place = (struct open_file){.tiff = tiff, .t = t, .used = ++dataset->uses};
    }
    if (!drop)
        drop = take_left(dataset);
    pthread_mutex_unlock(&dataset->lock);
    ttf_tiff_reader_close(drop);
}

/* The file's samples, in the first part of dst, to three 16-bit ones, from the end so that nothing is overwritten. */
static void widen(const struct dataset_sequence *dataset, uint16_t *dst, size_t pixels)
{
    const uint8_t *bytes = (const uint8_t *)dst;
    uint32_t samples = dataset->samples;

    for (size_t i = pixels; i-- > 0;) {
        uint16_t rgb[3];

        for (uint32_t c = 0; c < 3; c++) {
            size_t at = i * samples + (samples >= 3 ? c : 0);

            rgb[c] = dataset->format == TTF_SAMPLE_U8 ? (uint16_t)(bytes[at] * 257u) : dst[at];
        }
        memcpy(dst + i * 3, rgb, sizeof(rgb));
    }
}

/* Rows as the file has them. */
static int read_samples(struct dataset_sequence *dataset, uint32_t t, uint32_t y0, uint32_t rows,
                        void *dst, struct ttf_err *err)
{
    const struct ttf_sequence *sequence = &dataset->base;
    size_t stride = (size_t)sequence->width * dataset->samples * ttf_sample_bytes(dataset->format);
    struct ttf_tiff_reader *tiff;
    int code;

    if (t >= sequence->n || y0 > sequence->height || rows > sequence->height - y0)
        return ttf_err_set(err, -EINVAL, NULL, "rows %u+%u of frame %u are outside of the sequence",
                           y0, rows, t);
    if (rows == 0)
        return 0;
    tiff = take_open(dataset, t);
    if (!tiff) {
        code = open_frame(dataset, t, &tiff, err);
        if (code)
            return code;
    }
    code = ttf_tiff_reader_rows(tiff, y0, rows, dst, stride, err);
    give_back(dataset, t, tiff, code != 0 || y0 + rows == sequence->height);
    return code;
}

static int dataset_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                             uint16_t *dst, struct ttf_err *err)
{
    struct dataset_sequence *dataset = (struct dataset_sequence *)sequence;
    int code = read_samples(dataset, t, y0, rows, dst, err);

    if (code)
        return code;
    if (dataset->samples != 3 || dataset->format != TTF_SAMPLE_U16)
        widen(dataset, dst, (size_t)rows * sequence->width);
    return 0;
}

static int dataset_read_values(struct ttf_sequence *sequence, uint32_t t, uint32_t y0,
                               uint32_t rows, float *dst, struct ttf_err *err)
{
    struct dataset_sequence *dataset = (struct dataset_sequence *)sequence;
    const struct ttf_encoding *e = &dataset->encoding;
    size_t pixels = (size_t)rows * sequence->width;
    int code = read_samples(dataset, t, y0, rows, dst, err);

    /* From the end, as grey becomes three. */
    for (size_t i = code ? 0 : pixels; i-- > 0;) {
        float rgb[3];

        for (size_t c = 0; c < 3; c++) {
            float sample = dst[i * dataset->samples + (dataset->samples == 3 ? c : 0)];

            rgb[c] = (float)(((double)sample - e->pedestal) / e->scale);
        }
        memcpy(dst + i * 3, rgb, sizeof(rgb));
    }
    return code;
}

/* Values spread over 16 bits, a row at a time: three floats are twice the room of three codes. */
static int float_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                           uint16_t *dst, struct ttf_err *err)
{
    size_t n = (size_t)sequence->width * 3;
    float *row = malloc(n * sizeof(*row));
    int code = 0;

    if (!row)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a row");
    for (uint32_t y = 0; y < rows && !code; y++) {
        code = dataset_read_values(sequence, t, y0 + y, 1, row, err);
        for (size_t i = 0; i < n && !code; i++) {
            double c = row[i] * sequence->encoding.scale + sequence->encoding.pedestal + 0.5;

            dst[y * n + i] = !(c > 0) ? 0 : (c >= 65535 ? 65535 : (uint16_t)c);
        }
    }
    free(row);
    return code;
}

static void dataset_destroy(struct ttf_sequence *sequence)
{
    struct dataset_sequence *dataset = (struct dataset_sequence *)sequence;

    for (int i = 0; i < OPEN_MAX; i++)
        ttf_tiff_reader_close(dataset->open[i].tiff);
    pthread_mutex_destroy(&dataset->lock);
    sequence_frames_free(&dataset->frames);
    free(dataset);
}

/* Their codes are all there is to say. */
static const struct ttf_sequence_ops dataset_ops = {
    .read_rows = dataset_read_rows,
    .destroy = dataset_destroy,
};

static const struct ttf_sequence_ops float_ops = {
    .read_rows = float_read_rows,
    .read_values = dataset_read_values,
    .destroy = dataset_destroy,
};

/* The least and the greatest finite value of all frames. */
static int find_range(struct dataset_sequence *dataset, float ret[2], struct ttf_err *err)
{
    size_t n = (size_t)dataset->base.width * 3;
    float *row = malloc(n * sizeof(*row));
    bool any = false;
    int code = 0;

    ret[0] = ret[1] = 0;
    if (!row)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a row");
    for (uint32_t t = 0; t < dataset->base.n && !code; t++) {
        for (uint32_t y = 0; y < dataset->base.height && !code; y++) {
            code = dataset_read_values(&dataset->base, t, y, 1, row, err);
            for (size_t i = 0; i < n && !code; i++) {
                if (!isfinite(row[i]))
                    continue;
                ret[0] = any && ret[0] < row[i] ? ret[0] : row[i];
                ret[1] = any && ret[1] > row[i] ? ret[1] : row[i];
                any = true;
            }
        }
    }
    free(row);
    return code;
}

/* Floats have no codes of their own: what they reach becomes the range. */
static int spread_floats(struct dataset_sequence *dataset, struct ttf_err *err)
{
    float range[2];
    int code = find_range(dataset, range, err);
    double span = range[1] > range[0] ? (double)range[1] - range[0] : 1.0;

    dataset->base.encoding = (struct ttf_encoding){
        .pedestal = -range[0] * (65535.0 / span),
        .scale = 65535.0 / span,
    };
    return code;
}

static int check_stream(const struct ttf_stream *stream, const char *path, struct ttf_err *err)
{
    if (stream->samples != 1 && stream->samples != 3)
        return ttf_err_set(err, -ENOTSUP, path, "stream '%s' has %u samples a pixel, not 1 or 3",
                           stream->id, stream->samples);
    if (stream->width == 0 || stream->height == 0 || !(stream->encoding.scale > 0))
        return ttf_err_set(err, -EINVAL, path, "stream '%s' has no size or no scale", stream->id);
    return 0;
}

/* A stream as it would be that had the files of another role for its own. */
static int as_beside(struct ttf_io *io, const char *role, const char *first,
                     struct ttf_stream *stream, struct ttf_err *err)
{
    struct ttf_tiff_reader *tiff;
    const struct ttf_tiff_info *info;
    int code = ttf_tiff_reader_open(io, first, &tiff, err);

    if (code)
        return code;
    info = ttf_tiff_reader_info(tiff);
    stream->samples = info->samples;
    stream->format = info->format;
    stream->encoding.pedestal = 0;
    if (info->format == TTF_SAMPLE_F32)
        stream->encoding.scale = 1;
    else if (strcmp(role, "mask") == 0)
        stream->encoding.scale = info->format == TTF_SAMPLE_U8 ? 255 : 65535;
    ttf_tiff_reader_close(tiff);
    return 0;
}

/* That this can read; what is no picture of the stream's geometry has no role here. */
static int check_role(const char *role, struct ttf_err *err)
{
    if (!role || strcmp(role, "uncertainty") == 0 || strcmp(role, "mask") == 0)
        return 0;
    ttf_err_set(err, -EINVAL, "role", "'%.40s' is none that can be read as a sequence", role);
    ttf_err_hint(err, "developed, uncertainty or mask");
    return -EINVAL;
}

static struct dataset_sequence *make(struct ttf_reader *reader, const struct ttf_stream *stream,
                                     struct sequence_frames *frames)
{
    struct dataset_sequence *dataset = calloc(1, sizeof(*dataset));
    double factor = stream->format == TTF_SAMPLE_U8 ? 257.0 : 1.0;
    bool floats = stream->format == TTF_SAMPLE_F16 || stream->format == TTF_SAMPLE_F32;

    if (!dataset)
        return NULL;
    pthread_mutex_init(&dataset->lock, NULL);
    dataset->io = ttf_reader_io(reader);
    dataset->frames = *frames;
    dataset->samples = stream->samples;
    dataset->format = floats ? TTF_SAMPLE_F32 : stream->format;
    dataset->encoding = stream->encoding;
    dataset->base = (struct ttf_sequence){
        .ops = floats ? &float_ops : &dataset_ops,
        .width = stream->width,
        .height = stream->height,
        .n = frames->n,
        .encoding = {stream->encoding.pedestal * factor, stream->encoding.scale * factor},
        .index = frames->index,
        .time_ns = frames->time_ns,
        .excluded = frames->excluded,
        .n_excluded = frames->n_excluded,
    };
    return dataset;
}

int ttf_sequence_of_dataset(struct ttf_reader *reader, const struct ttf_sequence_choice *choice,
                            struct ttf_sequence **ret, struct ttf_err *err)
{
    static const struct ttf_sequence_choice plain = {0};
    const char *role =
        choice && choice->role && strcmp(choice->role, "developed") != 0 ? choice->role : NULL;
    struct ttf_stream beside;
    const struct ttf_manifest *manifest = ttf_reader_manifest(reader);
    const struct ttf_stream *stream = choice && choice->stream
                                          ? ttf_manifest_stream(manifest, choice->stream)
                                          : ttf_manifest_primary(manifest);
    const char *path = ttf_reader_path(reader);
    struct dataset_sequence *dataset;
    struct sequence_frames frames;
    int code;

    if (!stream)
        return ttf_err_set(err, -ENODATA, path, "there is no stream '%s'",
                           choice && choice->stream ? choice->stream : "primary");
    code = check_role(role, err);
    if (!code && !role)
        code = check_stream(stream, path, err);
    if (!code)
        code = sequence_frames_collect(reader, stream, choice ? choice : &plain, &frames, err);
    if (code)
        return code;
    if (role) {
        beside = *stream;
        code = as_beside(ttf_reader_io(reader), role, frames.path[0], &beside, err);
        code = code ? code : check_stream(&beside, path, err);
        stream = &beside;
    }
    if (code) {
        sequence_frames_free(&frames);
        return code;
    }
    dataset = make(reader, stream, &frames);
    if (!dataset) {
        sequence_frames_free(&frames);
        return ttf_err_set(err, -ENOMEM, path, "no memory for a sequence");
    }
    if (dataset->base.ops == &float_ops)
        code = spread_floats(dataset, err);
    if (code) {
        dataset_destroy(&dataset->base);
        return code;
    }
    *ret = &dataset->base;
    return 0;
}
