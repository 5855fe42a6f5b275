/* SPDX-License-Identifier: Apache-2.0 */
#include "search/sources.h"

#include <errno.h>
#include <string.h>

static int check_like_first(const struct ttf_sequence *first, const struct ttf_sequence *other,
                            unsigned i, struct ttf_err *err)
{
    if (other->n != first->n) {
        ttf_err_set(err, -EINVAL, "sources", "input %u has %u frames, the first has %u", i + 1,
                    other->n, first->n);
        ttf_err_hint(err, "sources of one material are matched frame by frame: take the first %u",
                     other->n < first->n ? other->n : first->n);
        return -EINVAL;
    }
    if (other->encoding.pedestal != first->encoding.pedestal ||
        other->encoding.scale != first->encoding.scale)
        return ttf_err_set(err, -EINVAL, "sources",
                           "the codes of input %u do not mean what those of the first mean "
                           "(pedestal %g, scale %g, not %g, %g)",
                           i + 1, other->encoding.pedestal, other->encoding.scale,
                           first->encoding.pedestal, first->encoding.scale);
    return 0;
}

int ttf_sources_of(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                   struct ttf_sources *ret, struct ttf_err *err)
{
    struct ttf_sources sources = {.n = 1 + config->n_more, .list = {input}, .frames = input->n};
    uint64_t pixels = 0;

    if (config->n_more > TTF_QUILT_INPUTS_MAX - 1)
        return ttf_err_set(err, -EINVAL, "sources", "%u further inputs are more than %u",
                           config->n_more, TTF_QUILT_INPUTS_MAX - 1);
    for (unsigned i = 0; i < sources.n; i++) {
        struct ttf_sequence *own = i == 0 ? input : config->more[i - 1];
        int r = check_like_first(input, own, i, err);

        if (r < 0)
            return r;
        sources.list[i] = own;
        sources.first[i] = (uint32_t)pixels;
        pixels += (uint64_t)own->width * own->height;
        if (pixels > INT32_MAX)
            return ttf_err_set(err, -EINVAL, NULL, "inputs of more than 2^31 pixels are too large");
    }
    sources.pixels = (uint32_t)pixels;
    *ret = sources;
    return 0;
}

int ttf_sources_read(const struct ttf_sources *sources, uint32_t t, uint16_t *dst,
                     struct ttf_err *err)
{
    for (unsigned i = 0; i < sources->n; i++) {
        struct ttf_sequence *input = sources->list[i];
        int r = ttf_sequence_read_rows(input, t, 0, input->height,
                                       dst + (size_t)sources->first[i] * 3, err);

        if (r < 0)
            return r;
    }
    return 0;
}

static int read_codes_of(struct ttf_sequence *input, uint32_t t, const uint8_t *table,
                         uint16_t *scratch, uint8_t *dst, struct ttf_err *err)
{
    size_t row = (size_t)input->width * 3;
    uint32_t rows_at_once = row < TTF_SOURCES_PIECE ? (uint32_t)(TTF_SOURCES_PIECE / row) : 0;

    if (rows_at_once == 0)
        return ttf_err_set(err, -EINVAL, NULL, "rows of %u pixels are too long", input->width);
    for (uint32_t y = 0; y < input->height; y += rows_at_once) {
        uint32_t rows = input->height - y < rows_at_once ? input->height - y : rows_at_once;
        int r = ttf_sequence_read_rows(input, t, y, rows, scratch, err);

        if (r < 0)
            return r;
        for (size_t i = 0; i < rows * row; i++)
            dst[y * row + i] = table[scratch[i]];
    }
    return 0;
}

int ttf_sources_read_codes(const struct ttf_sources *sources, uint32_t t, const uint8_t *table,
                           uint16_t *scratch, uint8_t *dst, struct ttf_err *err)
{
    for (unsigned i = 0; i < sources->n; i++) {
        int r = read_codes_of(sources->list[i], t, table, scratch,
                              dst + (size_t)sources->first[i] * 3, err);

        if (r < 0)
            return r;
    }
    return 0;
}
