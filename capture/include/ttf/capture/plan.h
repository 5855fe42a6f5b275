/* SPDX-License-Identifier: Apache-2.0 */
/*
 * plan.h: what a user wants captured, as a plain struct. Reading it from YAML,
 * with units and file:line, is firmware/config's; whether it makes sense on a
 * given box is ttf_plan_check's.
 */
#ifndef TTF_CAPTURE_PLAN_H
#define TTF_CAPTURE_PLAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/hal/box.h"

#define TTF_PLAN_SHOTS_MAX    8
#define TTF_PLAN_BRACKETS_MAX 8
#define TTF_PLAN_AVERAGE_MAX  64

enum ttf_lamp_mode {
    TTF_LAMPS_NONE = 0,     /* natural light, or no lamps */
    TTF_LAMPS_CONTINUOUS,   /* on from start to end */
    TTF_LAMPS_CAPTURE_ONLY, /* on settle_ns before each shot, off after the slot */
    TTF_LAMPS_PHOTOPERIOD /* day: growth light; each shot sets its own levels settle_ns before it */
};

/* What ends a run. */
enum ttf_plan_end {
    TTF_END_COUNT = 0, /* so many slots */
    TTF_END_UNTIL,     /* an instant: the slots due before it */
    TTF_END_LENGTH,    /* a time since slot 0 was due: the slots due before it is over */
    TTF_END_UNTOLD /* of a dataset of before this was kept: count stands for whatever was meant, and ends it */
};

enum ttf_keep {
    TTF_KEEP_DEFAULT = 0, /* raw above 4 megapixels, both below */
    TTF_KEEP_RAW,
    TTF_KEEP_DEVELOPED,
    TTF_KEEP_BOTH
};

struct ttf_lamp_level {
    char lamp[32];
    unsigned permille;
};

/* One stream's exposure(s) within a slot. */
struct ttf_plan_shot {
    char stream[32];   /* "main" by default */
    char camera[32];   /* "main" by default */
    char channel[32];  /* lamp state's name, "white" by default */
    unsigned n_levels; /* lamps during this shot; lamps not named are 0 */
    struct ttf_lamp_level levels[TTF_LAMPS_MAX];
    struct ttf_exposure exposure;           /* of the reference; exposure_ns > 0 */
    unsigned n_brackets;                    /* 0 or 1: none */
    double brackets[TTF_PLAN_BRACKETS_MAX]; /* relative exposures, one of them 1 */
    unsigned average;                       /* frames averaged per image, 1..64 */
};

struct ttf_plan {
    char title[128];
    int64_t interval_ns; /* >= 100 ms */
    /* slots; > 0. Of a plan that ends otherwise: what that came to when it was made; a run counts anew (README.md, "Until") */
    int64_t count;
    enum ttf_plan_end end;
    int64_t until_utc_ns; /* UNTIL; else 0 */
    int64_t length_ns;    /* LENGTH; else 0 */
    /* start: 0 = as soon as ready, else UTC of slot 0 */
    int64_t start_utc_ns;
    enum ttf_lamp_mode lamps;
    int64_t settle_ns; /* of lamps before a shot; 0: the lamps' own warm_up */
    /* photoperiod: on for day_ns of each period, from phase. In elapsed time; or, with photoperiod_local, day begins at
     * day_start_s of local time, resolved once with zone and offset. */
    int64_t day_ns, period_ns, phase_ns;
    bool photoperiod_local;
    int day_start_s;
    unsigned n_day_levels;
    struct ttf_lamp_level day_levels[TTF_LAMPS_MAX];
    char zone[64];     /* IANA name, "UTC" by default */
    int zone_offset_s; /* resolved */
    unsigned n_shots;  /* 1..TTF_PLAN_SHOTS_MAX */
    struct ttf_plan_shot shots[TTF_PLAN_SHOTS_MAX];
    double mains_hz;          /* 50 or 60: exposures snap to whole half-periods; 0: no snapping */
    struct ttf_region region; /* of the raw frame; width 0: all */
    struct ttf_region reference; /* patch within the region whose level is watched; width 0: none */
    enum ttf_keep keep;
    double mm_per_px;      /* 0: not known */
    int64_t reserve_bytes; /* disk kept free; capture stops before it */
    /* Absolute path of a folder on another disk, where the run goes on when the dataset's own fails; empty: none. */
    char second_storage[512];
    char group
        [65]; /* a dataset beside the run's own: it begins in the group of that one; empty: in none */
};

/* One shot "main" of 20 ms at unity gain, lamps none, 50 Hz, reserve 256 MiB; interval and count 0. */
void ttf_plan_defaults(struct ttf_plan *plan);

/* Figures of a plan on a box, for people. */
struct ttf_plan_figures {
    int64_t slots;
    int64_t duration_ns; /* first to last slot */
    int64_t ready_ns;    /* from a beginning at once to the first slot, at least: lamps settle */
    int64_t bytes;       /* of the dataset, estimated */
    int64_t slot_bytes;
    int64_t slot_busy_ns; /* from the first lamp command to the last exposure's end */
    int64_t lamp_on_ns[TTF_LAMPS_MAX];
    int64_t lamp_switchings[TTF_LAMPS_MAX];
    unsigned lamp_duty_permille[TTF_LAMPS_MAX];
    int64_t memory_bytes;
    int64_t exposure_ns[TTF_PLAN_SHOTS_MAX]; /* the reference, as snapped */
    /* Bands of lamps dimmed by pulses (PWM): most light of a row less the least, as ppm; of the shot's shortest exposure. */
    int64_t flicker_ppm[TTF_PLAN_SHOTS_MAX];
};

/* Bands beyond this many ppm show in a dataset. */
#define TTF_FLICKER_SHOWS_PPM 2000

/*
 * Validates the plan against itself and, if box is not NULL, against the box
 * (camera names, limits, lamp names, max_on, max_duty, time within the interval);
 * the camera must have been configured. -EINVAL; err->where names the plan's
 * field ("interval", "shots[1].exposure", "lamps.settle") so that the reader of
 * the file can say its line.
 */
TTF_MUST_USE int ttf_plan_check(const struct ttf_plan *plan, const struct ttf_box *box,
                                struct ttf_plan_figures *ret, struct ttf_err *err);

/* Title, counts, times, sizes and flicker as keys of the object that is being written: what `plan check` and a box say alike. */
void ttf_plan_figures_put(const struct ttf_plan *plan, const struct ttf_plan_figures *figures,
                          struct ttf_json *json);

/* The resolved plan as JSON (plans/N.json), units normalised; free with free(). */
TTF_MUST_USE int ttf_plan_json(const struct ttf_plan *plan, char **ret_text, struct ttf_err *err);

/* The reverse. -EINVAL, naming the field, for anything that ttf_plan_json does not write. */
TTF_MUST_USE int ttf_plan_read(const char *text, size_t bytes, const char *where,
                               struct ttf_plan *ret, struct ttf_err *err);

/*
 * 1 if both ask for the same, else 0: by all fields but those that a run resolves when it begins (the zone's
 * offset; the phase of a day that begins at a local time; how many slots there are until an instant). Where one
 * does not tell what ends it, their counts are compared. -ENOMEM.
 */
TTF_MUST_USE int ttf_plan_same(const struct ttf_plan *a, const struct ttf_plan *b);

#endif
