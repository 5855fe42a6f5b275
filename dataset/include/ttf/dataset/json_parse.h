/* SPDX-License-Identifier: Apache-2.0 */
/* json_parse.h: jansson's parser, by which no memory and no JSON are two things, and the former does no harm. */
#ifndef TTF_DATASET_JSON_PARSE_H
#define TTF_DATASET_JSON_PARSE_H

#include <jansson.h>
#include <stddef.h>

#include "ttf/base/attr.h"

/*
 * Parses a text of so many bytes. *ret is the caller's, by json_decref. -EINVAL: it is no JSON, or an object has a name
 * twice; *ret_where (NULL: not wanted) says where. -ENOMEM: nobody knows yet. Any thread.
 */
TTF_MUST_USE int ttf_json_parse(const char *text, size_t bytes, json_t **ret,
                                json_error_t *ret_where);

#endif
