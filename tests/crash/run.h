/* SPDX-License-Identifier: Apache-2.0 */
/* run.h: what is done to a dataset, step by step, and what was promised on the way. */
#ifndef TTF_TESTS_CRASH_RUN_H
#define TTF_TESTS_CRASH_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "disk.h"
#include "ttf/dataset/writer.h"

#define RUN_PATH        "/data/run" /* of the dataset */
#define RUN_CALIBRATION "/cal"
#define RUN_SLOTS_MAX   40
#define RUN_EVENTS_MAX  40
#define RUN_NOTES_MAX   40
#define RUN_SAMPLES_MAX 8

enum run_step {
    RUN_CREATE,    /* or opens what is there */
    RUN_SEGMENT,   /* a new one */
    RUN_CORRECT,   /* the last one */
    RUN_PLAN,      /* a changed plan */
    RUN_CALIBRATE, /* adds the calibration */
    RUN_SLOT_ONE,  /* one image, one small file */
    RUN_SLOT_TWO,  /* a bracket of two images of one file each, over more than one sector */
    RUN_SLOT_PAIR, /* one image with a developed and a raw file */
    RUN_SLOT_NONE, /* missed: no image */
    RUN_EVENT,
    RUN_NOTE,
    RUN_SAMPLE, /* a new one, and the first one changed */
    RUN_SEAL,
    RUN_REOPEN,  /* closes, and opens again */
    RUN_ABANDON, /* lets go without a word to the disk, and opens again */
    RUN_STEP_COUNT
};

/* A slot that was begun: what its record says, and whether it was acknowledged. */
struct run_slot {
    int64_t index;
    uint64_t hash; /* of its record's line, without seq */
    bool kept;     /* acknowledged */
};

/* What has been promised so far. Copied with =. */
struct run_promise {
    bool created;
    int segments, plans;           /* acknowledged */
    int segments_most, plans_most; /* begun */
    int64_t gap_ns;                /* of the last segment, as corrected last; acknowledged */
    bool gap_open;                 /* a correction was begun and not acknowledged */
    bool calibrated;
    bool sealed;       /* acknowledged, and nothing begun since */
    bool maybe_sealed; /* begun */
    bool troubled;     /* the disk failed, or the program was killed: files of no record may stay */
    unsigned n_slots, n_events, n_notes, n_samples;
    struct run_slot slots[RUN_SLOTS_MAX];
    bool events[RUN_EVENTS_MAX]; /* acknowledged; its text is "event N." */
    bool notes[RUN_NOTES_MAX];   /* acknowledged; its text is "note N." */
    /* acknowledged: sample "sN" is there, and the title of "all" is a number, N at least */
    bool samples[RUN_SAMPLES_MAX];
};

enum run_fault {
    RUN_WELL = 0,
    RUN_LOST,
    RUN_SHOWN,
    RUN_UNOPENABLE,
    RUN_OTHER,
    RUN_FAULT_COUNT
};

struct run {
    struct disk *disk; /* the caller's */
    struct ttf_writer *writer;
    struct run_promise promise;
    bool may_fail; /* faults are about: a step that fails promised nothing, and is no error */
    enum run_fault fault;
    char broken[512]; /* the first thing that was not as it must be; empty: all is well */
};

void run_init(struct run *run, struct disk *disk);

/* One step. False: run->broken says what went wrong, or, with may_fail, that it came to nothing. */
bool run_do(struct run *run, enum run_step step);

/* Lets go of the writer without touching the disk. */
void run_end(struct run *run);

/* Keeps the first. */
void run_break(struct run *run, enum run_fault fault, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A disk with the calibration and nothing else. */
struct disk *run_fresh_disk(void);

#endif
