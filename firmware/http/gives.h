/* SPDX-License-Identifier: Apache-2.0 */
/* gives.h: what answers of routes are like: the kinds of them. Private to this room. */
#ifndef HTTP_GIVES_H
#define HTTP_GIVES_H

#include "ttf/http/routes.h"

extern const struct ttf_http_gives GIVES_JSON, GIVES_TAGGED_JSON, GIVES_ACCEPTED, GIVES_LINES,
    GIVES_FILE, GIVES_TAR, GIVES_VIDEO, GIVES_YAML, GIVES_JPEG, GIVES_THUMB, GIVES_LIVE,
    GIVES_EVENTS, GIVES_INDEX, GIVES_PAGE;

#endif
