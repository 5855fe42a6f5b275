/* SPDX-License-Identifier: Apache-2.0 */
/*
 * calibration_folder.h: a calibration's folder, taken away. It is renamed first, to a name that no calibration has, and emptied
 * then: whenever the power goes, it is there whole, or gone.
 */
#ifndef DAEMON_CALIBRATION_FOLDER_H
#define DAEMON_CALIBRATION_FOLDER_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

/* Out of sight, at once. -ENOENT: there is none; errors of the disk, and it is there as before. above: where calibrations lie. */
TTF_MUST_USE int calibration_folder_put_aside(struct ttf_io *io, const char *above,
                                              const char *name, struct ttf_err *err);

/* For good, what was put aside, now or before a cut. An error of the disk leaves it for the next time. */
TTF_MUST_USE int calibration_folder_sweep(struct ttf_io *io, const char *above,
                                          struct ttf_err *err);

#endif
