/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The flat part. Where an even target of reflectance rho gives the mean signal
 * s(p) above dark, the gain g(p) = T / s(p) makes all pixels, of all colours, T,
 * and a perfect diffuser T / rho: vignetting, uneven light, the pixels' own response
 * and the white balance go at once. T is chosen so that gains fit 16 bits.
 */
#include <errno.h>
#include <stdlib.h>

#include "calibration_private.h"

#define GAIN_ONE 16384u
#define GAIN_MAX 65535u

/* What a flat must be, of full scale or as a ratio. */
#define SATURATED_PER_MILLE 980 /* a mean above this share of the range counts as saturated */
#define SATURATED_SHARE     200 /* at most one pixel in so many */
#define DARKEST_PER_MILLE   20  /* mean of the weakest colour */
#define BRIGHTEST_PER_MILLE 100 /* mean of the strongest colour */
#define UNEVEN_MAX          8

#define BLOCK 32 /* pixels: evenness is judged on means of blocks, not on single pixels */

/* The four CFA positions apart; of a grey sensor they are all of one kind. */
#define POSITIONS 4

struct flat_figures {
    int64_t mean_16[POSITIONS]; /* signal */
    int64_t least_16[POSITIONS], most_16[POSITIONS];
    size_t saturated;
};

bool calibration_is_hot(const struct ttf_calibration *calibration, uint32_t x, uint32_t y)
{
    unsigned low = 0, high = calibration->n_hot;
    uint32_t key = y << 16 | x;

    while (low < high) {
        unsigned middle = low + (high - low) / 2;
        const struct ttf_hot_pixel *hot = &calibration->hot[middle];
        uint32_t at = (uint32_t)hot->y << 16 | hot->x;

        if (at == key)
            return true;
        if (at < key)
            low = middle + 1;
        else
            high = middle;
    }
    return false;
}

/* Mean signal of one CFA position in a block; 0 if the block has no such pixel. */
static int64_t block_mean(const struct ttf_calibration *calibration, const int32_t *signal,
                          uint32_t x0, uint32_t y0, unsigned position)
{
    uint32_t width = calibration->width, height = calibration->height;
    int64_t sum = 0, n = 0;

    for (uint32_t y = y0 + position / 2; y < y0 + BLOCK && y < height; y += 2) {
        for (uint32_t x = x0 + position % 2; x < x0 + BLOCK && x < width; x += 2) {
            if (calibration_is_hot(calibration, x, y))
                continue;
            sum += signal[(size_t)y * width + x];
            n++;
        }
    }
    return n > 0 ? sum / n : 0;
}

static void figures_of(const struct ttf_calibration *calibration, const int32_t *signal,
                       struct flat_figures *ret)
{
    for (unsigned p = 0; p < POSITIONS; p++) {
        int64_t sum = 0, blocks = 0;

        ret->least_16[p] = INT64_MAX;
        ret->most_16[p] = 0;
        for (uint32_t y = 0; y < calibration->height; y += BLOCK) {
            for (uint32_t x = 0; x < calibration->width; x += BLOCK) {
                int64_t mean = block_mean(calibration, signal, x, y, p);

                if (x + p % 2 >= calibration->width || y + p / 2 >= calibration->height)
                    continue;
                sum += mean;
                blocks++;
                if (mean < ret->least_16[p])
                    ret->least_16[p] = mean;
                if (mean > ret->most_16[p])
                    ret->most_16[p] = mean;
            }
        }
        ret->mean_16[p] = blocks > 0 ? sum / blocks : 0;
    }
}

static int refuse_levels(const struct flat_figures *figures, size_t n, double range,
                         struct ttf_err *err)
{
    int64_t weakest = figures->mean_16[0], strongest = figures->mean_16[0];

    for (unsigned p = 1; p < POSITIONS; p++) {
        if (figures->mean_16[p] < weakest)
            weakest = figures->mean_16[p];
        if (figures->mean_16[p] > strongest)
            strongest = figures->mean_16[p];
    }
    if (figures->saturated > n / SATURATED_SHARE) {
        ttf_err_set(err, -EINVAL, NULL,
                    "the flat frames are saturated: %.1f %% of the pixels are at full scale",
                    100.0 * (double)figures->saturated / (double)n);
        ttf_err_hint(err, "take them with a shorter exposure, less gain or dimmer lamps");
        return -EINVAL;
    }
    if ((double)strongest / 16.0 * 1000.0 < BRIGHTEST_PER_MILLE * range ||
        (double)weakest / 16.0 * 1000.0 < DARKEST_PER_MILLE * range) {
        ttf_err_set(err, -EINVAL, NULL,
                    "the flat frames are too dark: colours reach %.1f to %.1f %% of full scale, "
                    "where %d and %d %% are needed",
                    100.0 * (double)weakest / 16.0 / range,
                    100.0 * (double)strongest / 16.0 / range, DARKEST_PER_MILLE / 10,
                    BRIGHTEST_PER_MILLE / 10);
        ttf_err_hint(err, "light the target, or expose longer");
        return -EINVAL;
    }
    for (unsigned p = 0; p < POSITIONS; p++) {
        if (figures->most_16[p] > UNEVEN_MAX * figures->least_16[p]) {
            ttf_err_set(err, -EINVAL, NULL,
                        "the flat frames are too uneven: the brightest part has %.1f times the "
                        "light of the darkest, %d is the most that is corrected",
                        (double)figures->most_16[p] /
                            (double)(figures->least_16[p] > 0 ? figures->least_16[p] : 1),
                        UNEVEN_MAX);
            ttf_err_hint(err, "place the lamps more evenly, and let the target fill the frame");
            return -EINVAL;
        }
    }
    return 0;
}

