/* SPDX-License-Identifier: Apache-2.0 */
/* pixels.h: DRM's pixel formats, as libcamera names them, and what they are here. Private to hal/libcamera. */
#ifndef TTF_HAL_LIBCAMERA_PIXELS_H
#define TTF_HAL_LIBCAMERA_PIXELS_H

#include <stdbool.h>
#include <stdint.h>

#include "boundary.h"
#include "ttf/base/frame.h"

struct lc_pixels {
    uint32_t fourcc;
    uint64_t modifier;
    enum ttf_packing packing;
    enum ttf_cfa cfa;
    uint8_t bits;
    enum lc_role role;
};

/* NULL for one that is not known. */
const struct lc_pixels *lc_pixels_of(uint32_t fourcc, uint64_t modifier);

/* As lc_pixels_named has it; NULL. */
const struct lc_pixels *lc_pixels_of_name(const char *text);

/* The same samples, a word each; itself where it is that, or where there is no such format. */
const struct lc_pixels *lc_pixels_unpacked(const struct lc_pixels *pixels);

/* How much it is to be preferred, 1 best; 0 for one that is not known. */
unsigned lc_pixels_rank(uint32_t fourcc, uint64_t modifier);

/* Of those that are not known: samples were thrown away for room (JPEG, squeezed raw). */
bool lc_pixels_compressed(uint32_t fourcc, uint64_t modifier);

/* "RG12", "RG12P" for packed, "RG12?" for another modifier. Returns ret. */
const char *lc_pixels_text(uint32_t fourcc, uint64_t modifier, char ret[6]);

/* The same format as a text says; case and ends of blanks count for nothing. */
bool lc_pixels_named(const struct lc_pixels *pixels, const char *text);

#endif
