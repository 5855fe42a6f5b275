/* SPDX-License-Identifier: Apache-2.0 */
/* image_file_linear.c: codes of any picture to linear light. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "image_file_codecs.h"

static uint16_t code_of_unit(float value)
{
    float scaled = value * 65535.0f + 0.5f;

    if (!(scaled > 0.0f))
        return 0;
    return scaled >= 65535.0f ? 65535 : (uint16_t)scaled;
}

static void fill_table(struct linear_map *map)
{
    unsigned top = (unsigned)map->n - 1;

    for (unsigned code = 0; code <= top; code++) {
        if (map->transfer == TTF_TRANSFER_LINEAR)
            map->table[code] = (uint16_t)((code * 65535u + top / 2) / top);
        else if (map->n == 256)
            map->table[code] = ttf_srgb8_to_linear16((uint8_t)code);
        else
            map->table[code] = code_of_unit(ttf_srgb_decode((float)code / (float)top));
    }
}

int linear_map_init(struct linear_map *map, const struct ttf_image_info *info,
                    enum ttf_transfer transfer, const struct ttf_image_range *range)
{
    *map = (struct linear_map){.transfer = transfer, .range = {0.0, 1.0}};
    if (transfer == TTF_TRANSFER_AUTO)
        map->transfer = info->transfer;
    if (range)
        map->range = *range;
    if (info->format == TTF_SAMPLE_F32)
        return map->range.hi > map->range.lo ? 0 : -EINVAL;
    if (info->bits < 1 || info->bits > 16)
        return -EINVAL;
    map->n = (size_t)1 << (info->format == TTF_SAMPLE_U8 ? 8 : info->bits);
    map->table = malloc(map->n * sizeof(*map->table));
    if (!map->table)
        return -ENOMEM;
    fill_table(map);
    return 0;
}

void linear_map_free(struct linear_map *map)
{
    free(map->table);
    map->table = NULL;
}

static uint16_t map_float(const struct linear_map *map, float value)
{
    double unit = ((double)value - map->range.lo) / (map->range.hi - map->range.lo);

    if (!(unit > 0.0))
        return 0;
    if (unit >= 1.0)
        return 65535;
    if (map->transfer == TTF_TRANSFER_SRGB)
        return code_of_unit(ttf_srgb_decode((float)unit));
    return (uint16_t)(unit * 65535.0 + 0.5);
}

static uint16_t map_sample(const struct linear_map *map, const void *src, enum ttf_sample format,
                           size_t i)
{
    size_t code;

    if (format == TTF_SAMPLE_F32)
        return map_float(map, ((const float *)src)[i]);
    code = format == TTF_SAMPLE_U8 ? ((const uint8_t *)src)[i] : ((const uint16_t *)src)[i];
    return map->table[code < map->n ? code : map->n - 1];
}

void linear_map_row(const struct linear_map *map, const void *src, enum ttf_sample format,
                    uint32_t width, uint32_t src_samples, uint16_t *dst, uint32_t dst_samples)
{
    uint32_t colours = src_samples >= 3 ? 3 : 1;

    for (uint32_t x = 0; x < width; x++) {
        for (uint32_t c = 0; c < dst_samples; c++)
            dst[(size_t)x * dst_samples + c] =
                map_sample(map, src, format, (size_t)x * src_samples + (colours == 3 ? c : 0));
    }
}

int ttf_image_linear(const struct ttf_pixbuf *pixels, const struct ttf_image_info *info,
                     enum ttf_transfer transfer, const struct ttf_image_range *range,
                     uint32_t samples, struct ttf_pixbuf *ret)
{
    struct ttf_pixbuf linear;
    struct linear_map map;
    int code;

    if ((samples != 1 && samples != 3) || (samples == 1 && pixels->samples > 2) ||
        pixels->format != info->format)
        return -EINVAL;
    code = linear_map_init(&map, info, transfer, range);
    if (code)
        return code;
    code = ttf_pixbuf_alloc(&linear, pixels->width, pixels->height, samples, TTF_SAMPLE_U16);
    if (!code) {
        for (uint32_t y = 0; y < pixels->height; y++)
            linear_map_row(&map, ttf_pixbuf_row(pixels, y), pixels->format, pixels->width,
                           pixels->samples, ttf_pixbuf_row(&linear, y), samples);
        *ret = linear;
    }
    linear_map_free(&map);
    return code;
}
