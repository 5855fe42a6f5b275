/* SPDX-License-Identifier: Apache-2.0 */
/*
 * import_source.h: where frames come from, in order, one at a time; and the list of
 * pictures put in order. Private to import.
 */
#ifndef TTF_DATASET_IMPORT_SOURCE_H
#define TTF_DATASET_IMPORT_SOURCE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/io.h"

/* One picture, or one page of a stack. */
struct import_frame {
    const char *path; /* of the configuration */
    enum ttf_image_kind kind;
    unsigned page;
    int64_t taken_utc_ns; /* TTF_NS_UNKNOWN where order is not by time */
    int64_t slot;
};

struct import_list {
    struct import_frame *frame;
    size_t n;
    bool is_video; /* no frames: inputs[0] is for ffmpeg */
    bool timed;
};

/* Looks at each input, puts them in order. -EINVAL, -ENOTSUP as import.h says. */
TTF_MUST_USE int import_list_make(struct import_list *list, struct ttf_io *io,
                                  const struct ttf_import_config *config, struct ttf_err *err);

/*
 * Gives each frame its slot. *interval_ns 0: the median distance of timed frames, which are
 * then numbered one after another; else their slots are the nearest on the grid.
 */
TTF_MUST_USE int import_list_slots(struct import_list *list, int64_t *interval_ns,
                                   struct ttf_err *err);
void import_list_free(struct import_list *list);

struct import_source;

struct import_source_ops {
    /* The next frame in a fresh pixbuf, 1; at the end 0. *ret_name: what to call it in errors, until the next call. */
    int (*next)(struct import_source *source, struct ttf_pixbuf *ret,
                struct ttf_image_info *ret_info, const char **ret_name, struct ttf_err *err);
    void (*destroy)(struct import_source *source);
};

struct import_source {
    const struct import_source_ops *ops;
    int64_t total;    /* frames; 0: not known */
    int64_t frame_ns; /* a video's frame period, 0: not known */
};

TTF_MUST_USE int import_pictures(const struct import_list *list, struct ttf_io *io,
                                 struct import_source **ret, struct ttf_err *err);
TTF_MUST_USE int import_video(const struct ttf_import_config *config, struct import_source **ret,
                              struct ttf_err *err);

#endif
