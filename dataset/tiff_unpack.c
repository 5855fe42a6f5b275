/* SPDX-License-Identifier: Apache-2.0 */
#include "tiff_unpack.h"

#include <string.h>

#include "half.h"

enum ttf_sample tiff_format_of(unsigned bits, bool is_float)
{
    if (is_float)
        return TTF_SAMPLE_F32;
    return bits <= 8 ? TTF_SAMPLE_U8 : TTF_SAMPLE_U16;
}

/* Sample i of a row of samples of `bits` bits, most significant bit first. 32-bit integers lose their low half. */
static uint32_t code_at(const uint8_t *row, unsigned bits, size_t i)
{
    uint64_t bit = (uint64_t)i * bits;
    const uint8_t *at = row + bit / 8;
    uint32_t word;
    unsigned have;

    if (bits == 8)
        return row[i];
    if (bits == 16) {
        uint16_t half;

        memcpy(&half, row + 2 * i, sizeof(half));
        return half;
    }
    if (bits == 32) {
        memcpy(&word, row + 4 * i, sizeof(word));
        return word >> 16;
    }
    have = 8 - (unsigned)(bit % 8);
    word = *at & ((1u << have) - 1);
    while (have < bits) {
        word = word << 8 | *++at;
        have += 8;
    }
    return word >> (have - bits);
}

static float float_at(const uint8_t *row, unsigned bits, size_t i)
{
    uint16_t half;
    float value;

    if (bits == 16) {
        memcpy(&half, row + 2 * i, sizeof(half));
        return ttf_half_to_float(half);
    }
    memcpy(&value, row + 4 * i, sizeof(value));
    return value;
}

bool tiff_unpack_copies(const struct tiff_layout *layout, unsigned dst_step)
{
    unsigned bytes = (unsigned)ttf_sample_bytes(layout->format);

    return !layout->inverted && layout->in_pixel == layout->kept && layout->kept == dst_step &&
           layout->bits == 8 * bytes;
}

void tiff_unpack_row(const struct tiff_layout *layout, const uint8_t *src, size_t n, void *dst,
                     unsigned dst_step)
{
    uint32_t max = layout->bits >= 16 ? 65535u : (1u << layout->bits) - 1;

    if (tiff_unpack_copies(layout, dst_step)) {
        memcpy(dst, src, n * dst_step * ttf_sample_bytes(layout->format));
        return;
    }
    for (size_t x = 0; x < n; x++) {
        for (unsigned c = 0; c < layout->kept; c++) {
            size_t from = x * layout->in_pixel + c, to = x * dst_step + c;
            uint32_t code;

            if (layout->is_float) {
                float value = float_at(src, layout->bits, from);

                ((float *)dst)[to] = layout->inverted ? 1.0f - value : value;
                continue;
            }
            code = code_at(src, layout->bits, from);
            if (layout->inverted)
                code = max - code;
            if (layout->spread && layout->bits < 8)
                code = code * 255u / max;
            if (layout->format == TTF_SAMPLE_U8)
                ((uint8_t *)dst)[to] = (uint8_t)code;
            else
                ((uint16_t *)dst)[to] = (uint16_t)code;
        }
    }
}

void tiff_unpack_palette(const struct tiff_layout *layout, const uint8_t *src, size_t n,
                         const uint16_t *const tables[3], uint8_t *dst)
{
    for (size_t x = 0; x < n; x++) {
        uint32_t index = code_at(src, layout->bits, x * layout->in_pixel);

        for (unsigned c = 0; c < 3; c++)
            dst[3 * x + c] = (uint8_t)(tables[c][index] >> 8);
    }
}
