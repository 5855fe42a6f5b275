/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lines_cut.h: tells what a power cut left at the end of a log from a line that has changed. DESIGN.md, "A line".
 * For the store's files only.
 */
#ifndef TTF_DATASET_LINES_CUT_H
#define TTF_DATASET_LINES_CUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

/* How many bytes the whole line has with which the text begins, 0: it begins with none. */
size_t ttf_line_whole_in(const char *text, size_t n);

/* Would it be a whole line if one bit of it were another? n without the newline. */
bool ttf_line_nearly_holds(const char *line, size_t n);

/*
 * All that lies from `offset` on, where the line `due_seq` is due and something with a newline stands that is no line:
 * *ret_bytes of what was being written when the power went (bytes that did not reach the disk, newlines among what was there before),
 * 0 if it may be lines that were acknowledged. -EIO, -ENOMEM and what else reading gives.
 */
TTF_MUST_USE int ttf_lines_cut_off(struct ttf_io *io, int file, int64_t offset, int64_t due_seq,
                                   int64_t *ret_bytes);

#endif
