/* SPDX-License-Identifier: Apache-2.0 */
/*
 * samples.h: which part of the picture is which sample: samples.json (FORMAT.md). Outside the seal, and written without
 * the dataset's lock, so that pots can be named while a capture runs, and after it was sealed.
 */
#ifndef TTF_DATASET_SAMPLES_H
#define TTF_DATASET_SAMPLES_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define TTF_SAMPLES_MAX 4096

struct ttf_sample_rect {
    int64_t x, y, width, height; /* pixels of the primary stream; width and height >= 1 */
};

/* A region of the picture with a name. */
struct ttf_sample_region {
    char id[64];
    char title[128];     /* species or material; empty: absent */
    char treatment[256]; /* empty: absent */
    struct ttf_sample_rect region;
};

/*
 * samples.json; *ret has *ret_n of them, to be freed. 0 and none if there is no such file; -EINVAL naming what is
 * wrong with it; -ENOMEM, errors of the disk.
 */
TTF_MUST_USE int ttf_samples_read(struct ttf_io *io, const char *path,
                                  struct ttf_sample_region **ret, unsigned *ret_n,
                                  struct ttf_err *err);

/* The sample of this id; NULL. */
const struct ttf_sample_region *ttf_samples_find(const struct ttf_sample_region *samples,
                                                 unsigned n, const char *id);

/* Whether all of it lies in a picture of that size. */
bool ttf_sample_rect_is_within(const struct ttf_sample_rect *region, int64_t width, int64_t height);

/* What is asked of one sample: what is NULL stays as it is. */
struct ttf_sample_change {
    const char *id;
    bool remove;                          /* and nothing else */
    const char *title, *treatment;        /* "": none any more */
    const struct ttf_sample_rect *region; /* must be there of a sample that is new */
};

/*
 * Makes n changes at once, all or none; new samples come behind those that are there. When this returns 0 they are on
 * the disk and stay there; else the file may be seen changed and is not promised, or is as it was. Fields that FORMAT.md
 * does not know are kept. -EINVAL naming the sample and what is wrong with it: no id, one that is changed twice, texts too long or
 * with control characters, a region outside of the primary stream's picture; also if samples.json is not understood, which is left alone then. -ENOENT: there
 * is no dataset at path, or nothing to remove. -EAGAIN, at once, while another writes; try again. Any thread, any process.
 */
TTF_MUST_USE int ttf_samples_change(struct ttf_io *io, const char *path,
                                    const struct ttf_sample_change *changes, unsigned n,
                                    struct ttf_err *err);

#endif
