/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sequence.h: one stream of a dataset as a time-varying texture p(x, y, t):
 * frames 0..n-1 without holes (slots that hold no image are left out), read by
 * rows, in any order. What synthesis, export and develop read from.
 *
 * Threads: read_rows may be called from any thread at once.
 */
#ifndef TTF_DATASET_SEQUENCE_H
#define TTF_DATASET_SEQUENCE_H

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/reader.h"

struct ttf_sequence;

struct ttf_sequence_ops {
    /*
     * Rows y0..y0+rows-1 of frame t as 16-bit RGB codes, tightly packed, into
     * dst (rows x width x 3). 0 or a negative errno.
     */
    int (*read_rows)(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                     uint16_t *dst, struct ttf_err *err);
    /* The same rows as values, of a stream of floats; NULL: its codes are all there is. */
    int (*read_values)(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                       float *dst, struct ttf_err *err);
    void (*destroy)(struct ttf_sequence *sequence);
};

/* Embedded first in an implementation's struct. Public fields are constant. */
struct ttf_sequence {
    const struct ttf_sequence_ops *ops;
    uint32_t width, height; /* pixels */
    uint32_t n;             /* frames, >= 1 */
    struct ttf_encoding encoding;
    /* Of each frame: the slot's index, and its due time from the first frame's. n entries each. */
    const int64_t *index;
    const int64_t *time_ns;
    /* Slots that have an image but are left out, as a note says so: their indices. */
    const int64_t *excluded;
    uint32_t n_excluded;
};

/* Which images. Zero-initialised: the reference images of the primary stream, without those that notes exclude. */
struct ttf_sequence_choice {
    const char *stream; /* NULL: the primary one */
    const char *role;   /* NULL: "developed"; "uncertainty", "mask": what lies beside it */
    bool one_bracket;   /* those of `bracket` alone, instead of the reference ones */
    int bracket;        /* its number, from 0 */
    bool with_excluded; /* also slots that a note tags "exclude" */
    /* That records are parsed by; 0: one per processor. Each but the caller's costs address space for good (malloc's). */
    unsigned threads;
};

/*
 * The developed images of a stream in slot order; choice NULL: as if zero-initialised. Of a bracket or a
 * stream with several images per slot, the reference one. Grey streams are read as three equal samples,
 * u8 as u16 through the encoding. Floats are spread over the 16 bits from their least finite value to their
 * greatest, which all files are read for at once; what is no number reads as the least.
 * Of another role the first file says how many samples of which format; of an uncertainty's integers the values are code / scale of the stream, of a
 * mask's code / (greatest code). -ENODATA if there is no such stream or image; -EINVAL of a role that is no picture of a stream. The reader must outlive it.
 */
TTF_MUST_USE int ttf_sequence_of_dataset(struct ttf_reader *reader,
                                         const struct ttf_sequence_choice *choice,
                                         struct ttf_sequence **ret, struct ttf_err *err);

/*
 * Frames in memory: n x height x width x 3 codes; copied not, owned not (they
 * must outlive it). Frames count as 1 s apart.
 */
TTF_MUST_USE int ttf_sequence_of_memory(const uint16_t *frames, uint32_t width, uint32_t height,
                                        uint32_t n, const struct ttf_encoding *encoding,
                                        struct ttf_sequence **ret, struct ttf_err *err);

/*
 * One picture file (PNG, JPEG, TIFF; of a stack its first page) as a sequence of one
 * frame, in linear light (pedestal 0, scale 65535). Errors as ttf_image_read.
 */
TTF_MUST_USE int ttf_sequence_of_image(struct ttf_io *io, const char *path,
                                       struct ttf_sequence **ret, struct ttf_err *err);

TTF_MUST_USE static inline int ttf_sequence_read_rows(struct ttf_sequence *s, uint32_t t,
                                                      uint32_t y0, uint32_t rows, uint16_t *dst,
                                                      struct ttf_err *err)
{
    return s->ops->read_rows(s, t, y0, rows, dst, err);
}

/* Values of a stream of floats, rows x width x 3. -ENOTSUP of any other. */
TTF_MUST_USE static inline int ttf_sequence_read_values(struct ttf_sequence *s, uint32_t t,
                                                        uint32_t y0, uint32_t rows, float *dst,
                                                        struct ttf_err *err)
{
    if (!s->ops->read_values)
        return ttf_err_set(err, -ENOTSUP, NULL, "the stream holds no floats");
    return s->ops->read_values(s, t, y0, rows, dst, err);
}

static inline void ttf_sequence_destroy(struct ttf_sequence *s)
{
    if (s)
        s->ops->destroy(s);
}

#endif
