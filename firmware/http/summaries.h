/* SPDX-License-Identifier: Apache-2.0 */
/*
 * summaries.h: what a dataset is, in JSON, remembered as long as its files do not change: counting 10,000 slots takes
 * a moment, being asked once a second by many would take all of them. Any thread.
 */
#ifndef HTTP_SUMMARIES_H
#define HTTP_SUMMARIES_H

#include <stddef.h>

#include "folder.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

struct summaries;

struct summaries *summaries_create(void); /* NULL: no memory */
void summaries_destroy(struct summaries *summaries);

/* A JSON object, by malloc. -ENOENT: no dataset of that name; errors of reading it. */
TTF_MUST_USE int summaries_get(struct summaries *summaries, const struct folder *folder,
                               struct ttf_io *io, const char *dataset, char **ret_text,
                               struct ttf_err *err);

#endif
