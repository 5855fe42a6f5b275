/* SPDX-License-Identifier: Apache-2.0 */
/*
 * dng.h: raw Bayer frames as DNG 1.4 files that any raw converter opens.
 */
#ifndef TTF_DATASET_DNG_H
#define TTF_DATASET_DNG_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/io.h"

struct ttf_dng_info {
    char model[64]; /* camera */
    char serial[64];
    char software[64];
    struct ttf_tiff_times times;
    double neutral[3];       /* as-shot neutral, camera RGB of white; 0: 1, 1, 1 */
    double colour_matrix[9]; /* XYZ(D65) -> camera, row-major; all 0: sRGB primaries' */
    bool simulated;          /* says SIMULATED in the model and description */
};

/*
 * Writes the mean of a sum: CFA samples as they are if n is 1; of an average,
 * rounded means scaled up by the largest power of two that fits 16 bits (levels scaled alike).
 */
TTF_MUST_USE int ttf_dng_write(const struct ttf_raw_sum *raw, const struct ttf_dng_info *info,
                               struct ttf_io *io, int file, struct ttf_err *err);

/* The same, working in memory of the caller's: ttf_dng_scratch_bytes of the raw's format. Allocates nothing of its own. */
TTF_MUST_USE int ttf_dng_write_in(const struct ttf_raw_sum *raw, const struct ttf_dng_info *info,
                                  void *scratch, struct ttf_io *io, int file, struct ttf_err *err);
size_t ttf_dng_scratch_bytes(const struct ttf_frame_format *format);

/*
 * Reads a CFA DNG (ours, or another's: 8..16 bits, uncompressed or lossless JPEG) as a sum of one frame:
 * its active area, linearized, of one black level. settings are exact from our files, else what EXIF tells.
 * A sensor without a mosaic (LinearRaw of one sample) is read as well. ret_info may be NULL.
 * *ret is initialised by this and to be freed. -ENOTSUP for what is no CFA
 * image, -TTF_EDAMAGED for a broken file.
 */
TTF_MUST_USE int ttf_dng_read(struct ttf_io *io, const char *path, struct ttf_raw_sum *ret,
                              struct ttf_dng_info *ret_info, struct ttf_err *err);

#endif
