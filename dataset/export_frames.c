/* SPDX-License-Identifier: Apache-2.0 */
/* export_frames.c: a contiguous row of frames from a sequence with holes. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"

#define FRAMES_MAX 4000000 /* an outage's holes can be many more than the images */

static int add_frame(struct export_job *job, int64_t slot, uint32_t t, struct ttf_err *err)
{
    const struct ttf_sequence *s = job->sequence;
    struct export_frame frame = {.index = slot, .time_ns = s->time_ns[t], .a = t, .b = t, .den = 1};

    if (slot != s->index[t]) {
        int64_t gap = s->index[t + 1] - s->index[t], into = slot - s->index[t];

        frame.invented = true;
        frame.time_ns +=
            (int64_t)((double)(s->time_ns[t + 1] - s->time_ns[t]) * (double)into / (double)gap);
        if (job->config->gaps == TTF_GAPS_FAIL) {
            ttf_err_set(err, -ENODATA, NULL, "slot %lld has no image", (long long)slot);
            ttf_err_hint(err, "let gaps be held or interpolated instead");
            return -ENODATA;
        }
        if (job->config->gaps == TTF_GAPS_INTERPOLATE) {
            frame.b = t + 1;
            frame.num = into;
            frame.den = gap;
        }
    }
    job->frame[job->n++] = frame;
    return 0;
}

int export_frames_make(struct export_job *job, struct ttf_err *err)
{
    const struct ttf_sequence *s = job->sequence;
    int64_t step = job->config->every;
    int64_t n = (s->index[s->n - 1] - s->index[0]) / step + 1;
    int64_t slot = s->index[0];
    uint32_t t = 0;
    int code = 0;

    if (job->config->frames_max && n > job->config->frames_max)
        n = job->config->frames_max;
    if (n < 1 || n > FRAMES_MAX)
        return ttf_err_set(err, -EINVAL, NULL, "%lld frames are not exported at once",
                           (long long)n);
    job->frame = calloc((size_t)n, sizeof(*job->frame));
    if (!job->frame)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a list of frames");
    for (int64_t k = 0; k < n && !code; k++, slot += step) {
        while (t + 1 < s->n && s->index[t + 1] <= slot)
            t++;
        code = add_frame(job, slot, t, err);
    }
    return code;
}

/* Shrinks to fit, never enlarges. */
static void fit_size(struct export_job *job)
{
    uint64_t width = job->sequence->width, height = job->sequence->height;
    uint32_t most_w = job->config->width_max, most_h = job->config->height_max;

    job->width = job->sequence->width;
    job->height = job->sequence->height;
    if (most_w && job->width > most_w) {
        job->width = most_w;
        job->height = (uint32_t)((height * most_w + width / 2) / width);
    }
    if (most_h && job->height > most_h) {
        job->height = most_h;
        job->width = (uint32_t)((width * most_h + height / 2) / height);
    }
    if (job->width == 0)
        job->width = 1;
    if (job->height == 0)
        job->height = 1;
}

/* What holds no light between black and white, but a measurement: shown from the least to the greatest value that there can be. */
static bool is_measurement(const struct ttf_sequence *sequence, double highest)
{
    return sequence->ops->read_values || highest <= 0.25 || highest > 4.0;
}

/* Codes to light between black and white; and from there to the display. */
static int make_tables(struct export_job *job)
{
    static const struct ttf_encoding plain = {.pedestal = 0, .scale = 65535};
    const struct ttf_encoding *encoding = &job->sequence->encoding;
    double lowest = (0.0 - encoding->pedestal) / encoding->scale;
    double highest = (65535.0 - encoding->pedestal) / encoding->scale;

    job->white = job->config->white > 0 ? job->config->white : 1.0;
    if (!(job->config->white > 0) && is_measurement(job->sequence, highest)) {
        job->white = highest;
        job->black = lowest;
    }
    job->linear = malloc(65536 * sizeof(*job->linear));
    job->display = malloc(65536 * sizeof(*job->display));
    if (!job->linear || !job->display)
        return -ENOMEM;
    for (unsigned code = 0; code < 65536; code++) {
        double value = ((double)code - encoding->pedestal) / encoding->scale;
        double light = (value - job->black) / (job->white - job->black) * 65535.0 + 0.5;

        job->linear[code] = !(light > 0.0) ? 0 : light >= 65535.0 ? 65535 : (uint16_t)light;
    }
    ttf_display8_table(&plain, job->display);
    return 0;
}

