/* SPDX-License-Identifier: Apache-2.0 */
/* image_files.h: one image's files: developed TIFF, raw DNG, its levels. Committer thread only. */
#ifndef TTF_CAPTURE_PRIVATE_IMAGE_FILES_H
#define TTF_CAPTURE_PRIVATE_IMAGE_FILES_H

#include "ttf/capture/plan.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/writer.h"

/* How the frames of one camera become files. */
struct ttf_darkroom {
    struct ttf_develop *develop;   /* the whole region */
    struct ttf_develop *reference; /* the reference patch; NULL: none */
    struct ttf_pixbuf patch;       /* of it */
    void *strip;                   /* what writing raw files works in; NULL: none are kept */
    struct ttf_pool *pool;         /* borrowed */
    enum ttf_keep keep;
    char calibration[64]; /* id; empty: none */
    struct ttf_dng_info dng;
    int zone_offset_s;
};

/* Everything a darkroom needs to know. */
struct ttf_darkroom_config {
    const struct ttf_plan *plan;
    const struct ttf_camera *camera;
    const struct ttf_frame_format *format;
    const struct ttf_calibration *calibration; /* NULL: none; borrowed for its life */
    struct ttf_pool *pool;
    const char *serial;
    const char *software;
    bool simulated;
    int zone_offset_s;
};

/* With all memory that its work needs: from then on only libraries allocate, for the file they write. */
TTF_MUST_USE int ttf_darkroom_init(struct ttf_darkroom *room,
                                   const struct ttf_darkroom_config *config, struct ttf_err *err);
void ttf_darkroom_finish(struct ttf_darkroom *room); /* a zeroed one is fine */

/* Develops and writes what the plan keeps of one image; files and levels go into *image. */
struct ttf_print {
    const struct ttf_raw_sum *raw;
    int64_t index;        /* of the slot */
    int64_t start_utc_ns; /* of the exposure; TTF_NS_UNKNOWN */
    struct ttf_image *image;
};

/*
 * role "raw" or "developed": writes that file and appends its reference to the
 * image. A negative errno leaves the image as it was.
 */
TTF_MUST_USE int ttf_darkroom_print(struct ttf_darkroom *room, struct ttf_writer *writer,
                                    const char *role, const struct ttf_print *print,
                                    struct ttf_err *err);

/* The reference patch's level, where there is one. */
void ttf_darkroom_reference(struct ttf_darkroom *room, const struct ttf_print *print);

#endif
