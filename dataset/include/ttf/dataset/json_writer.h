/* SPDX-License-Identifier: Apache-2.0 */
/*
 * json_writer.h: a small streaming writer of JSON text (UTF-8).
 *
 * Text grows in memory, which is kept for the next text by again(). The first failure (no memory, nesting beyond 16, a
 * double that is not finite) sticks: finish reports it, and calls in between need
 * no checks. 64-bit integers keep every digit.
 */
#ifndef TTF_DATASET_JSON_WRITER_H
#define TTF_DATASET_JSON_WRITER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

struct ttf_json {
    char *text; /* not terminated before finish */
    size_t used, room;
    int error;   /* 0 or the negative errno that stuck */
    bool pretty; /* two-space indent and a final newline; else one line without */
    unsigned depth;
    bool first[17];
    bool after_key;
};

void ttf_json_init(struct ttf_json *json, bool pretty);

/* Begins a new text in the memory of the last one. json was initialised once; a text handed out by finish is gone. */
void ttf_json_again(struct ttf_json *json, bool pretty);

/* Memory for a text of so many bytes: one that is no longer needs no other. -ENOMEM, the text unharmed. */
TTF_MUST_USE int ttf_json_reserve(struct ttf_json *json, size_t bytes);

void ttf_json_object(struct ttf_json *json); /* { */
void ttf_json_object_end(struct ttf_json *json);
void ttf_json_array(struct ttf_json *json); /* [ */
void ttf_json_array_end(struct ttf_json *json);
void ttf_json_key(struct ttf_json *json, const char *key);
void ttf_json_string(struct ttf_json *json,
                     const char *value); /* NULL: null. Bytes that are not UTF-8 become U+FFFD */
void ttf_json_int(struct ttf_json *json, int64_t value);
void ttf_json_double(struct ttf_json *json,
                     double value); /* shortest text that reads back the same */
void ttf_json_bool(struct ttf_json *json, bool value);
void ttf_json_null(struct ttf_json *json);

/* A key and its value. */
void ttf_json_kstring(struct ttf_json *json, const char *key, const char *value);
void ttf_json_kint(struct ttf_json *json, const char *key, int64_t value);
void ttf_json_kdouble(struct ttf_json *json, const char *key, double value);
void ttf_json_kbool(struct ttf_json *json, const char *key, bool value);

/* Text that is JSON already (one value), put in as it is. */
void ttf_json_raw(struct ttf_json *json, const char *text);

/* 0 and the zero-terminated text (belongs to json), or the error that stuck. */
TTF_MUST_USE int ttf_json_finish(struct ttf_json *json, const char **ret_text, size_t *ret_bytes);

/* The same, the text the caller's, to be given back by free; of json nothing is left, also on failure. ret_bytes: NULL allowed. */
TTF_MUST_USE int ttf_json_take(struct ttf_json *json, char **ret_text, size_t *ret_bytes);

/* Frees the text. */
void ttf_json_free(struct ttf_json *json);

#endif
