/* SPDX-License-Identifier: Apache-2.0 */
/*
 * thumbnail.h: a small JPEG of a large image, as a person sees it: averaged in linear light by whole pixels, then
 * encoded for display. Read by rows: memory is that of a row and the small picture, but of a DNG, which is read whole.
 */
#ifndef TTF_DATASET_THUMBNAIL_H
#define TTF_DATASET_THUMBNAIL_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"

struct ttf_thumbnail_size {
    uint32_t side; /* pixels of the longer side, at most; 0: as large as it is */
    int quality;   /* 1..100; 0: 80 */
};

/*
 * Of an image's file: a TIFF (its codes mean what the stream's encoding says) or a DNG (white balance as shot, not
 * calibrated, half as large as it is at the most). *ret by malloc. -ENOTSUP: neither, or a geometry that is not shown;
 * errors of reading. Any thread.
 */
TTF_MUST_USE int ttf_thumbnail_of_file(struct ttf_io *io, const char *path,
                                       const struct ttf_stream *stream,
                                       const struct ttf_thumbnail_size *size, void **ret,
                                       size_t *ret_bytes, struct ttf_err *err);

#endif
