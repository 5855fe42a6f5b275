/* SPDX-License-Identifier: Apache-2.0 */
/*
 * view.h: time-varying textures as one HTML file that opens from disk, without any other file and
 * without a network (README.md).
 */
#ifndef TTF_VIEW_VIEW_H
#define TTF_VIEW_VIEW_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/sequence.h"

#define TTF_VIEW_PANELS_MAX 2
#define TTF_VIEW_FRAMES_MAX 256                     /* layers that every WebGL2 has */
#define TTF_VIEW_SIDE_MAX   2048                    /* pixels that every WebGL2 takes */
#define TTF_VIEW_BYTES_MAX  (INT64_C(30) * 1000000) /* of the file */

/* One texture of the file. Texts are borrowed; NULL: not known. */
struct ttf_view_texture {
    struct ttf_sequence *sequence;
    const char *role;     /* "source", "synthesis" */
    const char *title;    /* a line for people */
    const char *quantity; /* "reflectance", "radiance" ... */
    bool camera_colours;  /* the colours are the camera's own */
    bool simulated;
};

/* Called between frames with what is done; non-zero cancels. */
typedef int ttf_view_progress_fn(void *ctx, int64_t done, int64_t total);

/* Zero-initialised it means the value that each field names. */
struct ttf_view_config {
    const char *output;  /* the file; what was there is replaced when the new one is whole */
    int64_t bytes_max;   /* 0: TTF_VIEW_BYTES_MAX, which it may not exceed */
    uint32_t frames_max; /* of each texture, evenly spread over its time; 0: 240 */
    uint32_t side_max;   /* longest side in pixels; 0: TTF_VIEW_SIDE_MAX, which it may not exceed */
    double white;        /* value of the brightest code; 0: the brightest that is there */
    unsigned threads;    /* 0: one per processor; never changes a byte */
    ttf_view_progress_fn *progress; /* may be NULL */
    void *progress_ctx;
};

struct ttf_view_result {
    int64_t bytes; /* of the file */
    struct {
        uint32_t frames, width, height; /* in the file */
        bool exact;                     /* PNG: the codes are the frames' own; else JPEG */
    } panel[TTF_VIEW_PANELS_MAX];
};

/*
 * Writes the file, of one texture or of two beside each other. On failure what was at `output` is
 * still there and nothing new is; but where its folder alone cannot be synced. -EINVAL (wrong options), -EISDIR, -ECANCELED, -EFBIG (not even
 * small pictures fit into bytes_max), errors of the disk and of the frames. ret may be NULL. Holds
 * one frame per thread, and no more, however long the sequences are.
 */
TTF_MUST_USE int ttf_view_write(const struct ttf_view_texture *textures, unsigned n,
                                struct ttf_io *io, const struct ttf_view_config *config,
                                struct ttf_view_result *ret, struct ttf_err *err);

#endif
