/* SPDX-License-Identifier: Apache-2.0 */
/*
 * export.h: a sequence as what other programs take. TRADE.md has the rules.
 */
#ifndef TTF_DATASET_EXPORT_H
#define TTF_DATASET_EXPORT_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/sequence.h"

enum ttf_export_kind {
    TTF_EXPORT_MP4 = 0, /* H.264, yuv420p, even sizes (an odd edge is doubled), Rec.709 */
    TTF_EXPORT_GIF,
    TTF_EXPORT_Y4M,   /* 8-bit sRGB as BT.601 limited-range Y'CbCr, 4:4:4 or 4:2:0 */
    TTF_EXPORT_PNG,   /* folder of NAME.1001.png, sRGB, 8 or 16 bits */
    TTF_EXPORT_TIFF,  /* folder of NAME.1001.tif, 16-bit linear with its ICC profile */
    TTF_EXPORT_NPY,   /* n x h x w x 3, uint16, linear, 65535 = white */
    TTF_EXPORT_SHEET, /* one PNG: a grid of frames evenly spread over time */
    TTF_EXPORT_COUNT
};

/* "mp4", "gif", "y4m", "png", "tiff", "npy", "sheet"; -ENOENT */
const char *ttf_export_kind_name(enum ttf_export_kind kind);
int ttf_export_kind_find(const char *name);

/* Whether a sidecar lies beside an output of this kind, as OUTPUT.json: a folder has it inside, a sheet has none. */
bool ttf_export_has_sidecar_beside(enum ttf_export_kind kind);

/* What stands where a slot has no image: numbers stay contiguous, as video tools stop at a hole. */
enum ttf_gaps {
    TTF_GAPS_HOLD = 0,   /* the image before it again */
    TTF_GAPS_FAIL,       /* -ENODATA, naming the slot */
    TTF_GAPS_INTERPOLATE /* between its neighbours, in linear light */
};

/* "hold", "fail", "interpolate"; -ENOENT */
const char *ttf_gaps_name(enum ttf_gaps gaps);
int ttf_gaps_find(const char *name);

/* Zero-initialised it means the value that each field names. */
struct ttf_export_config {
    enum ttf_export_kind kind;
    /*
     * The file, which is replaced when the new one is whole; of PNG and TIFF a folder,
     * which must not exist or be empty. Beside it (in the folder: NAME.json) lies a
     * sidecar OUTPUT.json that says which frames are invented; it is replaced with it.
     */
    const char *output;
    const char *name; /* NAME; NULL: "frame" */
    enum ttf_gaps gaps;
    int64_t start;             /* number of the first file; 0: 1001, unless */
    bool from_zero;            /* it is 0 */
    uint32_t every;            /* each k-th slot; 0: 1 */
    uint32_t frames_max;       /* at most so many frames; 0: all */
    uint32_t fps_num, fps_den; /* of mp4, gif, y4m; 0: 24/1 (gif: 12/1) */
    uint32_t width_max,
        height_max;         /* shrunk in linear light to fit, proportions kept; 0: no limit */
    double white;           /* value shown as full white; 0: see below */
    unsigned png_bits;      /* 8 or 16; 0: 8 */
    unsigned chroma;        /* y4m: 420 or 444; 0: 444 */
    unsigned sheet_frames;  /* 0: 12 */
    unsigned sheet_columns; /* 0: as near to 4:3 as the frames allow */
    uint32_t sheet_cell;    /* longest side of a cell in pixels; 0: 256 */
    bool simulated;         /* says SIMULATED in the sidecar and, where it can, in the file */
    bool camera_colours;    /* tiff: no profile, as the colours are a camera's own */
    const char *ffmpeg;     /* program; NULL: of this name on PATH */
    ttf_trade_progress_fn *progress; /* may be NULL */
    void *progress_ctx;
};

struct ttf_export_result {
    int64_t frames;         /* written */
    int64_t invented;       /* of them, held or interpolated */
    uint32_t width, height; /* as written */
};

/*
 * White, unless stated, is value 1, a perfect diffuser. Where the sequence's codes reach
 * no further than 0.25 or beyond 4 it holds a measurement and no reflectance, and is
 * shown from the least to the greatest value it can hold.
 */

/*
 * Exports; on failure what was at `output` is still there and nothing new is. -EINVAL
 * (wrong options), -EEXIST (a folder that is not empty), -ENODATA (gaps FAIL),
 * -ECANCELED, -ENOENT with a hint if ffmpeg is not there, -EPROTO with its words if it
 * fails, errors of the disk. ret may be NULL. The sequence is read from this thread.
 */
TTF_MUST_USE int ttf_export(struct ttf_sequence *sequence, struct ttf_io *io,
                            const struct ttf_export_config *config, struct ttf_export_result *ret,
                            struct ttf_err *err);

#endif
