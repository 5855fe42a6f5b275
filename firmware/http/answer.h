/* SPDX-License-Identifier: Apache-2.0 */
/* answer.h: an entity as libmicrohttpd's response: conditions, ranges, the headers of every answer. */
#ifndef HTTP_ANSWER_H
#define HTTP_ANSWER_H

#include <microhttpd.h>

#include "request.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"

/* Is the tag in an If-None-Match or the like ("a", W/"b", or *)? header NULL, or no tag: no. */
bool answer_lists_tag(const char *header, const char *etag);

/*
 * Queues what a handler gave; the answer's contents are the response's afterwards. parts: a Range counts, as it does for
 * GET alone (RFC 9110, 14.2).
 */
TTF_MUST_USE enum MHD_Result answer_send(struct MHD_Connection *connection, bool parts,
                                         struct ttf_http_answer *answer);

/* Queues an error as JSON, with the status that goes with its code. methods: what may be done, of -ENOTSUP. */
TTF_MUST_USE enum MHD_Result answer_error(struct MHD_Connection *connection, const char *methods,
                                          const struct ttf_err *err);

#endif
