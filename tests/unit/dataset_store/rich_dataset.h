/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rich_dataset.h: a dataset with everything that FORMAT.md knows, made through the
 * public writer: two cameras, three channels, brackets, averages with a refused shot,
 * streams of u8, u16, f16 and f32 samples, uncertainty and mask files, two plans, two
 * calibrations, three segments of which one is corrected, a group, notes, samples.
 */
#ifndef RICH_DATASET_H
#define RICH_DATASET_H

#include <stdint.h>

#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"

#define RICH_SLOTS \
    9 /* indices 0..3, then 6..8 behind an outage of unknown length, and 2 of power */

enum rich_ending {
    RICH_SEALED = 0,
    RICH_CLOSED, /* by the writer, not sealed: stopped */
    RICH_CUT     /* as power leaves it: the last lines have no newline */
};

void rich_manifest(struct ttf_manifest *manifest);

/* Makes it at path; calibration folders are made beside it. Fails the test if that does not work. */
void rich_build(struct ttf_io *io, const char *path, enum rich_ending ending);

/* The code or value of every sample of that image: what a reader must find. */
uint16_t rich_code(int64_t slot, int stream, int bracket);

#endif