/* T, in 1/16 codes: the mean signal, or what the darkest block still reaches with the largest gain (and 1/4 to spare for single pixels). */
static int64_t target_of(const struct flat_figures *figures)
{
    int64_t sum = 0, least = INT64_MAX, target;

    for (unsigned p = 0; p < POSITIONS; p++) {
        sum += figures->mean_16[p];
        if (figures->least_16[p] < least)
            least = figures->least_16[p];
    }
    target = sum / POSITIONS;
    return target < 3 * least ? target : 3 * least;
}

/*
 * Gains, and the pixels whose gain does not fit: dead ones, or so bright that they
 * are of no use. Returns how many, and lists them where `dead` is not NULL.
 */
static size_t fill_gains(const int32_t *signal, size_t n, uint32_t width, int64_t target,
                         uint16_t *gain, struct ttf_hot_pixel *dead)
{
    size_t n_dead = 0;

    for (size_t i = 0; i < n; i++) {
        int64_t g = signal[i] > 0 ? (target * GAIN_ONE + signal[i] / 2) / signal[i] : 0;

        if (g < 1 || g > GAIN_MAX) {
            if (dead)
                dead[n_dead] = (struct ttf_hot_pixel){(uint16_t)(i % width), (uint16_t)(i / width)};
            n_dead++;
            g = GAIN_ONE; /* never used: the pixel is replaced by its neighbours */
        }
        gain[i] = (uint16_t)g;
    }
    return n_dead;
}

/* Signals of all pixels and how many are saturated. */
static int32_t *signals_of(const struct ttf_calibration *calibration,
                           const struct ttf_raw_sum *flat, size_t n, size_t *ret_saturated)
{
    int32_t *signal = calloc(n, sizeof(*signal));
    uint16_t black, white;
    uint32_t limit_16;

    if (!signal)
        return NULL;
    ttf_raw_sum_levels(&flat->format, &black, &white);
    limit_16 = 16u * black + 16u * (uint32_t)(white - black) * SATURATED_PER_MILLE / 1000u;
    *ret_saturated = 0;
    for (size_t i = 0; i < n; i++) {
        signal[i] = calibration_signal_16(calibration, flat, i, black);
        *ret_saturated += calibration_mean_16(flat, i) > limit_16;
    }
    return signal;
}

/* Puts the dead pixels into the calibration's list. */
static int add_dead(struct ttf_calibration *calibration, const int32_t *signal, size_t n,
                    int64_t target, uint16_t *gain, struct ttf_err *err)
{
    size_t n_dead = fill_gains(signal, n, calibration->width, target, gain, NULL);
    size_t all = calibration->n_hot + n_dead;
    struct ttf_hot_pixel *hot;

    if (n_dead == 0)
        return 0;
    if (n_dead > n / 50 + 4)
        return ttf_err_set(err, -EINVAL, NULL,
                           "%zu of %zu pixels of the flat frames are far off their neighbours",
                           n_dead, n);
    hot = realloc(calibration->hot, all * sizeof(*hot));
    if (!hot)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to fit flat frames");
    calibration->hot = hot;
    fill_gains(signal, n, calibration->width, target, gain, hot + calibration->n_hot);
    calibration->n_hot = (unsigned)all;
    calibration_sort_hot(calibration);
    return 0;
}

int ttf_calibration_fit_flat(struct ttf_calibration *calibration, const struct ttf_raw_sum *flat,
                             double reflectance, struct ttf_err *err)
{
    size_t n = (size_t)flat->format.width * flat->format.height;
    const struct ttf_calibration before = *calibration;
    struct flat_figures figures = {0};
    int32_t *signal = NULL;
    uint16_t *gain = NULL, black, white;
    int64_t target;
    int r = calibration_check_sum(calibration, flat, "flat", err);

    if (r < 0)
        return r;
    if (!(reflectance > 0.0 && reflectance <= 1.0))
        return ttf_err_set(err, -EINVAL, NULL, "a reflectance lies between 0 and 1, not at %g",
                           reflectance);
    calibration_take_format(calibration, flat);
    ttf_raw_sum_levels(&flat->format, &black, &white);
    signal = signals_of(calibration, flat, n, &figures.saturated);
    gain = calloc(n, sizeof(*gain));
    if (!signal || !gain) {
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory to fit flat frames");
        goto out;
    }
    figures_of(calibration, signal, &figures);
    r = refuse_levels(&figures, n, (double)white - black, err);
    if (r < 0)
        goto out;
    target = target_of(&figures);
    r = add_dead(calibration, signal, n, target, gain, err);
    if (r < 0)
        goto out;
    free(calibration->flat_gain);
    calibration->flat_gain = gain;
    gain = NULL;
    calibration->has_flat = true;
    calibration->flat_frames = flat->n;
    calibration->flat_settings = flat->settings;
    calibration->flat_reflectance = reflectance;
    calibration->flat_level = (double)target / 16.0 / reflectance;
out:
    if (r < 0) { /* refused frames leave no trace */
        calibration->width = before.width;
        calibration->height = before.height;
        calibration->cfa = before.cfa;
        calibration->black_level = before.black_level;
        calibration->white_level = before.white_level;
    }
    free(signal);
    free(gain);
    return r;
}
