/* SPDX-License-Identifier: Apache-2.0 */
/* tiff_client.h: a libtiff handle on top of the I/O table; and times as tags. Private to the pictures. */
#ifndef TTF_DATASET_TIFF_CLIENT_H
#define TTF_DATASET_TIFF_CLIENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <tiffio.h>

#include "tiff_order.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/tiff.h"

/* No single allocation for the sake of a file is larger. */
#define TIFF_ALLOC_MAX ((size_t)1 << 30)

/* A part of the file that small reads are answered from. */
#define TIFF_WINDOW 4096

struct tiff_client {
    struct ttf_io *io;
    int file;
    bool owns_file, dropped;
    int64_t position, size;
    int io_error;      /* the first negative errno of the I/O table */
    char message[256]; /* the first thing that libtiff complained of */
    bool decoding;     /* pixels: what is complained of now, even in passing, was made up */
    bool made_up;
    char where[256];
    TIFF *tiff;
    int64_t window_at;
    size_t window_bytes; /* 0: none */
    unsigned char window[TIFF_WINDOW];
    struct tiff_order order; /* of a file that is written */
};

/* Opens over an open handle; mode as TIFFOpen's. Nothing is printed, ever. */
TTF_MUST_USE int tiff_client_attach(struct tiff_client *client, struct ttf_io *io, int file,
                                    const char *mode, struct ttf_err *err);
/* Opens a file for reading; the handle is closed by tiff_client_close. */
TTF_MUST_USE int tiff_client_open(struct tiff_client *client, struct ttf_io *io, const char *path,
                                  struct ttf_err *err);
/* So many bytes of pixels come next, just as they are; then the last folder. Without it, the file is written in libtiff's order. */
TTF_MUST_USE int tiff_client_pixels(struct tiff_client *client, int64_t bytes, struct ttf_err *err);
/* Flushes and closes; a zeroed client is fine. 0 or what the I/O table said. */
int tiff_client_close(struct tiff_client *client);

/* Closes without writing another byte. */
void tiff_client_drop(struct tiff_client *client);

/* Sets err from what went wrong: the I/O error if there was one, else `code` with libtiff's words. Returns the code. */
int tiff_client_fail(const struct tiff_client *client, struct ttf_err *err, int code,
                     const char *doing);

/*
 * libtiff takes an allocation that failed for damage of the file, or goes on without the tag. But malloc leaves
 * ENOMEM in errno, so whoever begins something with the file (attach and open do it themselves) sets errno to 0, fail
 * says -ENOMEM, and done, at the end of what went well, says so where libtiff did not.
 */
int tiff_client_done(const struct tiff_client *client, struct ttf_err *err, const char *doing);

/*
 * Writes the EXIF folder (times, ISO number unless 0) at the file's present end and hands back its
 * offset, 0 if there is nothing to say. Before any other tag is set.
 */
TTF_MUST_USE int tiff_write_exif(struct tiff_client *client, const struct ttf_tiff_times *times,
                                 unsigned iso, uint64_t *ret_offset, struct ttf_err *err);
/* DateTime of the current folder. */
bool tiff_set_date_time(TIFF *tiff, const struct ttf_tiff_times *times);
/* Times of the current page, from its EXIF folder and DateTime. The current directory is kept. */
void tiff_read_times(TIFF *tiff, struct ttf_tiff_times *ret, bool *ret_zone_known);

/*
 * Between these two pixels are decoded. libtiff only warns where a JPEG or a fax ends too early, or is none in the middle,
 * and hands out what it made up; so end says -TTF_EDAMAGED with the words of the warning.
 */
void tiff_decode_begin(struct tiff_client *client);
TTF_MUST_USE int tiff_decode_end(struct tiff_client *client, struct ttf_err *err,
                                 const char *doing);

/* Sets a text tag unless it is NULL or empty. */
bool tiff_set_text(TIFF *tiff, uint32_t tag, const char *text);

#endif
