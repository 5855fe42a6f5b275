/* SPDX-License-Identifier: Apache-2.0 */
/* newest.h: which picture of a dataset is its newest, from the end of its records alone: however many there are, it takes as long. */
#ifndef HTTP_NEWEST_H
#define HTTP_NEWEST_H

#include <stdbool.h>
#include <stdint.h>

#include "folder.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"

struct newest {
    int64_t index;   /* of its slot */
    char stream[32]; /* an id of the manifest */
    char path[192];  /* of its file */
    char sha256[65];
};

/* -ENOENT: no such dataset, or no picture near the end of its records; errors of reading. */
TTF_MUST_USE int newest_find(const struct folder *folder, const char *dataset, struct newest *ret,
                             struct ttf_err *err);

/* The same of a line: 0, or -ENOENT: it is none of a slot with a picture. -ENOMEM. */
TTF_MUST_USE int newest_of_line(const char *line, size_t bytes, struct newest *ret);

#endif
