/* SPDX-License-Identifier: Apache-2.0 */
/* dng_private.h: what the files of dng share. */
#ifndef TTF_DATASET_DNG_PRIVATE_H
#define TTF_DATASET_DNG_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "tiff_client.h"
#include "ttf/dataset/dng.h"

#define DNG_SIMULATED "SIMULATED"

/*
 * What a mosaic's exposure was, to the nanosecond, in the description: the EXIF tags hold
 * single precision. Written and read by the two functions.
 */
#define DNG_DESCRIPTION_SIZE 320
void dng_describe(const struct ttf_raw_sum *raw, bool simulated, char ret[DNG_DESCRIPTION_SIZE]);
bool dng_parse_description(const char *text, struct ttf_exposure *ret);

/* The image of a DNG file that is the mosaic, as its tags say. */
struct dng_image {
    uint32_t width, height;
    unsigned bits;
    uint16_t compression;
    bool tiled;
    uint32_t chunk_width, chunk_height; /* of a tile; of a strip, width and rows */
    uint32_t left, top, right, bottom;  /* active area */
    enum ttf_cfa cfa;
    unsigned black_rows, black_columns; /* of the black pattern, each 1..8 */
    float black[64];
    uint32_t white;
    const uint16_t *table; /* linearization; belongs to libtiff */
    uint32_t table_n;
};

/* The codes of the active area, linearized, into ret (width x height of it). */
TTF_MUST_USE int dng_read_codes(struct tiff_client *client, const struct dng_image *image,
                                uint32_t *ret, struct ttf_err *err);

#endif
