/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/flicker.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BAND_ROWS   8 /* even: each has all colours of a mosaic. 100 Hz is many rows in any readout */
#define SATURATED   0.98 /* of the range */
#define SATURATED_1 200  /* at most one sample in so many */
#define DARKEST \
    0.003 /* mean level, of the range: means of thousands of pixels tell little, but enough */
#define DARK_BAND 0.1 /* of the mean level: what is darker is left out */
#define MINUTE_NS 60e9

int ttf_flicker_init(struct ttf_flicker_frames *frames, const struct ttf_frame_format *format,
                     unsigned room, struct ttf_err *err)
{
    memset(frames, 0, sizeof(*frames));
    if (room < TTF_FLICKER_FRAMES_LEAST)
        return ttf_err_set(err, -EINVAL, "frames", "flicker shows in %d frames or more",
                           TTF_FLICKER_FRAMES_LEAST);
    if (format->height < 2 * BAND_ROWS)
        return ttf_err_set(err, -EINVAL, "frames", "frames of %u rows are too small to show bands",
                           format->height);
    frames->format = *format;
    frames->room = room;
    frames->bands = format->height / BAND_ROWS;
    frames->level = calloc((size_t)room * frames->bands, sizeof(*frames->level));
    frames->start_ns = calloc(room, sizeof(*frames->start_ns));
    if (frames->level && frames->start_ns)
        return 0;
    ttf_flicker_free(frames);
    return ttf_err_set(err, -ENOMEM, "frames", "no memory to remember %u frames", room);
}

void ttf_flicker_free(struct ttf_flicker_frames *frames)
{
    free(frames->level);
    free(frames->start_ns);
    memset(frames, 0, sizeof(*frames));
}

int ttf_flicker_add(struct ttf_flicker_frames *frames, const struct ttf_raw_sum *frame,
                    int64_t start_ns)
{
    const size_t row = (size_t)frames->format.width * frame->samples;
    uint16_t black, white;
    uint32_t limit;

    if (frame->n != 1 || frame->format.width != frames->format.width ||
        frame->format.height != frames->format.height ||
        frame->format.packing != frames->format.packing)
        return -EINVAL;
    if (frames->n == frames->room)
        return -ENOSPC;
    ttf_raw_sum_levels(&frame->format, &black, &white);
    limit = black + (uint32_t)(SATURATED * (white - black));
    for (unsigned b = 0; b < frames->bands; b++) {
        const uint32_t *from = frame->sum + (size_t)b * BAND_ROWS * row;
        uint64_t sum = 0;

        for (size_t i = 0; i < BAND_ROWS * row; i++) {
            sum += from[i];
            frames->saturated += from[i] > limit;
        }
        frames->samples += BAND_ROWS * row;
        frames->level[(size_t)frames->n * frames->bands + b] =
            (double)sum / (double)(BAND_ROWS * row) - black;
    }
    if (frames->n == 0)
        frames->settings = frame->settings;
    frames->start_ns[frames->n++] = start_ns;
    return 0;
}

/* Mean level of a band over all frames. */
static double band_mean(const struct ttf_flicker_frames *f, unsigned band)
{
    double sum = 0;

    for (unsigned i = 0; i < f->n; i++)
        sum += f->level[(size_t)i * f->bands + band];
    return sum / f->n;
}

static int refuse_levels(const struct ttf_flicker_frames *f, double mean, double range,
                         struct ttf_err *err)
{
    if (f->saturated * SATURATED_1 > f->samples) {
        ttf_err_set(err, -EINVAL, "frames",
                    "%.1f %% of the pixels are saturated: they hide what changes",
                    100.0 * (double)f->saturated / (double)f->samples);
        ttf_err_hint(err, "take them with a shorter exposure, less gain or dimmer lamps");
        return -EINVAL;
    }
    if (mean < DARKEST * range) {
        ttf_err_set(err, -EINVAL, "frames", "the frames are too dark to tell: %.1f %% of the range",
                    100.0 * mean / range);
        ttf_err_hint(err, "put something light in, or expose longer");
        return -EINVAL;
    }
    return 0;
}

