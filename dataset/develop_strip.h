/* SPDX-License-Identifier: Apache-2.0 */
/* develop_strip.h: what a developer knows, and developing a few rows of it. Private to develop. */
#ifndef TTF_DATASET_DEVELOP_STRIP_H
#define TTF_DATASET_DEVELOP_STRIP_H

#include "develop_rows.h"
#include "ttf/dataset/develop.h"

/* Rows of one tile: what a thread takes at a time. Results do not depend on it. */
#define STRIP_ROWS 32

struct develop_sums;

/* What a run works in (develop_space.h). */
struct develop_space {
    unsigned threads; /* it is for; 0: there is none */
    float *scratch;   /* one piece per thread */
    size_t scratch_each;
    uint64_t *saturated; /* per strip */
    struct develop_sums *sums;
    /* of a TIFF; NULL: for none */
    uint16_t *last_row;
    struct ttf_pixbuf chunk;
    struct ttf_tiff_writer *writer;
};

struct ttf_develop {
    struct ttf_develop_config config; /* region resolved */
    struct develop_space space;       /* reserved, or empty */
    unsigned samples;                 /* of a sum: 1 or 3 */
    uint16_t black, white;            /* of the sums' codes, from the format */
    float matrix[9];
    bool has_matrix;
};

/* One run, read by all threads. */
struct develop_run {
    const struct ttf_develop *develop;
    const struct ttf_raw_sum *raw;
    float mean;  /* sum -> code of the calibration */
    float black; /* in those codes */
    float level; /* corrected code -> value */
};

/* Floats of scratch that one thread needs. */
size_t develop_scratch(const struct ttf_develop *develop);

/*
 * Rows y0..y0+n-1 of the region (n <= STRIP_ROWS) into dst, stride in bytes.
 * Returns how many raw samples of them are saturated.
 */
uint64_t develop_strip(const struct develop_run *run, uint32_t y0, uint32_t n, float *scratch,
                       uint16_t *dst, size_t stride);

/* Sums of what the figures are made of, over codes: exact, so in any order. */
struct develop_sums {
    uint64_t level;          /* of all three samples */
    uint64_t green;          /* of green */
    uint64_t gradient;       /* of squared differences of green to the right and below */
    uint64_t pixels, steps;  /* pixels counted, differences counted */
    uint64_t saturated, raw; /* raw samples */
};

/* Adds a developed row; below: the next one, NULL at the last. */
void develop_sums_row(struct develop_sums *sums, const uint16_t *row, const uint16_t *below,
                      uint32_t width);
void develop_sums_add(struct develop_sums *to, const struct develop_sums *from);
struct ttf_image_figures develop_figures(const struct develop_sums *sums,
                                         const struct ttf_encoding *encoding);

#endif
