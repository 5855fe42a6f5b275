/* SPDX-License-Identifier: Apache-2.0 */
/* routes.h: what can be asked for, as a table; openapi.yaml describes the same. */
#ifndef TTF_HTTP_ROUTES_H
#define TTF_HTTP_ROUTES_H

#include <stdbool.h>
#include <stddef.h>

/* Who may. */
enum ttf_http_access {
    TTF_HTTP_OPEN = 0, /* everybody who reaches the socket */
    TTF_HTTP_READ,     /* the token, but where the socket lets all read */
    TTF_HTTP_TOKEN,    /* the token, on every socket */
    TTF_HTTP_CHANGE,   /* the token, and that the request is no other page's */
    TTF_HTTP_CABLE     /* no token: a socket at which all may read, and no other page */
};

/* What a request brings. */
enum ttf_http_body {
    TTF_HTTP_NO_BODY = 0,
    TTF_HTTP_JSON,       /* application/json */
    TTF_HTTP_JSON_MAYBE, /* the same, or nothing */
    TTF_HTTP_YAML        /* application/yaml */
};

/* Where it is answered. Each lane has threads and a queue of its own: nothing in one waits for what is in another. */
enum ttf_http_lane {
    TTF_HTTP_AT_ONCE = 0, /* by the thread that has the connection */
    TTF_HTTP_STOPS,       /* an end of what runs: a sync of the disk, whatever else is asked */
    TTF_HTTP_ORDERS,      /* a start, which may wait for devices or read much; a note */
    TTF_HTTP_WORK,        /* what reads much, or waits for devices */
    TTF_HTTP_PICTURES,    /* what makes pictures, or waits for one */
    TTF_HTTP_LANES
};

/* Bytes: of a plan; of JSON; of what everybody may send. */
#define TTF_HTTP_BODY_MAX      ((size_t)256 * 1024)
#define TTF_HTTP_JSON_BODY_MAX ((size_t)32 * 1024)
#define TTF_HTTP_OPEN_BODY_MAX ((size_t)1024)

#define TTF_HTTP_NAME_MAX 64  /* bytes of a dataset's name */
#define TTF_HTTP_REST_MAX 192 /* bytes of a path inside it */

/* What it gives where nothing is wrong. The server holds its answers to this: a handler says no type, and what is not here is not sent. */
struct ttf_http_type {
    const char *end, *type; /* of a {path} that ends so; "": of any other */
};

struct ttf_http_gives {
    const struct ttf_http_type *types; /* the first that fits; ended by one of NULL */
    unsigned status;
    bool none;                /* 204: it is known, and has nothing to give */
    bool tagged;              /* with an ETag: 304 by If-None-Match */
    bool ranges;              /* parts by Range: 206, 416 */
    bool resumes;             /* goes on behind Last-Event-ID */
    const char *const *query; /* parameters that are read, NULL-ended; NULL: none */
};

/* The type of what has this path; NULL: nothing has it. */
const char *ttf_http_type_of(const struct ttf_http_gives *gives, const char *path);

/* Is that parameter read? */
bool ttf_http_asks(const struct ttf_http_gives *gives, const char *name);

struct ttf_http_request; /* private: request.h */
struct ttf_http_answer;

struct ttf_http_route {
    const char *method; /* "GET"; HEAD goes with it */
    const char
        *pattern; /* "/api/v1/datasets/{name}/files/{path}": {name} one segment, {path} the rest */
    enum ttf_http_access access;
    int (*answer)(struct ttf_http_request *request, struct ttf_http_answer *ret);
    enum ttf_http_body body;
    enum ttf_http_lane lane;
    const struct ttf_http_gives *gives;
};

/* The i-th, or NULL. */
const struct ttf_http_route *ttf_http_route(size_t i);

/* The methods of all routes with this path, as an Allow header has them: "GET, HEAD, POST". Returns ret. */
const char *ttf_http_route_methods(const char *url, char ret[64]);

/* What a path named. */
struct ttf_http_match {
    const struct ttf_http_route *route;
    char name[TTF_HTTP_NAME_MAX + 1]; /* {name}, as it came: not checked yet */
    char path[TTF_HTTP_REST_MAX + 1]; /* {path} */
};

/*
 * Which route a request is for. -ENOENT: none has such a path; -ENOTSUP: one has, but not this method. Any thread.
 */
int ttf_http_route_find(const char *method, const char *url, struct ttf_http_match *ret);

#endif
