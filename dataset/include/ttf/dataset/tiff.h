/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tiff.h: TIFF files by rows, through the I/O table.
 *
 * Written: little-endian, strips whose height depends on the geometry alone, tags
 * in one fixed order: the same picture gives the same bits. Read: any common
 * baseline or photographic file; nothing in it is trusted.
 */
#ifndef TTF_DATASET_TIFF_H
#define TTF_DATASET_TIFF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/base/time.h"
#include "ttf/dataset/icc.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/pixbuf.h"

/* When and how long, in the file's tags. */
struct ttf_tiff_times {
    int64_t start_utc_ns; /* exposure start; TTF_NS_UNKNOWN: not written */
    int zone_offset_s;    /* of local time, which the tags hold, east of UTC */
    int64_t exposure_ns;  /* 0: not written */
};

enum ttf_tiff_compression {
    TTF_TIFF_NONE = 0,
    TTF_TIFF_DEFLATE
};

/* What a file is to hold. Texts: NULL or empty is left out; borrowed during open. */
struct ttf_tiff_spec {
    uint32_t width, height;
    uint32_t samples;       /* 1 grey, 3 RGB, 2 or 4: the last of no stated meaning */
    enum ttf_sample format; /* of the file; rows for F16 are given as F32 */
    enum ttf_tiff_compression compression;
    enum ttf_icc icc;
    struct ttf_tiff_times times;
    const char *software;
    const char *description;
};

struct ttf_tiff_writer;

/*
 * A writer for file after file of one kind, which owns all memory it needs besides
 * libtiff's: begin .. end allocate nothing of their own. The spec's texts are borrowed
 * for its life, its times are those of begin. -EINVAL for a geometry that cannot be, -ENOMEM.
 */
TTF_MUST_USE int ttf_tiff_writer_create(const struct ttf_tiff_spec *spec,
                                        struct ttf_tiff_writer **ret, struct ttf_err *err);

/* Begins a file at the handle, from offset 0; the handle stays the caller's. -ENOMEM, or what the I/O table says. */
TTF_MUST_USE int ttf_tiff_writer_begin(struct ttf_tiff_writer *writer,
                                       const struct ttf_tiff_times *times, struct ttf_io *io,
                                       int file, struct ttf_err *err);

/* Completes the file: -EINVAL if rows are lacking. The writer is free for the next, also on failure. */
TTF_MUST_USE int ttf_tiff_writer_end(struct ttf_tiff_writer *writer, struct ttf_err *err);

/* Lets go of a file without completing it. The writer is free for the next. */
void ttf_tiff_writer_drop(struct ttf_tiff_writer *writer);

/* create and begin in one, for a single file; to be ended by close or abandon. */
TTF_MUST_USE int ttf_tiff_writer_open(struct ttf_io *io, int file, const struct ttf_tiff_spec *spec,
                                      struct ttf_tiff_writer **ret, struct ttf_err *err);

/* The next n rows, in order; stride in bytes. -EINVAL beyond the height. */
TTF_MUST_USE int ttf_tiff_writer_rows(struct ttf_tiff_writer *writer, const void *rows,
                                      size_t stride, uint32_t n, struct ttf_err *err);

/* end, and frees the writer, also on failure. */
TTF_MUST_USE int ttf_tiff_writer_close(struct ttf_tiff_writer *writer, struct ttf_err *err);

/* Frees without completing. NULL allowed. */
void ttf_tiff_writer_abandon(struct ttf_tiff_writer *writer);

/* The whole of a pixbuf (U8, U16, F32), whose geometry replaces the spec's. */
TTF_MUST_USE int ttf_tiff_write(struct ttf_io *io, int file, const struct ttf_pixbuf *pixels,
                                const struct ttf_tiff_spec *spec, struct ttf_err *err);

/* A page as it is handed out. */
struct ttf_tiff_info {
    uint32_t width, height;
    uint32_t samples;       /* 1..4; alpha is left out, palettes become RGB */
    enum ttf_sample format; /* U8, U16 or F32: what rows come as */
    unsigned bits;          /* of a sample in the file: 1..8 come as U8, 9..16 as U16 */
    bool display_encoded;   /* no profile says that it is linear, and samples are 8 bits or sRGB */
    bool has_icc;
    bool alpha_left_out;
    unsigned orientation; /* Exif 1..8, 1 = upright; rows are handed out as they lie */
    /* Pictures in the file. Smaller copies (of pyramids) and masks, as their tags say, are none, unless there is nothing else. */
    unsigned pages;
    struct ttf_tiff_times times;
    bool zone_known; /* else the file's local time was taken as UTC */
};

struct ttf_tiff_reader;

/*
 * Opens the first page. -ENOENT and the like; -ENOTSUP for what is not read
 * (a layout or compression we do not know); -TTF_EDAMAGED for what is no TIFF.
 * 9..15 bit samples keep their code (value in the low bits); 1..7 bit samples are
 * spread over 0..255; 32-bit integers become U16; white-is-zero is inverted.
 */
TTF_MUST_USE int ttf_tiff_reader_open(struct ttf_io *io, const char *path,
                                      struct ttf_tiff_reader **ret, struct ttf_err *err);

/* Goes to page 0..pages-1. After a failure only close is allowed. */
TTF_MUST_USE int ttf_tiff_reader_page(struct ttf_tiff_reader *reader, unsigned page,
                                      struct ttf_err *err);

/* Of the current page; belongs to the reader. */
const struct ttf_tiff_info *ttf_tiff_reader_info(const struct ttf_tiff_reader *reader);

/* The current page's ICC profile, the reader's own until it goes to another; NULL: none. */
const void *ttf_tiff_reader_profile(const struct ttf_tiff_reader *reader, size_t *ret_bytes);

/*
 * Rows y0..y0+n-1 as info says, into dst with stride bytes from row to row; in any
 * order, cheapest downwards and where whole strips are asked for, with stride as the rows are long: those are decoded
 * in place and not held. Holds at most one strip or row of tiles. -EINVAL outside the image; after any error dst holds nothing of use.
 */
TTF_MUST_USE int ttf_tiff_reader_rows(struct ttf_tiff_reader *reader, uint32_t y0, uint32_t n,
                                      void *dst, size_t stride, struct ttf_err *err);

void ttf_tiff_reader_close(struct ttf_tiff_reader *reader); /* NULL allowed */

/* All of one page into a new pixbuf. */
TTF_MUST_USE int ttf_tiff_read(struct ttf_io *io, const char *path, unsigned page,
                               struct ttf_pixbuf *ret, struct ttf_err *err);

#endif
