/* SPDX-License-Identifier: Apache-2.0 */
/* preview.h: what the files of this program share (README.md). One thread. */
#ifndef PREVIEW_PREVIEW_H
#define PREVIEW_PREVIEW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/growth.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"

#define PREVIEW_FRAMES 48

struct preview_options {
    const char *folder;   /* of datasets */
    char configured[512]; /* where a configuration names it */
    const char *ttfbox;   /* the program */
    int64_t every_ns;     /* from refresh to refresh, at least */
    int64_t memory_bytes, room_bytes;
    int64_t time_ns;
    bool eager; /* not the last in everything */
    bool once;
    const volatile int *stop;
};

/* ---- humble.c ---- */

/* The last in everything. What cannot be had is left: a limit that fails is said. */
TTF_MUST_USE int preview_be_humble(const struct preview_options *options, struct ttf_err *err);

/* ---- look.c ---- */

/* A dataset as it is now. Zeroed: none. */
struct preview_subject {
    char name[65];
    char path[4096];
    char uuid[37];
    bool ended;
    struct ttf_growth growth;
    int64_t images; /* slots with a developed image */
    int64_t raw;    /* slots with raw frames alone */
    bool raw_said;
    int64_t last_index;
    char passed_over[65]; /* the newest folder, if its manifest cannot be read; empty: none */
};

/* The dataset whose records grew last, read on to its present end; folders whose manifest cannot be read are passed over.
 * -ENOENT: there is none. */
TTF_MUST_USE int preview_find(struct ttf_io *io, const char *folder,
                              struct preview_subject *subject, struct ttf_err *err);

/* ---- cache.c ---- */

struct preview_cache {
    char path[4200]; /* FOLDER/.preview/NAME */
    int generation;  /* in force; 0: none */
    int64_t images, tried_images;
    int64_t tries, tried_utc_ns; /* that failed, with tried_images; the last of them */
    char uuid[37];
    char *kept; /* the state in force, as JSON; NULL: none */
};

/* Takes FOLDER/.preview for this process. A descriptor to be kept open; -EAGAIN: another process has it. */
TTF_MUST_USE int preview_cache_lock(struct ttf_io *io, const char *folder, struct ttf_err *err);

/* Reads what is there of a dataset, and removes what a kill left. */
TTF_MUST_USE int preview_cache_open(struct ttf_io *io, const char *folder,
                                    const struct preview_subject *subject,
                                    struct preview_cache *ret, struct ttf_err *err);
void preview_cache_close(struct preview_cache *cache);

/* An empty CACHE/making. */
TTF_MUST_USE int preview_cache_begin(struct ttf_io *io, struct preview_cache *cache,
                                     struct ttf_err *err);

/* What was made, as state.json tells it. */
struct preview_made {
    uint32_t width, height; /* of the JPEGs */
    int64_t shrunk_by, frame_step;
    unsigned n_frames;
    int64_t slot[PREVIEW_FRAMES];
};

/* CACHE/making is whole: it comes into force. */
TTF_MUST_USE int preview_cache_commit(struct ttf_io *io, struct preview_cache *cache,
                                      const struct preview_subject *subject,
                                      const struct preview_made *made, int64_t utc_ns,
                                      struct ttf_err *err);

/* The try failed: what was in force stays, and says so; what was half made goes. */
TTF_MUST_USE int preview_cache_fail(struct ttf_io *io, struct preview_cache *cache,
                                    const struct preview_subject *subject, const char *why,
                                    int64_t utc_ns, struct ttf_err *err);

/* Removes the caches of datasets that are gone. */
void preview_cache_sweep(struct ttf_io *io, const char *folder);

/* ---- child.c ---- */

/* Is so much free where datasets lie? */
bool preview_has_room(const struct preview_options *options, int64_t bytes);

/* Runs the synthesis into CACHE/making/frames.rgb; what it says goes to CACHE/making/said.json. -EIO, -ETIME, -ECANCELED;
 * -ENOSPC: room went below half of what it is to be, and the child was ended. */
TTF_MUST_USE int preview_synthesize(const struct preview_options *options, struct ttf_clock *clock,
                                    const struct preview_subject *subject,
                                    const struct preview_cache *cache, struct ttf_err *err);

/* ---- strip.c ---- */

/* From frames.rgb and said.json to JPEGs, all in CACHE/making; takes the large file away. */
TTF_MUST_USE int preview_strip(struct ttf_io *io, const struct preview_subject *subject,
                               const struct preview_cache *cache, struct preview_made *ret,
                               struct ttf_err *err);

#endif
