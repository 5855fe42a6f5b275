/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "ttf/base/attr.h"

#define CODE(a, b, c, d) \
    ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)

/* DRM's modifiers of MIPI formats (drm_fourcc.h of libcamera): vendor 0x0b. */
#define MIPI        0x0bu
#define PACKED      ((uint64_t)MIPI << 56 | 1u)
#define VENDOR(m)   ((unsigned)((m) >> 56))
#define VENDOR_PISP 0x0cu
#define PLAIN       UINT64_C(0)

#define BAYER(x, y, bits, modifier, packing)                                   \
    {CODE('R', 'G', x, y), modifier, packing, TTF_CFA_RGGB, bits, LC_RAW},     \
        {CODE('G', 'R', x, y), modifier, packing, TTF_CFA_GRBG, bits, LC_RAW}, \
        {CODE('G', 'B', x, y), modifier, packing, TTF_CFA_GBRG, bits, LC_RAW}, \
    {                                                                          \
        CODE('B', 'G', x, y), modifier, packing, TTF_CFA_BGGR, bits, LC_RAW    \
    }

/* By preference within a role: more bits before fewer, a word a sample before packed. */
static const struct lc_pixels PIXELS[] = {
    /* DRM has names of 16 bits for two mosaics' letters only; libcamera's are these. */
    {CODE('R', 'G', 'B', '6'), PLAIN, TTF_PACKING_RAW16, TTF_CFA_RGGB, 16, LC_RAW},
    {CODE('G', 'R', '1', '6'), PLAIN, TTF_PACKING_RAW16, TTF_CFA_GRBG, 16, LC_RAW},
    {CODE('G', 'B', '1', '6'), PLAIN, TTF_PACKING_RAW16, TTF_CFA_GBRG, 16, LC_RAW},
    {CODE('B', 'Y', 'R', '2'), PLAIN, TTF_PACKING_RAW16, TTF_CFA_BGGR, 16, LC_RAW},
    BAYER('1', '4', 14, PLAIN, TTF_PACKING_RAW16),
    BAYER('1', '2', 12, PLAIN, TTF_PACKING_RAW16),
    BAYER('1', '2', 12, PACKED, TTF_PACKING_RAW12P),
    BAYER('1', '0', 10, PLAIN, TTF_PACKING_RAW16),
    BAYER('1', '0', 10, PACKED, TTF_PACKING_RAW10P),
    {CODE('R', 'G', 'G', 'B'), PLAIN, TTF_PACKING_RAW8, TTF_CFA_RGGB, 8, LC_RAW},
    {CODE('G', 'R', 'B', 'G'), PLAIN, TTF_PACKING_RAW8, TTF_CFA_GRBG, 8, LC_RAW},
    {CODE('G', 'B', 'R', 'G'), PLAIN, TTF_PACKING_RAW8, TTF_CFA_GBRG, 8, LC_RAW},
    {CODE('B', 'A', '8', '1'), PLAIN, TTF_PACKING_RAW8, TTF_CFA_BGGR, 8, LC_RAW},
    {CODE('R', '1', '6', ' '), PLAIN, TTF_PACKING_GREY16, TTF_CFA_NONE, 16, LC_RAW},
    {CODE('R', '1', '2', ' '), PLAIN, TTF_PACKING_GREY16, TTF_CFA_NONE, 12, LC_RAW},
    {CODE('R', '1', '2', ' '), PACKED, TTF_PACKING_RAW12P, TTF_CFA_NONE, 12, LC_RAW},
    {CODE('R', '1', '0', ' '), PLAIN, TTF_PACKING_GREY16, TTF_CFA_NONE, 10, LC_RAW},
    {CODE('R', '1', '0', ' '), PACKED, TTF_PACKING_RAW10P, TTF_CFA_NONE, 10, LC_RAW},
    /* DRM names colours from the high byte of a little-endian word down: this is R, G, B in memory. */
    {CODE('B', 'G', '2', '4'), PLAIN, TTF_PACKING_RGB8, TTF_CFA_NONE, 8, LC_PROCESSED},
    {CODE('Y', 'U', 'Y', 'V'), PLAIN, TTF_PACKING_YUYV8, TTF_CFA_NONE, 8, LC_PROCESSED},
    {CODE('N', 'V', '1', '2'), PLAIN, TTF_PACKING_NV12, TTF_CFA_NONE, 8, LC_PROCESSED},
    {CODE('R', '8', ' ', ' '), PLAIN, TTF_PACKING_GREY8, TTF_CFA_NONE, 8, LC_PROCESSED},
};

unsigned lc_pixels_rank(uint32_t fourcc, uint64_t modifier)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(PIXELS); i++)
        if (PIXELS[i].fourcc == fourcc && PIXELS[i].modifier == modifier)
            return i + 1;
    return 0;
}

const struct lc_pixels *lc_pixels_of(uint32_t fourcc, uint64_t modifier)
{
    unsigned rank = lc_pixels_rank(fourcc, modifier);

    return rank > 0 ? &PIXELS[rank - 1] : NULL;
}

bool lc_pixels_compressed(uint32_t fourcc, uint64_t modifier)
{
    return VENDOR(modifier) == VENDOR_PISP || fourcc == CODE('M', 'J', 'P', 'G') ||
           fourcc == CODE('J', 'P', 'E', 'G');
}

const char *lc_pixels_text(uint32_t fourcc, uint64_t modifier, char ret[6])
{
    unsigned n = 4;

    for (unsigned i = 0; i < 4; i++) {
        char c = (char)(fourcc >> (8 * i) & 0x7f);

        ret[i] = c >= ' ' && c < 0x7f ? c : '?';
    }
    while (n > 0 && ret[n - 1] == ' ')
        n--;
    if (modifier != PLAIN)
        ret[n++] = modifier == PACKED ? 'P' : '?';
    ret[n] = '\0';
    return ret;
}

bool lc_pixels_named(const struct lc_pixels *pixels, const char *text)
{
    char own[6];
    size_t n = strlen(text);

    while (n > 0 && text[n - 1] == ' ')
        n--;
    (void)lc_pixels_text(pixels->fourcc, pixels->modifier, own);
    return strlen(own) == n && strncasecmp(own, text, n) == 0;
}

const struct lc_pixels *lc_pixels_of_name(const char *text)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(PIXELS); i++)
        if (lc_pixels_named(&PIXELS[i], text))
            return &PIXELS[i];
    return NULL;
}

const struct lc_pixels *lc_pixels_unpacked(const struct lc_pixels *pixels)
{
    const struct lc_pixels *plain = lc_pixels_of(pixels->fourcc, PLAIN);

    return plain ? plain : pixels;
}
