/* SPDX-License-Identifier: Apache-2.0 */
/*
 * session_box.h: whole sessions of a simulated box on an I/O table, boot after boot, and what they promised.
 *
 * A slot is acknowledged when the session tells that its record is committed.
 */
#ifndef TTF_TESTS_CRASH_SESSION_BOX_H
#define TTF_TESTS_CRASH_SESSION_BOX_H

#include <stdbool.h>
#include <stdint.h>

#include "session_living.h"
#include "ttf/capture/session.h"
#include "ttf/dataset/reader.h"

#define SESSION_PATH       "/data/run"
#define SESSION_SECOND     "/second" /* the folder of the second storage, where the plan names it */
#define SESSION_SLOTS_MAX  12
#define SESSION_EVENTS_MAX 96
#define SESSION_TEXT_BYTES 128

struct session_slot {
    bool acknowledged;
    int result;
    uint64_t
        hash; /* of the record as it could be read when it was acknowledged; 0: not looked at */
};

/* Copied with =. */
struct session_promise {
    bool armed; /* dataset and segment are there */
    bool sealed;
    bool maybe_sealed; /* it was, by a plan with fewer slots */
    bool troubled;     /* the disk has failed: files of no record may stay, and slots be lacking */
    int plan;          /* of its living's plans, in force: armed with, or answered */
    uint32_t done;     /* of its living's asks, answered with 0: bits */
    int64_t n_slots;   /* acknowledged: 0..n_slots-1 */
    unsigned n_events;
    struct session_slot slots[SESSION_SLOTS_MAX];
};

struct session_box {
    struct ttf_io *io; /* borrowed */
    struct ttf_plan plan;
    int64_t power_on_ns;            /* since the first power-on */
    const char *calibration_folder; /* NULL: none */
    const struct living *living;    /* what people ask; borrowed, NULL: nothing */
    int given;                      /* the plan is this one of its plans */
    uint32_t asks;                  /* of its asks, in the next boot: bits */
    bool read_back;                 /* records are read when they are acknowledged */
    /* of all boots so far */
    struct session_promise promise;
    char events[SESSION_EVENTS_MAX][SESSION_TEXT_BYTES];
    /* of the last boot */
    struct ttf_box *box; /* NULL but during it */
    int code;
    struct ttf_err err;
    struct ttf_session_result result;
    int64_t ended_ns;     /* since the first power-on */
    bool armed;           /* in this boot */
    bool stopped;         /* as it was asked to */
    int64_t slots_before; /* acknowledged before it */
    unsigned alarms, alarms_over;
    struct ttf_control *control; /* NULL but during it */
    int64_t numbers[LIVING_ASKS_MAX];
    int answers[LIVING_ASKS_MAX]; /* -EAGAIN: none yet; -ENOENT: not asked */
    char broken[512]; /* the first thing that was not as it must be; empty: all is well */
};

/* A plan of `slots` slots, one a minute, of 16 x 16 pixels; with a second storage or without. */
void session_box_init(struct session_box *s, struct ttf_io *io, int64_t slots, bool second);

/* People ask these things, all from the first boot on. To be called after init and before the first boot. */
void session_box_live(struct session_box *s, const struct living *living);

/* The next boot: by this plan of the living's, and with those asks again that are not answered and still make sense. */
void session_box_go_on(struct session_box *s, int given, bool ask_again);

/* How many slots the run is to have in the end, by the plan in force. */
int64_t session_box_count(const struct session_box *s);

/* Takes note of what was answered so far; during a boot. */
void session_box_hear(struct session_box *s);

/* Since the first power-on; during a boot. */
int64_t session_box_elapsed_ns(const struct session_box *s);

/* One boot of the box: the session from its beginning to its end. The code is s->code. */
void session_box_boot(struct session_box *s);

/* Keeps the first. */
void session_box_break(struct session_box *s, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* ---- the datasets of the run ---- */

/* Where the second storage's dataset is; empty without one. */
void session_box_second_path(const struct session_box *s, char ret[600]);

/*
 * The record that counts for this slot: of the second dataset if its first segment begins with that slot or before it,
 * else of the first. 0 or -ENOENT; another error: that dataset cannot be read.
 */
int session_box_record(const struct session_box *s, int64_t index, struct ttf_slot_record *ret);

#endif
