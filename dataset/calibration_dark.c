/* SPDX-License-Identifier: Apache-2.0 */
/* The dark part: plain averages, and which pixels stand out of them. */
#include <errno.h>
#include <stdlib.h>

#include "calibration_private.h"

/* Means are counted in 1/16 codes: 16 bits and 4. */
#define BINS (1u << 20)

/* Beyond these a frame is not dark, whatever the sensor. */
#define DARK_MEDIAN_SHARE 16  /* median above black: at most 1/16 of the range */
#define HOT_SHARE         100 /* pixels that stand out: at most 1 in 100 */

#define HOT_DEVIATIONS 10.0
#define HOT_CODES      8

struct spread {
    uint32_t median_16;    /* of the means, 1/16 codes */
    uint32_t deviation_16; /* median absolute deviation from it */
};

/* The value below which half of the n counted ones lie. */
static uint32_t median_of(const uint32_t *bins, size_t n)
{
    size_t seen = 0;
    uint32_t i = 0;

    for (; i < BINS - 1; i++) {
        seen += bins[i];
        if (2 * seen > n)
            break;
    }
    return i;
}

static int spread_of(const struct ttf_raw_sum *sum, size_t n, struct spread *ret)
{
    uint32_t *bins = calloc(BINS, sizeof(*bins));

    if (!bins)
        return -ENOMEM;
    for (size_t i = 0; i < n; i++)
        bins[calibration_mean_16(sum, i)]++;
    ret->median_16 = median_of(bins, n);
    for (uint32_t i = 0; i < BINS; i++)
        bins[i] = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t mean = calibration_mean_16(sum, i);

        bins[mean > ret->median_16 ? mean - ret->median_16 : ret->median_16 - mean]++;
    }
    ret->deviation_16 = median_of(bins, n);
    free(bins);
    return 0;
}

/* Mean above which a pixel is hot. 1.4826: a normal distribution's deviation over its median one. */
static uint32_t hot_limit(const struct spread *spread)
{
    double above = HOT_DEVIATIONS * 1.4826 * (double)spread->deviation_16;

    if (above < 16.0 * HOT_CODES)
        above = 16.0 * HOT_CODES;
    return spread->median_16 + (uint32_t)above;
}

static int refuse_light(const struct ttf_raw_sum *sum, const struct spread *spread, size_t n,
                        size_t n_hot, struct ttf_err *err)
{
    uint16_t black, white;
    double level, range;

    ttf_raw_sum_levels(&sum->format, &black, &white);
    level = (double)spread->median_16 / 16.0 - black;
    range = (double)white - black;
    if (level * DARK_MEDIAN_SHARE > range) {
        ttf_err_set(err, -EINVAL, NULL,
                    "the frames are not dark: their median is %.0f codes above black, %.1f %% of "
                    "full scale",
                    level, 100.0 * level / range);
        ttf_err_hint(err, "turn all lamps off and close the door or cap the lens");
        return -EINVAL;
    }
    if (n_hot > n / HOT_SHARE + 4) {
        ttf_err_set(err, -EINVAL, NULL,
                    "the frames are not dark everywhere: %zu of %zu pixels stand out by %d codes "
                    "or more",
                    n_hot, n, HOT_CODES);
        ttf_err_hint(err, "look for light that leaks in, or a lamp that is still on");
        return -EINVAL;
    }
    return 0;
}

int calibration_check_sum(const struct ttf_calibration *calibration, const struct ttf_raw_sum *sum,
                          const char *what, struct ttf_err *err)
{
    bool other;
    uint16_t black, white;

    if (sum->n == 0)
        return ttf_err_set(err, -EINVAL, NULL, "there are no %s frames", what);
    if (sum->samples != 1)
        return ttf_err_set(err, -ENOTSUP, NULL,
                           "%s frames must be raw or grey: this camera gives finished RGB pictures",
                           what);
    ttf_raw_sum_levels(&sum->format, &black, &white);
    other = calibration->width != sum->format.width || calibration->height != sum->format.height ||
            calibration->cfa != sum->format.cfa || calibration->black_level != black ||
            calibration->white_level != white;
    if ((calibration->has_dark || calibration->has_flat) && other)
        return ttf_err_set(
            err, -EINVAL, NULL,
            "the %s frames (%u x %u, levels %u to %u) are of another camera mode than "
            "the calibration (%u x %u, levels %u to %u)",
            what, sum->format.width, sum->format.height, black, white, calibration->width,
            calibration->height, calibration->black_level, calibration->white_level);
    return 0;
}

