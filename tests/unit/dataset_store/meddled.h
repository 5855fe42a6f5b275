/* SPDX-License-Identifier: Apache-2.0 */
/* meddled.h: a store that is meddled with: a dataset whose people's files others change just when ours does. For tests of these. */
#ifndef MEDDLED_H
#define MEDDLED_H

#include "store_ios.h"
#include "ttf/dataset/io.h"

/* A dataset of 4 x 3 pixels, and a disk that lists what is done to it and fails on cue. */
struct meddled {
    const char *path;
    char log[4096];
    struct cue cue;
    struct ttf_io *io;
    const char *
        new_file; /* how the name of the file that takes the other's place begins: so it is listed */
    const char *
        meddles; /* just before that file is synced, once: a command of somebody's tool, in the dataset */
    void (*before)(
        void *ctx,
        const char *op); /* may be NULL: each operation, once the tool has done its part */
    void *ctx;
};

/* Made in the test's folder, and closed. new_file: as ".notes-new". */
void meddled_begin(struct meddled *m, void **state, const char *new_file);
void meddled_forget_log(struct meddled *m);
/* Nothing of any new file is left. */
void meddled_expect_no_new_file(const struct meddled *m);
void meddled_end(struct meddled *m);

#endif
