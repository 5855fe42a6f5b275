/* SPDX-License-Identifier: Apache-2.0 */
#include "formats.h"

#include <linux/videodev2.h>
#include <string.h>

#include "ttf/base/attr.h"

/* Newer than the oldest headers we build with. */
#ifndef V4L2_PIX_FMT_Y12P
#define V4L2_PIX_FMT_Y12P v4l2_fourcc('Y', '1', '2', 'P')
#endif

#define BAYER(bits, packing, suffix)                               \
    {V4L2_PIX_FMT_SRGGB##suffix, packing, TTF_CFA_RGGB, bits},     \
        {V4L2_PIX_FMT_SGRBG##suffix, packing, TTF_CFA_GRBG, bits}, \
        {V4L2_PIX_FMT_SGBRG##suffix, packing, TTF_CFA_GBRG, bits}, \
    {                                                              \
        V4L2_PIX_FMT_SBGGR##suffix, packing, TTF_CFA_BGGR, bits    \
    }

/* By preference: colour before grey, linear before encoded, more bits before fewer, a word a sample before packed. */
static const struct v4l2_pixels PIXELS[] = {
    BAYER(16, TTF_PACKING_RAW16, 16),
    BAYER(14, TTF_PACKING_RAW16, 14),
    BAYER(12, TTF_PACKING_RAW16, 12),
    BAYER(12, TTF_PACKING_RAW12P, 12P),
    BAYER(10, TTF_PACKING_RAW16, 10),
    BAYER(10, TTF_PACKING_RAW10P, 10P),
    BAYER(8, TTF_PACKING_RAW8, 8),
    {V4L2_PIX_FMT_RGB24, TTF_PACKING_RGB8, TTF_CFA_NONE, 8},
    {V4L2_PIX_FMT_YUYV, TTF_PACKING_YUYV8, TTF_CFA_NONE, 8},
    {V4L2_PIX_FMT_NV12, TTF_PACKING_NV12, TTF_CFA_NONE, 8},
    {V4L2_PIX_FMT_Y16, TTF_PACKING_GREY16, TTF_CFA_NONE, 16},
    {V4L2_PIX_FMT_Y14, TTF_PACKING_GREY16, TTF_CFA_NONE, 14},
    {V4L2_PIX_FMT_Y12, TTF_PACKING_GREY16, TTF_CFA_NONE, 12},
    {V4L2_PIX_FMT_Y12P, TTF_PACKING_RAW12P, TTF_CFA_NONE, 12},
    {V4L2_PIX_FMT_Y10, TTF_PACKING_GREY16, TTF_CFA_NONE, 10},
    {V4L2_PIX_FMT_Y10P, TTF_PACKING_RAW10P, TTF_CFA_NONE, 10},
    {V4L2_PIX_FMT_GREY, TTF_PACKING_GREY8, TTF_CFA_NONE, 8},
};

/* Raw that was squeezed; the kernel does not flag all of these as compressed. */
static const char SQUEEZED[][5] = {"aBA8", "aGA8", "agA8", "aRA8", "bBA8", "bGA8",
                                   "BD10", "bRA8", "PC1R", "PC1G", "PC1g", "PC1B",
                                   "PC1M", "PC2R", "PC2G", "PC2g", "PC2B", "PC2M"};

const struct v4l2_pixels *v4l2_pixels_at(unsigned i)
{
    return i < TTF_COUNT_OF(PIXELS) ? &PIXELS[i] : NULL;
}

unsigned v4l2_pixels_rank(uint32_t fourcc)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(PIXELS); i++)
        if (PIXELS[i].fourcc == fourcc)
            return i + 1;
    return 0;
}

const struct v4l2_pixels *v4l2_pixels_of(uint32_t fourcc)
{
    unsigned rank = v4l2_pixels_rank(fourcc);

    return rank > 0 ? &PIXELS[rank - 1] : NULL;
}

bool v4l2_pixels_compressed(uint32_t fourcc, uint32_t enum_flags)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(SQUEEZED); i++)
        if (v4l2_fourcc_of(SQUEEZED[i]) == fourcc)
            return true;
    return enum_flags & V4L2_FMT_FLAG_COMPRESSED || fourcc == V4L2_PIX_FMT_MJPEG ||
           fourcc == V4L2_PIX_FMT_JPEG || fourcc == V4L2_PIX_FMT_H264;
}

const char *v4l2_fourcc_text(uint32_t fourcc, char ret[5])
{
    unsigned n = 4;

    for (unsigned i = 0; i < 4; i++) {
        char c = (char)(fourcc >> (8 * i) & 0x7f);

        ret[i] = c >= ' ' && c < 0x7f ? c : '?';
    }
    while (n > 0 && ret[n - 1] == ' ')
        n--;
    ret[n] = '\0';
    return ret;
}

uint32_t v4l2_fourcc_of(const char *text)
{
    size_t n = strlen(text);
    uint32_t fourcc = 0;

    if (n < 1 || n > 4)
        return 0;
    for (unsigned i = 0; i < 4; i++)
        fourcc |= (uint32_t)(unsigned char)(i < n ? text[i] : ' ') << (8 * i);
    return fourcc;
}
