/* SPDX-License-Identifier: Apache-2.0 */
/* formats.h: the kernel's pixel formats that carry uncompressed samples which we can read. Private to hal/v4l2. */
#ifndef TTF_HAL_V4L2_FORMATS_H
#define TTF_HAL_V4L2_FORMATS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/frame.h"

struct v4l2_pixels {
    uint32_t fourcc;
    enum ttf_packing packing;
    enum ttf_cfa cfa;
    uint8_t bits;
};

/* NULL: not one of them. */
const struct v4l2_pixels *v4l2_pixels_of(uint32_t fourcc);

/* How much it is to be preferred, 1 best; 0 for one that is not known. */
unsigned v4l2_pixels_rank(uint32_t fourcc);

/* The i-th by preference, NULL after the last. */
const struct v4l2_pixels *v4l2_pixels_at(unsigned i);

/* Samples that were thrown away for room: MJPEG, H.264, and raw that was squeezed (A-law, DPCM, PiSP). */
bool v4l2_pixels_compressed(uint32_t fourcc, uint32_t enum_flags);

/* "RG10", "Y16" with the blanks at the end cut. Returns ret. */
const char *v4l2_fourcc_text(uint32_t fourcc, char ret[5]);

/* The other way round; blanks are added. 0 for a text that is empty or too long. */
uint32_t v4l2_fourcc_of(const char *text);

#endif
