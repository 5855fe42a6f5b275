/* SPDX-License-Identifier: Apache-2.0 */
/*
 * calibrations.h: calibrations that are made through the interface: one step at a time, asked for by any thread, done by the
 * one that owns the devices while nothing runs. They lie below the state's folder, and one of them is in use.
 */
#ifndef DAEMON_CALIBRATIONS_H
#define DAEMON_CALIBRATIONS_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"
#include "ttf/http/box.h"

#define CALIBRATION_PATH 700

struct calibrations;

/* state: the folder; configured: the configuration's calibration, "" for none. Borrowed. NULL: no memory. */
struct calibrations *calibrations_create(struct ttf_io *io, struct ttf_clock *clock,
                                         const char *state, const char *configured);
void calibrations_destroy(struct calibrations *calibrations); /* NULL allowed */

/* ---- whoever asks; any thread ---- */

/* -EBUSY: something runs, or is to run; a step is waited for, or under way; -EEXIST: it is there, nothing is overwritten; -EINVAL. */
TTF_MUST_USE int calibrations_ask(struct calibrations *calibrations,
                                  const struct ttf_http_calibrate *what, struct ttf_err *err);

/* All of it, as JSON (openapi.yaml), by malloc. */
TTF_MUST_USE int calibrations_show(struct calibrations *calibrations, char **ret_json,
                                   struct ttf_err *err);

/* From the next run that begins on; "": the configuration's again. -ENOENT: there is none of this name; errors of the disk. */
TTF_MUST_USE int calibrations_use(struct calibrations *calibrations, const char *name,
                                  struct ttf_err *err);

/*
 * Takes it away, for good. -EBUSY: it is in use, configured, being made, or of the run under way; -ENOENT; errors of the disk, after
 * which it is there whole, or gone but for room that the next removal, or start, gives back.
 */
TTF_MUST_USE int calibrations_remove(struct calibrations *calibrations, const char *name,
                                     struct ttf_err *err);

/* ---- the owner of the devices ---- */

/*
 * The one in use: 1, and it is not taken away until calibrations_let_go; 0: none. Errors of the disk, -ENOENT too: one was chosen,
 * and it is not left out without a word.
 */
TTF_MUST_USE int calibrations_in_use(struct calibrations *calibrations, char ret[CALIBRATION_PATH],
                                     struct ttf_err *err);

/* The run is over that was to be developed with what was in use. */
void calibrations_let_go(struct calibrations *calibrations);

/* From now on steps may be asked for, until calibrations_give_up; at first they may not. */
void calibrations_open(struct calibrations *calibrations);

/* The step that waits, which is under way from now on. false: none does. */
bool calibrations_begin(struct calibrations *calibrations, struct ttf_http_calibrate *ret);

/* How long the step may take at the most. */
void calibrations_at_most(struct calibrations *calibrations, int64_t ns);

/* It is over: r 0, or why it was refused. */
void calibrations_end(struct calibrations *calibrations, int r, const struct ttf_err *err);

/* A run takes the devices, or is to: a step that still waits is not done any more, and none may be asked for. */
void calibrations_give_up(struct calibrations *calibrations);

/* Says that the calibration has the part already. -EEXIST. */
int calibrations_refuse_twice(const char *name, enum ttf_calibration_part part,
                              struct ttf_err *err);

/* Where a calibration of this name lies. */
void calibrations_path(const struct calibrations *calibrations, const char *name,
                       char ret[CALIBRATION_PATH]);

#endif