int export_frames_buffers(struct export_job *job, struct ttf_err *err)
{
    const struct ttf_sequence *s = job->sequence;
    enum ttf_export_kind kind = job->config->kind;
    enum ttf_sample format;
    int code;

    job->values = s->ops->read_values && (kind == TTF_EXPORT_NPY || kind == TTF_EXPORT_TIFF);
    format = job->values ? TTF_SAMPLE_F32 : TTF_SAMPLE_U16;
    code = job->values ? 0 : make_tables(job);

    fit_size(job);
    job->source_t[0] = job->source_t[1] = -1;
    for (int i = 0; i < 2 && !code; i++)
        code = ttf_pixbuf_alloc(&job->source[i], s->width, s->height, 3, format);
    if (!code)
        code = ttf_pixbuf_alloc(&job->mixed, s->width, s->height, 3, format);
    if (!code)
        code = ttf_pixbuf_alloc(&job->sized, job->width, job->height, 3, format);
    if (code)
        return ttf_err_set(err, code, NULL, "no memory for frames of %u x %u", s->width, s->height);
    return 0;
}

/* Frame t in one of the two buffers, other than the one `kept`. */
static int load(struct export_job *job, uint32_t t, int kept, int *ret_place, struct ttf_err *err)
{
    int place, code;

    for (place = 0; place < 2; place++) {
        if (job->source_t[place] == (int64_t)t) {
            *ret_place = place;
            return 0;
        }
    }
    place = kept == 0 ? 1 : 0;
    job->source_t[place] = -1;
    code = job->values ? ttf_sequence_read_values(job->sequence, t, 0, job->sequence->height,
                                                  job->source[place].data, err)
                       : ttf_sequence_read_rows(job->sequence, t, 0, job->sequence->height,
                                                job->source[place].data, err);
    if (code)
        return code;
    job->source_t[place] = t;
    *ret_place = place;
    return 0;
}

/* Codes are proportional to light but for the pedestal, so mixing them mixes light. */
static void mix_codes(const uint16_t *a, const uint16_t *b, int64_t num, int64_t den, uint16_t *ret,
                      size_t n)
{
    for (size_t i = 0; i < n; i++)
        ret[i] = (uint16_t)((a[i] * (den - num) + b[i] * num + den / 2) / den);
}

static void mix_values(const float *a, const float *b, int64_t num, int64_t den, float *ret,
                       size_t n)
{
    float weight = (float)((double)num / (double)den);

    for (size_t i = 0; i < n; i++)
        ret[i] = a[i] + (b[i] - a[i]) * weight;
}

static void mix(struct export_job *job, int a, int b, const struct export_frame *frame)
{
    size_t n = (size_t)job->sequence->width * job->sequence->height * 3;

    if (job->values)
        mix_values(job->source[a].data, job->source[b].data, frame->num, frame->den,
                   job->mixed.data, n);
    else
        mix_codes(job->source[a].data, job->source[b].data, frame->num, frame->den, job->mixed.data,
                  n);
}

int export_frames_read(struct export_job *job, uint32_t k, struct ttf_pixbuf **ret,
                       struct ttf_err *err)
{
    const struct export_frame *frame = &job->frame[k];
    const struct ttf_pixbuf *codes;
    uint16_t *light;
    int a, b, code = load(job, frame->a, -1, &a, err);

    if (code)
        return code;
    codes = &job->source[a];
    if (frame->num > 0) {
        code = load(job, frame->b, a, &b, err);
        if (code)
            return code;
        mix(job, a, b, frame);
        codes = &job->mixed;
    }
    /* Resampled before the pedestal goes: clipped noise would not average out. */
    code = ttf_pixbuf_resample(codes, &job->sized);
    if (code)
        return ttf_err_set(err, code, NULL, "no memory to resample frames");
    light = job->sized.data;
    for (size_t i = 0; !job->values && i < (size_t)job->width * job->height * 3; i++)
        light[i] = job->linear[light[i]];
    *ret = &job->sized;
    return 0;
}

void export_frames_free(struct export_job *job)
{
    free(job->frame);
    free(job->linear);
    free(job->display);
    ttf_pixbuf_free(&job->source[0]);
    ttf_pixbuf_free(&job->source[1]);
    ttf_pixbuf_free(&job->mixed);
    ttf_pixbuf_free(&job->sized);
}
