/* SPDX-License-Identifier: Apache-2.0 */
/*
 * more_works.h: as format_works.h, which it stands on: small pictures, floats of a dataset, pictures ordered by their time,
 * notes, and what is measured on frames.
 */
#ifndef TTF_TESTS_MORE_WORKS_H
#define TTF_TESTS_MORE_WORKS_H

#include "ttf/base/err.h"

/* Makes what they begin with: frames in memory, and files beside those of format_works_files. */
void more_works_begin(void);
void more_works_files(void);
void more_works_end(void);

int more_show_small(struct ttf_err *err);
int more_read_float_dataset(struct ttf_err *err);
int more_import_by_time(struct ttf_err *err); /* into "out" */
int more_note(struct ttf_err *err);           /* onto "floats" */
int more_sample(struct ttf_err *err);         /* of "floats", which has one */
int more_measure_grid(struct ttf_err *err);
int more_measure_flicker(struct ttf_err *err);

#endif
