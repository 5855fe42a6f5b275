/* SPDX-License-Identifier: Apache-2.0 */
#include "develop_strip.h"

void develop_sums_row(struct develop_sums *sums, const uint16_t *row, const uint16_t *below,
                      uint32_t width)
{
    uint64_t level = 0, green = 0, gradient = 0;

    for (size_t x = 0; x < width; x++) {
        level += (uint32_t)row[3 * x] + row[3 * x + 1] + row[3 * x + 2];
        green += row[3 * x + 1];
    }
    for (size_t x = 0; x + 1 < width; x++) {
        int64_t d = (int64_t)row[3 * x + 4] - row[3 * x + 1];

        gradient += (uint64_t)(d * d);
    }
    for (size_t x = 0; below && x < width; x++) {
        int64_t d = (int64_t)below[3 * x + 1] - row[3 * x + 1];

        gradient += (uint64_t)(d * d);
    }
    sums->level += level;
    sums->green += green;
    sums->gradient += gradient;
    sums->pixels += width;
    sums->steps += width - 1 + (below ? width : 0);
}

void develop_sums_add(struct develop_sums *to, const struct develop_sums *from)
{
    to->level += from->level;
    to->green += from->green;
    to->gradient += from->gradient;
    to->pixels += from->pixels;
    to->steps += from->steps;
    to->saturated += from->saturated;
    to->raw += from->raw;
}

struct ttf_image_figures develop_figures(const struct develop_sums *sums,
                                         const struct ttf_encoding *encoding)
{
    struct ttf_image_figures figures = {0};
    double pixels = (double)sums->pixels, green;

    if (sums->pixels == 0)
        return figures;
    green = (double)sums->green / pixels - encoding->pedestal; /* times scale, as the gradient is */
    figures.mean_level =
        ((double)sums->level / (3.0 * pixels) - encoding->pedestal) / encoding->scale;
    if (green > 0.0 && sums->steps > 0)
        figures.sharpness = (double)sums->gradient / (double)sums->steps / (green * green);
    if (sums->raw > 0)
        figures.saturated = (double)sums->saturated / (double)sums->raw;
    return figures;
}
