/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sim_run.h: whole captures in the simulated box: a box, a plan, a dataset in a
 * temporary folder, run after run (boot after boot), and what came of it.
 */
#ifndef TTF_TESTS_SIM_RUN_H
#define TTF_TESTS_SIM_RUN_H

#include <stdbool.h>

#include "ttf/capture/session.h"
#include "ttf/dataset/reader.h"
#include "ttf/hal/sim.h"

struct sim_run {
    /* change before sim_run_boot */
    struct ttf_sim_config config;
    struct ttf_plan plan;
    const char *scene; /* procedural */
    int64_t scene_span_ns;
    const char *calibration; /* folder; NULL: none */
    int64_t rehearse;
    /* what the disk says it has (but for a second storage); 0: as it is. May change while running, in on_progress */
    int64_t free_bytes;
    int64_t fs_errors; /* which its file system has found in itself, likewise */
    int64_t second_fs_errors;
    bool plain_disk;  /* the machine's files, none failing, and nobody waits for the disk */
    bool no_waiting;  /* nobody waits for the disk; files may fail */
    unsigned failing; /* so many file operations from now on give EIO; may be set in on_progress */
    void (*on_box)(struct sim_run *run);  /* before the session: run->box is there */
    void (*on_file)(struct sim_run *run); /* before each file operation */
    /* what an operation fails with, if it is to: an errno, else 0 */
    int (*fault)(struct sim_run *run, const char *op, const char *path);
    struct ttf_control *control; /* NULL: nobody asks anything */
    const char *plan_yaml;       /* as given */
    bool plan_as_given;
    void (*on_progress)(struct sim_run *run, const struct ttf_progress *progress);
    void (*at_end)(struct sim_run *run); /* after the session, before its box is gone */
    /* of all boots */
    char folder[64]; /* temporary; the dataset is in it */
    char path[96];
    volatile int stop;
    int64_t committed;    /* the slot told last, and one: slots with a record, as far as is known */
    unsigned alarms;      /* told */
    char alarm_text[512]; /* of the last one */
    unsigned alarms_over; /* of that one, told to be over */
    /* of the last boot */
    int code;
    struct ttf_err err;
    struct ttf_session_result result;
    int64_t ended_ns; /* since the first power-on */
    int64_t back_ns;  /* after a power cut: when the box has power again */
    unsigned bites;   /* of the watchdog */
    unsigned slots_told, events_told;
    struct ttf_box *box; /* during a boot */
};

/*
 * A box of 48 x 32 pixels with one shot at 20 ms, lamp "left" on 10 s before it,
 * every minute, six slots. Makes the folder.
 */
void sim_run_init(struct sim_run *run);

/* The same without a folder: set run->path. */
void sim_run_plain(struct sim_run *run);

/* One boot of the box: makes it, runs the session, destroys it. run->code is the session's. */
int sim_run_boot(struct sim_run *run);

/* Boots again and again, as long as power cuts end the runs. The last code. */
int sim_run_through_cuts(struct sim_run *run);

/* Adds a fault to the box. */
struct ttf_fault *sim_run_fault(struct sim_run *run, enum ttf_fault_kind kind, int64_t at_ns);

/* When slot k is due, since the first power-on, for a run that began with the box: about 12 s after power-on. */
int64_t sim_run_due_ns(const struct sim_run *run, int64_t k);

/* Of what fault is given. */
bool sim_run_path_ends(const char *path, const char *end);

/* Removes the folder. */
void sim_run_finish(struct sim_run *run);

/* ---- what came of it; all assert ---- */

/* The record of slot `index`; free it with ttf_slot_record_free. */
void sim_run_record(const struct sim_run *run, int64_t index, struct ttf_slot_record *ret);

/* When it was due, on the boot clock of its segment. */
int64_t sim_run_due_of(const struct sim_run *run, int64_t index);

/* The segment of slot `index`, and its number. */
int sim_run_segment_of(const struct sim_run *run, int64_t index, struct ttf_segment *ret);

/* The letters of all slots' results in order: c p m f z(paused) w(power), into ret. Asserts index 0..n-1. */
void sim_run_results(const struct sim_run *run, char *ret, size_t size);

/* Asserts that the results are these letters. */
void sim_run_expect(const struct sim_run *run, const char *letters);

/* How many lines of events.jsonl are of this kind and contain this text (NULL: any). */
unsigned sim_run_events(const struct sim_run *run, const char *kind, const char *text);

/* The whole text of a file of the dataset, to be freed; NULL if there is none. */
char *sim_run_text(const struct sim_run *run, const char *name);

/* Asserts that the file contains this. */
void sim_run_expect_text(const struct sim_run *run, const char *name, const char *what);

/* Asserts that image 0 of the slot has the flag. */
void sim_run_expect_flag(const struct sim_run *run, int64_t index, const char *flag);

/* Asserts that image 0 of the slot is there and has no flag. */
void sim_run_expect_no_flag(const struct sim_run *run, int64_t index);

/* Asserts that the slot's reason is this. */
void sim_run_expect_reason(const struct sim_run *run, int64_t index, const char *reason);

/* Deep verify: not damaged; sealed as said. */
void sim_run_expect_undamaged(const struct sim_run *run, bool sealed);

/* The same, and if it is sealed, every slot of the plan has its record. */
void sim_run_expect_whole(const struct sim_run *run, bool sealed);

#endif
