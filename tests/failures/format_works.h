/* SPDX-License-Identifier: Apache-2.0 */
/*
 * format_works.h: pieces of work on pictures, calibrations, imports and exports, in a folder of an I/O table: small
 * ones, in which everything can be made to fail. Each returns what the function says that it tries, and asserts that
 * what it got is right.
 */
#ifndef TTF_TESTS_FORMAT_WORKS_H
#define TTF_TESTS_FORMAT_WORKS_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

/* Makes what the works begin with, in memory; the folder is there, and borrowed. */
void format_works_begin(struct ttf_io *on, const char *in_folder);
void format_works_end(void);

/* And in files of the folder. */
void format_works_files(void);

/* From now on in the folder of that name of another table. */
void format_works_on(struct ttf_io *on);

struct ttf_io *format_io(void);

/* A file of that name, as a work that writes into "new" writes it. Asserts. */
void format_keep(const char *name, int (*write)(struct ttf_err *err));

/* A file in the folder; good until the next call. */
const char *format_in(const char *name);

/* The file "new", which works that write write into. */
void format_open_new(void);
int format_close_new(void);

int format_write_tiff(struct ttf_err *err); /* into "new" */
int format_write_png(struct ttf_err *err);
int format_write_jpeg(struct ttf_err *err);
int format_write_dng(struct ttf_err *err);
int format_develop_to_tiff(struct ttf_err *err);
int format_develop_in_reserve(struct ttf_err *err);
int format_read_tiff(struct ttf_err *err);
int format_read_floats(struct ttf_err *err);
int format_read_png(struct ttf_err *err);
int format_read_jpeg(struct ttf_err *err);
int format_probe(struct ttf_err *err);
int format_read_dng(struct ttf_err *err);
int format_read_sequence(struct ttf_err *err);
int format_fit(struct ttf_err *err);
int format_save(struct ttf_err *err);
int format_load(struct ttf_err *err);
int format_import_pictures(struct ttf_err *err); /* into "out" */
int format_export_png(struct ttf_err *err);      /* into "out" */
int format_export_tiff(struct ttf_err *err);
int format_export_npy(struct ttf_err *err);
int format_export_y4m(struct ttf_err *err);
int format_export_sheet(struct ttf_err *err);
int format_write_floats(struct ttf_err *err);

#endif
