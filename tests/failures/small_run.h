/* SPDX-License-Identifier: Apache-2.0 */
/*
 * small_run.h: everything a writer can do, in one short run, by a caller that believes what it is
 * told; and what must hold of the dataset afterwards.
 */
#ifndef TTF_TESTS_SMALL_RUN_H
#define TTF_TESTS_SMALL_RUN_H

#include "model_disk.h"
#include "ttf/dataset/writer.h"

#define SMALL_PATH    "/m/d"
#define SMALL_NOTES   4 /* the last by who goes on with it */
#define SMALL_SAMPLES 4 /* likewise */
#define SMALL_SLOTS   5 /* 0 to 3 captured, 4 missed */

/* What the caller does when a call fails. */
enum small_temper {
    SMALL_GIVES_UP, /* closes the writer */
    SMALL_REPEATS,  /* makes the same call again, once, of the same writer; then goes on */
    SMALL_PERSISTS /* opens the dataset anew and tries the same again, as the capture does; then goes on */
};

/* What it was told. */
struct small_run {
    struct ttf_io *io;
    enum small_temper temper;
    struct ttf_writer *writer;
    bool doubt;
    bool over;            /* it gave up, or the dataset cannot be had */
    bool created, sealed; /* for sure; sealed: and nothing was added since */
    bool tried[SMALL_SLOTS], committed[SMALL_SLOTS];
    bool noted[SMALL_NOTES];   /* acknowledged */
    bool named[SMALL_SAMPLES]; /* likewise: sample "N" */
    unsigned events;           /* acknowledged */
    unsigned refusals;         /* calls that returned an error */
    int first_code;            /* of the first of them */
    int silent; /* the first error without a message, or whose message has another code */
    const char *silent_in;
    char refused[640]; /* the last error, in words */
};

/* A disk with a calibration in /m/cal, all of it kept. */
void small_disk_init(struct model_disk *disk);

/* Creates, commits, adds events, notes and samples, copies a calibration, changes the plan, corrects a segment, seals, opens
 * again, goes on, seals again, adds a note and a sample to what is sealed. */
void small_run(struct small_run *run);

#define SMALL_TEXT 1024

/*
 * Whether on this disk
 *   verify finds no damage, every committed slot is there as it was, and no other is shown
 *   (ghosts: unless somebody tried to commit it);
 *   what was sealed is;
 *   it can be opened, gone on with, and sealed.
 * If not: what is wrong. The disk is changed.
 */
bool small_check(const struct small_run *run, struct model_disk *disk, bool ghosts,
                 char ret[SMALL_TEXT]);

#endif
