/* SPDX-License-Identifier: Apache-2.0 */
/* calibration_of_run.h: what a run is developed with. */
#ifndef DAEMON_CALIBRATION_OF_RUN_H
#define DAEMON_CALIBRATION_OF_RUN_H

#include "calibrations.h"

/*
 * 1: with what lies in *ret; 0: with none. A new run takes the calibration in use. One that is gone on with (its dataset exists)
 * keeps what it began with, whatever is in use now: its dataset's own, of several that of its last pictures; none, if it has
 * none. One that was cut off before its own was brought there, as its dataset says, takes that in use. Errors of the disk.
 */
TTF_MUST_USE int calibration_of_run(struct calibrations *calibrations, struct ttf_io *io,
                                    const char *dataset, bool exists, char ret[CALIBRATION_PATH],
                                    struct ttf_err *err);

#endif
