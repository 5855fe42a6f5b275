/* SPDX-License-Identifier: Apache-2.0 */
/* vouched.h: the files that records name, each with its hash, so that a seal can be held against them without reading the files anew. One thread. */
#ifndef PULL_VOUCHED_H
#define PULL_VOUCHED_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "grown.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define VOUCHED_PATH 12 /* bytes of a SHA-256 of the path */
#define VOUCHED_HASH 32

struct vouched {
    struct vouched_file {
        uint8_t path[VOUCHED_PATH];
        uint8_t hash[VOUCHED_HASH];
        bool listed; /* it was asked for */
    } * files;       /* by path */
    size_t n, room;
    bool ended; /* the last record is one's end */
};

enum vouched_as {
    VOUCHED_NOT = 0, /* no record names it */
    VOUCHED_SO,
    VOUCHED_OTHERWISE
};

/* What one more record names; in their order. -ENOMEM. */
TTF_MUST_USE int vouched_add(struct vouched *vouched, const json_t *record);

/* When all were added: before anything is asked. */
void vouched_sort(struct vouched *vouched);

/* Both, of all records here, as the file lies there by its name now. 45 bytes are held for each file. *ret is to be freed, also on failure. -ENOMEM; errors of grown_each. */
TTF_MUST_USE int vouched_read(const struct grown *records, struct vouched *ret,
                              struct ttf_err *err);
void vouched_free(struct vouched *vouched);

enum vouched_as vouched_as(struct vouched *vouched, const char *path, const char *hex);

/* Has each file that a record names been asked for? */
bool vouched_all_listed(const struct vouched *vouched);

#endif
