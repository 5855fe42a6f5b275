/* SPDX-License-Identifier: Apache-2.0 */
/*
 * import.h: image sequences, TIFF stacks and video become datasets. TRADE.md has
 * the rules.
 */
#ifndef TTF_DATASET_IMPORT_H
#define TTF_DATASET_IMPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/io.h"

enum ttf_import_order {
    TTF_IMPORT_NATURAL = 0, /* by name, numbers by value: frame2 before frame10 */
    TTF_IMPORT_GIVEN,       /* as given */
    TTF_IMPORT_EXIF_TIME,   /* by when each was taken */
    TTF_IMPORT_NAME_TIME,   /* by the time in each file's name */
    TTF_IMPORT_ORDER_COUNT
};

/* "natural", "given", "exif-time", "name-time"; -ENOENT */
const char *ttf_import_order_name(enum ttf_import_order order);
int ttf_import_order_find(const char *name);

/*
 * After each frame: `total` frames in all, 0 where that is not known (video). Return
 * non-zero to stop: -ECANCELED.
 */
typedef int ttf_trade_progress_fn(void *ctx, int64_t done, int64_t total);

/* Zero-initialised it means: natural order, one stream "main", nothing assumed. */
struct ttf_import_config {
    const char *const *inputs; /* pictures, or one video, or TIFF stacks (pages in order) */
    size_t n_inputs;
    const char *output; /* the new dataset's folder; must not exist or be empty */
    /*
     * From slot to slot. 0: of a video, its own frame period; ordered by time, the
     * median distance; else refused (-EINVAL), as nobody could know.
     */
    int64_t interval_ns;
    enum ttf_import_order order;
    enum ttf_transfer transfer;   /* AUTO: as each file says */
    struct ttf_image_range range; /* of float pictures; lo == hi: least and greatest of them all */
    struct ttf_region region;     /* part of each picture that is kept; width 0: all */
    int zone_offset_s;            /* of times without a zone, east of UTC */
    int64_t origin_utc_ns;        /* of the first frame where no times are read; 0: not known */
    double mm_per_px;             /* 0: not known */
    const char *title;            /* NULL: the output's name */
    const char *stream;           /* NULL: "main" */
    const char *ffmpeg, *ffprobe; /* programs; NULL: of these names on PATH */
    ttf_trade_progress_fn *progress; /* may be NULL */
    void *progress_ctx;
};

struct ttf_import_result {
    int64_t frames; /* imported */
    int64_t missed; /* slots without an image */
    int64_t interval_ns;
    uint32_t width, height, samples;
    bool alpha_dropped; /* some picture had an alpha channel, which a dataset has not */
    bool
        foreign_profile; /* some picture had an ICC profile other than sRGB, which was not applied */
    char digest[65];     /* of the sealed dataset */
};

/*
 * Imports; on failure nothing is left at `output`. -EINVAL (nothing to import, wrong
 * options, pictures of unlike size or depth: the odd one is named, no time in a
 * picture that needs one, two pictures for one slot), -EEXIST, -ENOTSUP (no picture),
 * -TTF_EDAMAGED (a broken one), -ECANCELED, errors of the disk or of ffmpeg. ret may be NULL.
 */
TTF_MUST_USE int ttf_import(struct ttf_io *io, const struct ttf_import_config *config,
                            struct ttf_import_result *ret, struct ttf_err *err);

/* Natural order of two names, as strcmp. */
int ttf_natural_compare(const char *a, const char *b);

#endif