void calibration_take_format(struct ttf_calibration *calibration, const struct ttf_raw_sum *sum)
{
    calibration->width = sum->format.width;
    calibration->height = sum->format.height;
    calibration->cfa = sum->format.cfa;
    ttf_raw_sum_levels(&sum->format, &calibration->black_level, &calibration->white_level);
}

static int compare_hot(const void *a, const void *b)
{
    const struct ttf_hot_pixel *p = a, *q = b;

    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    return 0;
}

void calibration_sort_hot(struct ttf_calibration *calibration)
{
    unsigned kept = 0;

    if (calibration->n_hot == 0)
        return;
    qsort(calibration->hot, calibration->n_hot, sizeof(*calibration->hot), compare_hot);
    for (unsigned i = 0; i < calibration->n_hot; i++) {
        if (i == 0 || compare_hot(&calibration->hot[i], &calibration->hot[kept - 1]) != 0)
            calibration->hot[kept++] = calibration->hot[i];
    }
    calibration->n_hot = kept;
}

static size_t count_above(const struct ttf_raw_sum *sum, size_t n, uint32_t limit)
{
    size_t count = 0;

    for (size_t i = 0; i < n; i++)
        count += calibration_mean_16(sum, i) > limit;
    return count;
}

static void fill(const struct ttf_raw_sum *sum, size_t n, uint32_t limit, int32_t *offset,
                 struct ttf_hot_pixel *hot)
{
    uint16_t black, white;
    size_t used = 0;

    ttf_raw_sum_levels(&sum->format, &black, &white);
    for (size_t i = 0; i < n; i++) {
        uint32_t mean = calibration_mean_16(sum, i);

        offset[i] = (int32_t)mean - 16 * (int32_t)black;
        if (mean > limit) {
            hot[used].x = (uint16_t)(i % sum->format.width);
            hot[used].y = (uint16_t)(i / sum->format.width);
            used++;
        }
    }
}

int ttf_calibration_fit_dark(struct ttf_calibration *calibration, const struct ttf_raw_sum *dark,
                             struct ttf_err *err)
{
    size_t n = (size_t)dark->format.width * dark->format.height, n_hot;
    struct ttf_hot_pixel *hot;
    struct spread spread;
    int32_t *offset;
    uint32_t limit;
    int r = ttf_calibration_may_take(calibration, TTF_CALIBRATION_DARK, err);

    if (r == 0)
        r = calibration_check_sum(calibration, dark, "dark", err);
    if (r < 0)
        return r;
    r = spread_of(dark, n, &spread);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory to fit dark frames");
    limit = hot_limit(&spread);
    n_hot = count_above(dark, n, limit);
    r = refuse_light(dark, &spread, n, n_hot, err);
    if (r < 0)
        return r;
    offset = calloc(n, sizeof(*offset));
    hot = calloc(n_hot + 1, sizeof(*hot));
    if (!offset || !hot) {
        free(offset);
        free(hot);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to fit dark frames");
    }
    fill(dark, n, limit, offset, hot);
    calibration_take_format(calibration, dark);
    free(calibration->dark_offset_16);
    free(calibration->hot);
    calibration->dark_offset_16 = offset;
    calibration->hot = hot;
    calibration->n_hot = (unsigned)n_hot;
    calibration->has_dark = true;
    calibration->dark_frames = dark->n;
    calibration->dark_settings = dark->settings;
    return 0;
}