/* Frames' relative levels in dev[], their straight line over time taken out; its slope a minute. */
static double take_drift(const struct ttf_flicker_frames *f, double *dev)
{
    double t_mean = 0, tt = 0, td = 0, slope;

    for (unsigned i = 0; i < f->n; i++)
        t_mean += (double)(f->start_ns[i] - f->start_ns[0]) / MINUTE_NS / f->n;
    for (unsigned i = 0; i < f->n; i++) {
        const double t = (double)(f->start_ns[i] - f->start_ns[0]) / MINUTE_NS - t_mean;

        tt += t * t;
        td += t * dev[i];
    }
    slope = tt > 0 ? td / tt : 0;
    for (unsigned i = 0; i < f->n; i++)
        dev[i] -= slope * ((double)(f->start_ns[i] - f->start_ns[0]) / MINUTE_NS - t_mean);
    return slope;
}

/*
 * What bands do within their frames. Noise differs from band to band as much as from row to row, a ripple hardly does:
 * half the mean square of the steps between neighbours is noise, and is taken out.
 */
static void measure_bands(const struct ttf_flicker_frames *f, const double *band, double least,
                          struct ttf_flicker *ret)
{
    double sum = 0, steps = 0;
    size_t n = 0, n_steps = 0;

    for (unsigned i = 0; i < f->n; i++) {
        const double *level = f->level + (size_t)i * f->bands;
        double frame = 0, before = NAN;
        unsigned used = 0;

        for (unsigned b = 0; b < f->bands; b++) {
            if (band[b] > least) {
                frame += level[b] / band[b];
                used++;
            }
        }
        for (unsigned b = 0; b < f->bands; b++) {
            double dev;

            if (!(band[b] > least))
                continue;
            dev = level[b] / band[b] / (frame / used) - 1;
            sum += dev * dev;
            n++;
            ret->band_peak = fmax(ret->band_peak, fabs(dev));
            if (!isnan(before)) {
                steps += (dev - before) * (dev - before);
                n_steps++;
            }
            before = dev;
        }
    }
    if (n > 0 && n_steps > 0)
        ret->band_rms = sqrt(fmax(0, sum / (double)n - steps / (double)n_steps / 2));
}

/* Frames against each other. dev: a place for each frame. */
static void measure_frames(const struct ttf_flicker_frames *f, double mean, double *dev,
                           struct ttf_flicker *ret)
{
    double squares = 0;

    for (unsigned i = 0; i < f->n; i++) {
        dev[i] = -1;
        for (unsigned b = 0; b < f->bands; b++)
            dev[i] += f->level[(size_t)i * f->bands + b] / f->bands / mean;
    }
    ret->drift_per_min = take_drift(f, dev);
    for (unsigned i = 0; i < f->n; i++) {
        squares += dev[i] * dev[i];
        ret->frame_peak = fmax(ret->frame_peak, fabs(dev[i]));
    }
    ret->frame_rms = sqrt(squares / f->n);
}

int ttf_flicker_measure(const struct ttf_flicker_frames *f, struct ttf_flicker *ret,
                        struct ttf_err *err)
{
    double *band, mean = 0;
    uint16_t black, white;
    int r;

    if (f->n < TTF_FLICKER_FRAMES_LEAST)
        return ttf_err_set(err, -EINVAL, "frames",
                           "%u frames are too few: flicker shows in %d or more", f->n,
                           TTF_FLICKER_FRAMES_LEAST);
    band = calloc((size_t)f->bands + f->n, sizeof(*band));
    if (!band)
        return ttf_err_set(err, -ENOMEM, "frames", "no memory to measure flicker");
    ttf_raw_sum_levels(&f->format, &black, &white);
    for (unsigned b = 0; b < f->bands; b++) {
        band[b] = band_mean(f, b);
        mean += band[b] / f->bands;
    }
    r = refuse_levels(f, mean, (double)white - black, err);
    if (r == 0) {
        *ret = (struct ttf_flicker){.frames = f->n, .settings = f->settings};
        ret->mean_level = mean / ((double)white - black);
        measure_frames(f, mean, band + f->bands, ret);
        measure_bands(f, band, DARK_BAND * mean, ret);
    }
    free(band);
    return r;
}
