/* SPDX-License-Identifier: Apache-2.0 */
/* The object in the photograph: what has another colour than the ground, whatever its brightness. */
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "control/gaussian.h"
#include "control/shadow_parts.h"

#define BINS           1024
#define DARK           0.01f /* of the ground's light: what is darker has hardly a colour of its own */
#define DISTANCE_LEAST 0.02 /* between the means of object and ground, to be one */
#define DEVIATIONS     5.0  /* and so many of the ground's own; noise cut in two has about 3 */
#define PIXELS_LEAST   16
#define SMOOTH_PX      1.0 /* Gaussian of the distances */
#define CLOSE_PX       2 /* bites no wider than twice this are mended: dark parts at the outline fray */

static int no_object(struct ttf_err *err, const char *why)
{
    ttf_err_set(err, -EINVAL, "photograph", "no object stands out from the ground: %s", why);
    ttf_err_hint(err, "photograph it on a plain ground of another colour, or give a threshold");
    return -EINVAL;
}

/*
 * The distance of two points of the chromaticity triangle, whose corners are 1 apart. A share of
 * the ground's light is added to both, so that the noise of dark pixels (black parts, deep
 * shadows) does not pass for colour.
 */
float ttf_chroma_distance(const float rgb[3], const float ground[3])
{
    float ground_sum = ground[0] + ground[1] + ground[2];
    float sum = rgb[0] + rgb[1] + rgb[2] + DARK * ground_sum;
    float squares = 0.0f;

    for (int c = 0; c < 3; c++) {
        float d = (rgb[c] + DARK * ground[c]) / sum - ground[c] / ground_sum;

        squares += d * d;
    }
    return sqrtf(0.5f * squares);
}

/* Averaged over a pixel or two, so that noise does not fray the object's outline. */
static int distances(const struct ttf_pixbuf *photo, const struct ttf_ground *ground, double *ret)
{
    for (uint32_t y = 0; y < photo->height; y++) {
        const float *row = ttf_pixbuf_row(photo, y);

        for (uint32_t x = 0; x < photo->width; x++) {
            float b[3];

            ttf_ground_at(ground, x, y, b);
            ret[(size_t)y * photo->width + x] = (double)ttf_chroma_distance(row + 3 * (size_t)x, b);
        }
    }
    return ttf_control_gaussian(ret, photo->width, photo->height, SMOOTH_PX, TTF_BORDER_HOLD);
}

/* How often each bin of 0..top occurs; the last has what is at the top. */
static double histogram(const double *values, size_t n, double counts[BINS])
{
    double top = 0.0;

    memset(counts, 0, BINS * sizeof(*counts));
    for (size_t i = 0; i < n; i++)
        top = values[i] > top ? values[i] : top;
    for (size_t i = 0; i < n && top > 0.0; i++) {
        double bin = values[i] / top * BINS;

        counts[bin < BINS ? (unsigned)bin : BINS - 1] += 1.0;
    }
    return top;
}

/* Two classes of a histogram, in bins. */
struct split {
    double cut;       /* bins below it are the lower class */
    double low, high; /* means */
    double low_sigma;
};

/*
 * Otsu (1979): the cut with the largest variance between classes, n0 n1 (m0 - m1)^2; of cuts
 * that are as good (an empty stretch) the middle one. Counts are whole numbers,
 * so that equals are equal.
 */
static bool otsu(const double counts[BINS], struct split *ret)
{
    double n = 0.0, sum = 0.0, n0 = 0.0, sum0 = 0.0, squares0 = 0.0, best = 0.0;
    unsigned first = 0, last = 0;

    for (unsigned i = 0; i < BINS; i++) {
        n += counts[i];
        sum += counts[i] * i;
    }
    for (unsigned i = 0; i + 1 < BINS; i++) {
        double n1, apart, between;

        n0 += counts[i];
        sum0 += counts[i] * i;
        squares0 += counts[i] * i * i;
        n1 = n - n0;
        apart = n0 > 0.0 && n1 > 0.0 ? (sum - sum0) / n1 - sum0 / n0 : 0.0;
        between = n0 * n1 * apart * apart;
        if (between > best) {
            double mean = sum0 / n0, variance = squares0 / n0 - mean * mean;

            best = between;
            first = i + 1;
            *ret = (struct split){.low = mean,
                                  .high = mean + apart,
                                  .low_sigma = variance > 0.0 ? sqrt(variance) : 0.0};
        }
        if (between == best)
            last = i + 1;
    }
    ret->cut = 0.5 * ((double)first + (double)last);
    return best > 0.0;
}

static int threshold_find(const double *values, size_t n, double *ret, struct ttf_err *err)
{
    double counts[BINS], top = histogram(values, n, counts), apart;
    struct split split = {0};

    if (!otsu(counts, &split))
        return no_object(err, "all of it has one colour");
    apart = (split.high - split.low) * top / BINS;
    if (apart < DISTANCE_LEAST)
        return no_object(err, "its colours hardly differ");
    if (split.high - split.low < DEVIATIONS * split.low_sigma)
        return no_object(err, "its colours differ no more than the ground's own");
    *ret = split.cut * top / BINS;
    return 0;
}

/* Left, right, top and bottom: an object that reaches all of them is no object on a ground. */
static int borders_check(const struct ttf_mask *mask, struct ttf_err *err)
{
    size_t w = mask->width, h = mask->height;
    bool left = false, right = false, top = false, bottom = false;

    for (size_t x = 0; x < w; x++) {
        top |= mask->at[x] != 0;
        bottom |= mask->at[(h - 1) * w + x] != 0;
    }
    for (size_t y = 0; y < h; y++) {
        left |= mask->at[y * w] != 0;
        right |= mask->at[y * w + w - 1] != 0;
    }
    if (!(left && right && top && bottom))
        return 0;
    ttf_err_set(err, -EINVAL, "photograph", "what stands out touches all four borders");
    ttf_err_hint(err, "leave plain ground around the object");
    return -EINVAL;
}

/* One piece without holes, and without the bites that dark or grey parts leave in its outline. */
static int mask_clean(struct ttf_mask *mask, size_t *ret_pixels, struct ttf_err *err)
{
    int r = ttf_mask_keep_largest(mask, ret_pixels);

    if (r == 0 && *ret_pixels < PIXELS_LEAST)
        return no_object(err, "what differs is of a few pixels only");
    if (r == 0)
        r = ttf_mask_close(mask, CLOSE_PX);
    if (r == 0)
        r = ttf_mask_fill_holes(mask, ret_pixels);
    if (r < 0)
        return ttf_err_set(err, r, "photograph", "no memory to separate its object");
    return borders_check(mask, err);
}

int ttf_object_find(const struct ttf_pixbuf *photo, const struct ttf_ground *ground,
                    double threshold, struct ttf_mask *mask, double *ret_threshold,
                    size_t *ret_pixels, struct ttf_err *err)
{
    size_t n = (size_t)photo->width * photo->height, pixels = 0;
    double *values = malloc(n * sizeof(*values));
    int r;

    r = values ? distances(photo, ground, values) : -ENOMEM;
    if (r < 0)
        ttf_err_set(err, r, "photograph", "no memory for its colours");
    if (r == 0 && threshold == 0.0)
        r = threshold_find(values, n, &threshold, err);
    for (size_t i = 0; i < n && r == 0; i++)
        mask->at[i] = values[i] > threshold;
    free(values);
    if (r == 0)
        r = mask_clean(mask, &pixels, err);
    if (r < 0)
        return r;
    *ret_threshold = threshold;
    *ret_pixels = pixels;
    return 0;
}
