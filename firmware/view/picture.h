/* SPDX-License-Identifier: Apache-2.0 */
/* picture.h: a picture's compressed bytes in memory. */
#ifndef VIEW_PICTURE_H
#define VIEW_PICTURE_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pixbuf.h"

#define VIEW_QUALITY   90 /* the least without chroma subsampling: each pixel keeps its own colour */
#define VIEW_PNG_LEVEL 6

struct view_picture {
    uint8_t *data;
    size_t bytes, room;
};

/* 8-bit RGB as PNG (exact) or JPEG. What `ret` held is overwritten, its memory kept. */
TTF_MUST_USE int view_picture_encode(struct view_picture *ret, const struct ttf_pixbuf *rgb8,
                                     bool exact, struct ttf_err *err);
void view_picture_free(struct view_picture *picture);

#endif
