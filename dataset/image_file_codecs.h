/* SPDX-License-Identifier: Apache-2.0 */
/* image_file_codecs.h: decoders behind image_file.h and what they share. Private to picture files. */
#ifndef TTF_DATASET_IMAGE_FILE_CODECS_H
#define TTF_DATASET_IMAGE_FILE_CODECS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/tiff.h"

/*
 * Decodes a whole file in memory. Fills *info, all but `pages`, with the geometry as
 * stored (not turned yet). ret NULL: only the header. `path` is for errors.
 */
TTF_MUST_USE int png_decode(const uint8_t *data, size_t n, const char *path, struct ttf_pixbuf *ret,
                            struct ttf_image_info *info, struct ttf_err *err);
TTF_MUST_USE int jpeg_decode(const uint8_t *data, size_t n, const char *path,
                             struct ttf_pixbuf *ret, struct ttf_image_info *info,
                             struct ttf_err *err);

/* What tiff.h says of the current page, in this header's words. */
void image_info_of_tiff(const struct ttf_tiff_reader *reader, struct ttf_image_info *info);

/* By a file's first bytes, never by its name. -ENOTSUP if it is no picture. */
TTF_MUST_USE int image_find_kind(struct ttf_io *io, const char *path, enum ttf_image_kind *ret,
                                 struct ttf_err *err);

/* -EFBIG beyond what image_file.h promises to take. */
TTF_MUST_USE int image_check_size(uint64_t width, uint64_t height, const char *path,
                                  struct ttf_err *err);

/* Orientation and times of an EXIF block (beginning with its TIFF header) into *info; what is broken or absent is left alone. */
void exif_read(const uint8_t *data, size_t n, struct ttf_image_info *info);

/* Whether a profile, as far as 8 bits show, is that of sRGB; false too for what is no profile. */
bool image_profile_is_srgb(const void *profile, size_t bytes, bool grey);
/* The same of sRGB's colours (and its white) with codes that are proportional to light. */
bool image_profile_is_linear_srgb(const void *profile, size_t bytes, bool grey);

/* Days from 1970-01-01 of a date that exists; false if it does not. */
bool days_of_date(int year, int month, int day, int64_t *ret);

/* Turns pixels upright from EXIF orientation 1..8, in place or into new memory. */
TTF_MUST_USE int image_upright(struct ttf_pixbuf *pixels, unsigned orientation);

/* Codes of one kind of picture to linear 16-bit codes: made once, used for many pictures. */
struct linear_map {
    uint16_t *table; /* of all codes; NULL for floats */
    size_t n;
    enum ttf_transfer transfer;
    struct ttf_image_range range;
};
TTF_MUST_USE int linear_map_init(struct linear_map *map, const struct ttf_image_info *info,
                                 enum ttf_transfer transfer, const struct ttf_image_range *range);
void linear_map_free(struct linear_map *map);
/* One row of `width` pixels of src_samples to dst_samples (1 or 3) linear codes. */
void linear_map_row(const struct linear_map *map, const void *src, enum ttf_sample format,
                    uint32_t width, uint32_t src_samples, uint16_t *dst, uint32_t dst_samples);

#endif
