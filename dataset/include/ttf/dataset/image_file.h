/* SPDX-License-Identifier: Apache-2.0 */
/*
 * image_file.h: one door for reading any picture (PNG, JPEG, TIFF), whatever it is
 * called, and for writing PNG and JPEG. Nothing in a file is trusted: what is no
 * picture, or a broken one, is refused with the path and the reason.
 *
 * Threads: everything here may be called from any thread.
 */
#ifndef TTF_DATASET_IMAGE_FILE_H
#define TTF_DATASET_IMAGE_FILE_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/base/time.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/pixbuf.h"

enum ttf_image_kind {
    TTF_IMAGE_PNG = 0,
    TTF_IMAGE_JPEG,
    TTF_IMAGE_TIFF
};

/* How codes stand for light. */
enum ttf_transfer {
    TTF_TRANSFER_AUTO = 0, /* only as an option: what the file says, see image_info */
    TTF_TRANSFER_SRGB,     /* display-encoded by the sRGB curve */
    TTF_TRANSFER_LINEAR    /* proportional to light */
};

/* What is known of a picture beside its pixels. */
struct ttf_image_info {
    enum ttf_image_kind kind;
    uint32_t width, height; /* upright: after turning by the EXIF orientation */
    uint32_t samples;       /* 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha; TIFF: 1 or 3 */
    enum ttf_sample format; /* U8, U16 or F32 */
    unsigned bits;          /* integers use codes 0..2^bits-1 */
    unsigned pages;         /* 1, or the pages of a TIFF */
    unsigned orientation;   /* EXIF 1..8 as stored in the file; pixels are turned already */
    /*
     * TIFF: linear if it is float or its profile says so, or 16 bits without one;
     * PNG: linear if gAMA is 1 and no sRGB chunk says otherwise; everything else is sRGB.
     */
    enum ttf_transfer transfer;
    bool
        foreign_profile; /* an ICC profile of other colours than sRGB's is there, which is not applied */
    bool alpha_left_out; /* TIFF: it has alpha, without which pixels come */
    /*
     * When it was taken (EXIF DateTimeOriginal, else DateTime; TIFF: its tags), as if
     * local time were UTC, less the zone's offset where zone_known. TTF_NS_UNKNOWN if
     * nothing says.
     */
    int64_t taken_utc_ns;
    bool zone_known;
    int zone_offset_s;
};

/* Largest picture taken: pixels, so that a forged header cannot ask for all memory. */
#define TTF_IMAGE_PIXELS_MAX (UINT64_C(400) * 1000 * 1000)

/*
 * Reads page `page` (0 but for TIFF stacks) into a fresh pixbuf, upright, samples as
 * the file has them. ret_info may be NULL. -ENOENT and other errors of the disk;
 * -EINVAL: no such page; -ENOTSUP: no picture, or a kind of one that is not read;
 * -EFBIG: beyond the limit; -TTF_EDAMAGED: broken or cut short. To free: ttf_pixbuf_free.
 */
TTF_MUST_USE int ttf_image_read(struct ttf_io *io, const char *path, unsigned page,
                                struct ttf_pixbuf *ret, struct ttf_image_info *ret_info,
                                struct ttf_err *err);

/* The same without decoding pixels (of page 0): cheap, and so no promise that they are whole. */
TTF_MUST_USE int ttf_image_probe(struct ttf_io *io, const char *path, struct ttf_image_info *ret,
                                 struct ttf_err *err);

/* Of float samples: what become codes 0 and 65535. */
struct ttf_image_range {
    double lo, hi;
};

/*
 * Any picture as linear light in a fresh pixbuf: u16, 65535 = full scale; 3 samples
 * (samples = 3), or 1 if it is grey (samples = 1; -EINVAL if it is not). Alpha is left
 * out. 8-bit sRGB maps by ttf_srgb8_to_linear16 and so comes back to the bit. Floats
 * are clipped to range (NULL: 0 to 1), NaN is lo. transfer AUTO: as info says.
 */
TTF_MUST_USE int ttf_image_linear(const struct ttf_pixbuf *pixels,
                                  const struct ttf_image_info *info, enum ttf_transfer transfer,
                                  const struct ttf_image_range *range, uint32_t samples,
                                  struct ttf_pixbuf *ret);

/* Both in one: page 0 of a file as linear u16 RGB. What a scene made of pictures looks at. */
TTF_MUST_USE int ttf_image_read_linear(struct ttf_io *io, const char *path, struct ttf_pixbuf *ret,
                                       struct ttf_image_info *ret_info, struct ttf_err *err);

/*
 * Writes a PNG at a handle from offset 0: U8 or U16, 1 to 4 samples, said to be sRGB
 * (transfer SRGB) or of gamma 1 (LINEAR). level: of compression, 0..9. comment: a tEXt
 * chunk of that keyword; NULL: none. The same pixels give the same bits.
 */
TTF_MUST_USE int ttf_png_write(struct ttf_io *io, int file, const struct ttf_pixbuf *pixels,
                               enum ttf_transfer transfer, int level, const char *comment,
                               struct ttf_err *err);

/* Writes a JPEG: U8, 1 or 3 samples, sRGB-encoded. quality 1..100; from 90 on without chroma subsampling. */
TTF_MUST_USE int ttf_jpeg_write(struct ttf_io *io, int file, const struct ttf_pixbuf *pixels,
                                int quality, struct ttf_err *err);

/* The same into memory: *ret by malloc. */
TTF_MUST_USE int ttf_jpeg_encode(const struct ttf_pixbuf *pixels, int quality, void **ret,
                                 size_t *ret_bytes, struct ttf_err *err);

/*
 * A time in a file's name: year, month, day, hour, minute and perhaps second, apart
 * from one another by at most one of "-_.:T " ("2020-05-28_18-20", "20050504T181349"),
 * or with a two-digit year as "050504_181349" (2000-2069, 1970-1999). As if UTC.
 * TTF_NS_UNKNOWN if there is none.
 */
int64_t ttf_time_in_name(const char *name);

#endif
