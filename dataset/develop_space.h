/* SPDX-License-Identifier: Apache-2.0 */
/* develop_space.h: the memory that developing works in. Private to develop. */
#ifndef TTF_DATASET_DEVELOP_SPACE_H
#define TTF_DATASET_DEVELOP_SPACE_H

#include "develop_strip.h"

/* Strips developed between two writes of a TIFF: enough for all threads to have work. */
#define CHUNK_STRIPS 8

unsigned develop_strips(const struct ttf_develop *develop);

/* For runs with so many threads; tiff: for ttf_develop_tiff, else for ttf_develop_run. -ENOMEM; as
 * ttf_tiff_writer_create. */
TTF_MUST_USE int develop_space_init(struct develop_space *space, const struct ttf_develop *develop,
                                    unsigned threads, bool tiff, struct ttf_err *err);
void develop_space_free(struct develop_space *space); /* a zeroed one is fine */

/*
 * *ret: the developer's own space if it was reserved for such a run, else own, made now: its error.
 * Free *own (zeroed before) when the run is over, whichever it was.
 */
TTF_MUST_USE int develop_space_for(struct ttf_develop *develop, const struct ttf_pool *pool,
                                   bool tiff, struct develop_space *own, struct develop_space **ret,
                                   struct ttf_err *err);

#endif
