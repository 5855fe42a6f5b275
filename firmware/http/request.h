/* SPDX-License-Identifier: Apache-2.0 */
/* request.h: what a handler of a route sees, and what it gives back. Private to this room. */
#ifndef HTTP_REQUEST_H
#define HTTP_REQUEST_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#include "derived.h"
#include "folder.h"
#include "summaries.h"
#include "ttf/dataset/io.h"
#include "ttf/http/routes.h"

struct ttf_http_request {
    const struct folder *folder;
    struct ttf_io *io;
    struct summaries *summaries;
    struct derived *derived;
    const struct ttf_http_match *match;
    struct ttf_err err; /* what a handler that fails leaves */
};

/* Bytes that are made as they are sent. */
struct answer_source {
    ssize_t (*read)(void *ctx, int64_t offset, void *buf, size_t n); /* 0: end; -errno */
    void (*done)(void *ctx);
    void *ctx;
};

/* Exactly one of text, fd, source; all of it belongs to the answer. */
struct ttf_http_answer {
    char *text; /* by malloc */
    int fd;     /* -1: none */
    struct answer_source source;
    int64_t bytes;      /* of the whole entity */
    const char *type;   /* static */
    bool ranges;        /* parts may be asked for */
    char etag[80];      /* without quotes; empty: none */
    char sha256[65];    /* hex, of the whole entity as recorded; empty: not known */
    char file_name[80]; /* to be saved under; empty: to be shown */
};

/* An empty answer. */
void answer_init(struct ttf_http_answer *answer);
void answer_free(struct ttf_http_answer *answer);

/* text, by malloc, which the answer takes. */
void answer_json(struct ttf_http_answer *answer, char *text, size_t bytes);

#endif
