/* SPDX-License-Identifier: Apache-2.0 */
/*
 * icc.h: the colour profiles that files of the project carry. Made by lcms2, with
 * a fixed creation date: the same bits on each run.
 */
#ifndef TTF_DATASET_ICC_H
#define TTF_DATASET_ICC_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

enum ttf_icc {
    TTF_ICC_NONE = 0,
    TTF_ICC_LINEAR, /* Rec.709 primaries, D65, gamma 1; a grey one for images of one sample */
    TTF_ICC_SRGB,   /* Rec.709 primaries, D65, the sRGB curve; likewise */
    TTF_ICC_COUNT
};

/*
 * The profile's bytes, to be freed with free(). samples: of the image, 1 or 2 give
 * a grey profile. TTF_ICC_NONE: *ret = NULL, 0 bytes. -ENOMEM.
 */
TTF_MUST_USE int ttf_icc_create(enum ttf_icc icc, uint32_t samples, uint8_t **ret,
                                size_t *ret_bytes, struct ttf_err *err);

/*
 * Whether a foreign profile is of the linear kind: 1 if all its tone curves are
 * gamma 1, 0 if not, negative if it is no profile that says.
 */
int ttf_icc_is_linear(const void *profile, size_t bytes);

#endif
