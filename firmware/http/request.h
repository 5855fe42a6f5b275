/* SPDX-License-Identifier: Apache-2.0 */
/* request.h: what a handler of a route sees, and what it gives back. Private to this room. */
#ifndef HTTP_REQUEST_H
#define HTTP_REQUEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>
#include <sys/types.h>

#include "derived.h"
#include "folder.h"
#include "summaries.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/io.h"
#include "ttf/http/box.h"
#include "ttf/http/routes.h"

struct MHD_Connection;

struct ttf_http_request {
    const struct folder *folder;
    struct ttf_io *io;
    struct summaries *summaries;
    struct ttf_http_box *box;       /* NULL: there is none */
    struct ttf_http_events *events; /* NULL: there are none */
    const int *leaving; /* atomically: not 0: the socket that it came by is being left */
    struct derived *derived;
    const struct ttf_http_match *match;
    struct MHD_Connection *connection; /* of request_header and request_query alone */
    const char *token;                 /* NULL: there is none */
    bool may_read, may_change;         /* whoever asks, whatever this route is */
    bool at_cable;                     /* it came by a socket at which all may read */
    const char *body;                  /* a zero behind it; "" without one */
    size_t body_bytes;
    struct ttf_err err; /* what a handler that fails leaves */
};

/* A header; a parameter of the URL's query, if the route knows it. NULL: not said. */
const char *request_header(const struct ttf_http_request *request, const char *name);
const char *request_query(const struct ttf_http_request *request, const char *name);

/* Bytes that are made as they are sent. */
struct answer_source {
    ssize_t (*read)(void *ctx, int64_t offset, void *buf, size_t n); /* 0: end; -errno */
    void (*done)(void *ctx);
    void *ctx;
};

#define ANSWER_HEADERS_MAX 4

/* At most one of text, fixed, fd, source, listener; all of it but what fixed points at belongs to the answer. */
struct ttf_http_answer {
    char *text;        /* by malloc */
    const void *fixed; /* stays as long as the program */
    int fd;            /* -1: none */
    struct answer_source source;
    struct event_listener *listener; /* an event stream's; never ends by itself */
    int64_t bytes;                   /* of the whole entity */
    unsigned status;                 /* of all of it; the route's, as its type */
    const char *type;                /* static */
    bool page;                       /* the page's own scripts may run in it */
    bool ranges;                     /* parts may be asked for */
    bool none;          /* it is there, and there is nothing to give: of a route that says so */
    char etag[80];      /* without quotes; empty: none */
    char sha256[65];    /* hex, of the whole entity as recorded; empty: not known */
    char file_name[80]; /* to be saved under; empty: to be shown */
    unsigned n_headers; /* further ones */
    struct {
        const char *name; /* static */
        char value[256];
    } headers[ANSWER_HEADERS_MAX];
};

/* An empty answer. */
void answer_init(struct ttf_http_answer *answer);
void answer_free(struct ttf_http_answer *answer);

/* A file's first bytes, so many; the answer takes the descriptor. Their tag is their number, the file's time and inode. */
void answer_file(struct ttf_http_answer *answer, int fd, int64_t bytes, const struct stat *st);

/* text, by malloc, which the answer takes. */
void answer_json(struct ttf_http_answer *answer, char *text, size_t bytes);

/* A further header. */
void answer_header(struct ttf_http_answer *answer, const char *name, const char *fmt, ...)
    TTF_PRINTF(3, 4);

/* {"ok":true}. -ENOMEM. */
TTF_MUST_USE int answer_done(struct ttf_http_request *request, struct ttf_http_answer *answer);

#endif
