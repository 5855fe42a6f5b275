/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sample_table.h: samples as a spreadsheet saves them (CSV): a line of column names (id, x, y, width, height; title, or species or material;
 * treatment; in any order), then a line for each sample. Apart by commas, semicolons or tabs, as the first line is; fields may be
 * quoted. An empty field says nothing, and a line of empty fields is none.
 */
#ifndef CLI_SAMPLE_TABLE_H
#define CLI_SAMPLE_TABLE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/samples.h"

struct sample_table {
    unsigned n;
    struct ttf_sample_change *changes; /* texts are those of `text` */
    struct ttf_sample_rect *regions;
    char *text;
};

/* -EINVAL naming the line and what is wrong with it; to be given to sample_table_free whatever is returned. */
TTF_MUST_USE int sample_table_read(struct ttf_io *io, const char *path, struct sample_table *ret,
                                   struct ttf_err *err);
void sample_table_free(struct sample_table *table);

#endif
