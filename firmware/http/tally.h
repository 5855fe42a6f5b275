/* SPDX-License-Identifier: Apache-2.0 */
/* tally.h: slots of a dataset that grows, counted as they come. One thread at a time. */
#ifndef HTTP_TALLY_H
#define HTTP_TALLY_H

#include "ttf/base/attr.h"
#include "ttf/dataset/growth.h"
#include "ttf/dataset/reader.h"

/* Zeroed: nothing is counted yet. */
struct tally {
    struct ttf_growth growth;
    struct ttf_reader_summary summary; /* all but sealed and unterminated */
};

/*
 * Counts what is new of records.jsonl. -ENODATA: it does not count as a whole file of good lines (damage, an end without
 * its line end), and a reader has to judge it. Errors of reading.
 */
TTF_MUST_USE int tally_read(struct ttf_io *io, const char *records, struct tally *tally);

#endif
