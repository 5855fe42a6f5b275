/* SPDX-License-Identifier: Apache-2.0 */
/*
 * json_read.h: typed fields out of parsed JSON, for the store's files only.
 *
 * The first wrong field sticks in `code` and is named in the error; later calls
 * return defaults, so that readers need one check at the end.
 */
#ifndef TTF_DATASET_JSON_READ_H
#define TTF_DATASET_JSON_READ_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

struct ttf_json_in {
    const char *where;   /* file or file:line */
    int wrong;           /* what a wrong field returns: -EINVAL, -TTF_EDAMAGED */
    struct ttf_err *err; /* may be NULL */
    int code;            /* 0, or the error that stuck */
    char at[128];        /* the object being read: "streams[1]."; "" at the top */
};

enum ttf_json_need {
    TTF_JSON_OPTIONAL = 0,
    TTF_JSON_REQUIRED,
    TTF_JSON_CUT /* optional; free text, cut at a character where it is longer than the room */
};

/* Says what is wrong with a field ("must be ...") and makes it stick. */
void ttf_in_wrong(struct ttf_json_in *in, const char *key, const char *fmt, ...) TTF_PRINTF(3, 4);

/* Sets `at` to the i-th element of an array ("images", 2 -> "images[2]."); "" and back: at[0] = 0. */
void ttf_in_at(struct ttf_json_in *in, const char *fmt, ...) TTF_PRINTF(2, 3);

/* NULL if absent or null. */
const json_t *ttf_in_object(struct ttf_json_in *in, const json_t *object, const char *key,
                            enum ttf_json_need need);
const json_t *ttf_in_array(struct ttf_json_in *in, const json_t *object, const char *key,
                           enum ttf_json_need need);

/* Leaves ret empty if absent. Longer than the room: wrong, unless it may be cut. */
void ttf_in_text(struct ttf_json_in *in, const json_t *object, const char *key, char *ret,
                 size_t size, enum ttf_json_need need);

/* `absent` if absent (and not required); wrong outside min..max. */
int64_t ttf_in_int(struct ttf_json_in *in, const json_t *object, const char *key, int64_t min,
                   int64_t max, int64_t absent, enum ttf_json_need need);
double ttf_in_double(struct ttf_json_in *in, const json_t *object, const char *key, double absent,
                     enum ttf_json_need need);
bool ttf_in_bool(struct ttf_json_in *in, const json_t *object, const char *key, bool absent,
                 enum ttf_json_need need);

/* Copies at most size - 1 bytes without cutting a character in two. */
void ttf_text_cut(char *dst, size_t size, const char *src);

#endif
