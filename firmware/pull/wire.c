/* SPDX-License-Identifier: Apache-2.0 */
#include "wire.h"

#include <curl/curl.h>
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define CONNECT_S 10L
#define SILENCE_S 30L   /* without a byte */
#define POST_MAX  65536 /* of an answer to what was sent */
#define SAID_MAX  2048  /* of what the box says of an error */

struct wire {
    CURL *curl;
    struct curl_slist *headers; /* of every request */
    char base[512];             /* "http://host:port/api/v1" */
    const struct ttf_pull_config *config;
    atomic_llong own_bytes, *bytes; /* bytes: of all twins, with whoever was first */
    /* of the request under way */
    const struct wire_sink *sink;
    int64_t asked_first;
    bool begun;
    bool headed;   /* the answer's head came to its end */
    bool measured; /* it says where its body ends */
    int sink_error;
    char said[SAID_MAX];
    size_t n_said;
};

static int init_curl(struct wire *wire, const char *token)
{
    CURL *curl = curl_easy_init();
    char header[256];

    wire->curl = curl;
    if (!curl)
        return -ENOMEM;
    if (token) {
        (void)snprintf(header, sizeof header, "Authorization: Bearer %s", token);
        wire->headers = curl_slist_append(NULL, header);
        if (!wire->headers)
            return -ENOMEM;
    }
    return 0;
}

static size_t on_header(char *line, size_t size, size_t n, void *ctx);
static size_t on_data(char *data, size_t size, size_t n, void *ctx);
static int on_progress(void *ctx, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d);

static int set_options(struct wire *wire)
{
    CURL *curl = wire->curl;

    return curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, on_data) ||
                   curl_easy_setopt(curl, CURLOPT_WRITEDATA, wire) ||
                   curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, on_header) ||
                   curl_easy_setopt(curl, CURLOPT_HEADERDATA, wire) ||
                   curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, on_progress) ||
                   curl_easy_setopt(curl, CURLOPT_XFERINFODATA, wire) ||
                   curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L) ||
                   curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L) ||
                   curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L) ||
                   curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https") ||
                   curl_easy_setopt(curl, CURLOPT_PROXY, "") || /* a box is near */
                   curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, CONNECT_S) ||
                   curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L) ||
                   curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, SILENCE_S) ||
                   curl_easy_setopt(curl, CURLOPT_BUFFERSIZE, 256L * 1024)
               ? -EINVAL
               : 0;
}

static int set_box(struct wire *wire, const char *box, struct ttf_err *err)
{
    size_t n = strlen(box);
    CURLcode set = CURLE_OK;

    if (strncmp(box, "unix:", 5) == 0) {
        set = curl_easy_setopt(wire->curl, CURLOPT_UNIX_SOCKET_PATH, box + 5);
        box = "http://localhost";
        n = strlen(box);
    } else if (strncmp(box, "http://", 7) != 0 && strncmp(box, "https://", 8) != 0) {
        ttf_err_set(err, -EINVAL, box, "is no box");
        ttf_err_hint(err, "write http://ADDRESS:PORT or unix:PATH");
        return -EINVAL;
    }
    while (n > 0 && box[n - 1] == '/')
        n--;
    if (set != CURLE_OK || n + 8 >= sizeof wire->base)
        return ttf_err_set(err, -EINVAL, box, "is too long");
    (void)snprintf(wire->base, sizeof wire->base, "%.*s/api/v1", (int)n, box);
    return 0;
}

int pull_wire_create(const struct ttf_pull_config *config, struct wire **ret, struct ttf_err *err)
{
    struct wire *wire = calloc(1, sizeof *wire);
    int r;

    if (!wire)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    wire->config = config;
    wire->bytes = &wire->own_bytes;
    r = init_curl(wire, config->token);
    if (r == 0)
        r = set_options(wire);
    if (r < 0)
        ttf_err_set(err, r, "libcurl", "cannot be set up");
    if (r == 0)
        r = set_box(wire, config->box, err);
    if (r < 0) {
        pull_wire_destroy(wire);
        return r;
    }
    *ret = wire;
    return 0;
}

int pull_wire_twin(const struct wire *of, struct wire **ret)
{
    int r = pull_wire_create(of->config, ret, NULL);

    if (r == 0)
        (*ret)->bytes = of->bytes;
    return r;
}

void pull_wire_destroy(struct wire *wire)
{
    if (!wire)
        return;
    curl_slist_free_all(wire->headers);
    curl_easy_cleanup(wire->curl);
    free(wire);
}

int64_t pull_wire_bytes(const struct wire *wire)
{
    return atomic_load(wire->bytes);
}

/* ---- a request under way ---- */

static int on_progress(void *ctx, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d)
{
    const struct wire *wire = ctx;

    (void)a;
    (void)b;
    (void)c;
    (void)d;
    return wire->config->stop && *wire->config->stop != 0;
}

static long status_of(struct wire *wire)
{
    long status = 0;

    (void)curl_easy_getinfo(wire->curl, CURLINFO_RESPONSE_CODE, &status);
    return status;
}

static bool starts(const char *line, size_t n, const char *with)
{
    return n >= strlen(with) && strncasecmp(line, with, strlen(with)) == 0;
}

/* libcurl calls an answer whole, and empty, whose connection ended within its head before a length was said. */
static size_t on_header(char *line, size_t size, size_t n, void *ctx)
{
    struct wire *wire = ctx;

    n *= size;
    if (starts(line, n, "HTTP/")) { /* of several answers the last counts */
        wire->headed = false;
        wire->measured = !starts(line, n, "HTTP/1"); /* later ones have frames */
    }
    wire->measured |= starts(line, n, "Content-Length:") || starts(line, n, "Transfer-Encoding:");
    wire->headed |= n > 0 && (line[0] == '\r' || line[0] == '\n');
    return n;
}

static int begin(struct wire *wire)
{
    int64_t first = status_of(wire) == 206 ? wire->asked_first : 0;

    if (wire->begun)
        return 0;
    wire->begun = true;
    return wire->sink->begin ? wire->sink->begin(wire->sink->ctx, first) : 0;
}

static size_t on_data(char *data, size_t size, size_t n, void *ctx)
{
    struct wire *wire = ctx;

    n *= size;
    if (status_of(wire) != 200 && status_of(wire) != 206) {
        size_t kept = n < SAID_MAX - 1 - wire->n_said ? n : SAID_MAX - 1 - wire->n_said;

        memcpy(wire->said + wire->n_said, data, kept);
        wire->n_said += kept;
        return n;
    }
    atomic_fetch_add(wire->bytes, (long long)n);
    wire->sink_error = begin(wire);
    if (wire->sink_error == 0)
        wire->sink_error = wire->sink->take(wire->sink->ctx, data, n);
    return wire->sink_error == 0 ? n : 0;
}

/* What libcurl says of the wire. */
static int wire_error(struct wire *wire, CURLcode code, const char *path, struct ttf_err *err)
{
    int r = -EPROTO; /* no HTTP, no such scheme, ... */

    if (wire->sink_error < 0)
        return wire->sink_error; /* whoever took the bytes has said why */
    if (code == CURLE_ABORTED_BY_CALLBACK)
        return ttf_err_set(err, -ECANCELED, NULL, "told to stop");
    if (code == CURLE_COULDNT_CONNECT)
        r = -ECONNREFUSED;
    else if (code == CURLE_OPERATION_TIMEDOUT)
        r = -ETIMEDOUT;
    else if (code == CURLE_COULDNT_RESOLVE_HOST)
        r = -EHOSTUNREACH;
    else if (code == CURLE_OUT_OF_MEMORY)
        r = -ENOMEM;
    else if (code == CURLE_RECV_ERROR || code == CURLE_SEND_ERROR || code == CURLE_GOT_NOTHING ||
             code == CURLE_PARTIAL_FILE)
        r = -ECONNRESET;
    if (pull_wire_may_pass(r) && wire->config->ended) {
        int ended = wire->config->ended(wire->config->ended_ctx, err);

        if (ended < 0)
            return ended;
    }
    /* Where nobody is, what was asked for says nothing; of a box at USB the address is ours. */
    if ((r == -ECONNREFUSED || r == -EHOSTUNREACH) && !wire->config->ended) {
        ttf_err_set(err, r, wire->config->box, "the box does not answer: %s",
                    curl_easy_strerror(code));
        ttf_err_hint(err, "is the address right, and does ttfboxd or ttfbox serve run there?");
        return r;
    }
    return ttf_err_set(err, r, path, "the box does not answer: %s", curl_easy_strerror(code));
}

/* 429 is of wrong tokens: more of them than it answers (openapi.yaml). The right one it takes always, so another try is no use. */
static bool is_wrong_token(const struct wire *wire, long status)
{
    return status == 401 || (status == 429 && strstr(wire->said, "wrong token"));
}

/* What the box says by a status and in words. */
static int box_error(struct wire *wire, long status, const char *path, struct ttf_err *err)
{
    const char *text = wire->said;
    int r = -EIO;

    wire->said[wire->n_said] = '\0';
    for (char *c = wire->said; *c; c++) /* it may be shown on a terminal */
        if ((unsigned char)*c < ' ' || *c == 127)
            *c = ' ';
    if (status == 416)
        return -ERANGE;
    if (is_wrong_token(wire, status))
        r = -EACCES;
    else if (status == 404)
        r = -ENOENT;
    else if (status == 403 || status == 409)
        r = status == 403 ? -EPERM : -EEXIST;
    else if (status == 503 || status == 429)
        r = -EAGAIN; /* it is short of something, and will have it again */
    ttf_err_set(err, r, path, "the box says %ld: %.200s", status, text);
    if (r == -EACCES)
        ttf_err_hint(err, wire->config->token
                              ? "the token that was given is not this box's: look at it again"
                              : "give the box's token by --token-file");
    return r;
}

/* What was set up, with these headers. */
static int perform(struct wire *wire, const char *path, struct curl_slist *headers,
                   const struct wire_sink *sink, struct ttf_err *err)
{
    char url[1024];
    CURLcode code;
    long status;

    if ((size_t)snprintf(url, sizeof url, "%s%s", wire->base, path) >= sizeof url)
        return ttf_err_set(err, -EINVAL, path, "is too long");
    wire->sink = sink;
    wire->begun = wire->headed = wire->measured = false;
    wire->sink_error = 0;
    wire->n_said = 0;
    (void)curl_easy_setopt(wire->curl, CURLOPT_URL, url);
    (void)curl_easy_setopt(wire->curl, CURLOPT_HTTPHEADER, headers);
    code = curl_easy_perform(wire->curl);
    status = status_of(wire);
    if (code != CURLE_OK || !wire->headed)
        return wire_error(wire, code != CURLE_OK ? code : CURLE_PARTIAL_FILE, path, err);
    if (status != 200 && status != 206)
        return box_error(wire, status, path, err);
    if (!wire->measured)
        return ttf_err_set(err, -EBADMSG, path,
                           "comes without a length, so that nobody can tell whether it is whole");
    return begin(wire); /* an empty answer has begun too */
}

int pull_wire_get(struct wire *wire, const char *path, int64_t first, int64_t last,
                  const char *if_tag, const struct wire_sink *sink, struct ttf_err *err)
{
    char range[64], tag[128];
    struct curl_slist *tags = NULL;
    bool part = first > 0 || last >= 0;
    int r;

    (void)snprintf(range, sizeof range, "%" PRId64 "-", first);
    if (last >= 0)
        (void)snprintf(range, sizeof range, "%" PRId64 "-%" PRId64, first, last);
    wire->asked_first = first;
    /* The token's header is the list's tail, which the request's own comes before. */
    if (part && if_tag) {
        (void)snprintf(tag, sizeof tag, "If-Range: \"%s\"", if_tag);
        tags = curl_slist_append(NULL, tag);
        if (!tags)
            return ttf_err_set(err, -ENOMEM, NULL, "no memory");
        tags->next = wire->headers;
    }
    (void)curl_easy_setopt(wire->curl, CURLOPT_RANGE, part ? range : NULL);
    r = perform(wire, path, tags ? tags : wire->headers, sink, err);
    if (tags) {
        tags->next = NULL;
        curl_slist_free_all(tags);
    }
    return r;
}

/* ---- texts ---- */

struct text {
    char *bytes;
    size_t n, room, max;
    int64_t first; /* asked for */
};

static int text_begin(void *ctx, int64_t first)
{
    struct text *text = ctx;

    text->n = 0;
    return first == text->first ? 0 : -EPROTO;
}

static int text_take(void *ctx, const void *data, size_t n)
{
    struct text *text = ctx;

    if (n > text->max - text->n)
        return -EFBIG;
    if (text->n + n + 1 > text->room) {
        size_t room = text->room ? 2 * text->room : 4096;
        char *more;

        while (room < text->n + n + 1)
            room *= 2;
        more = realloc(text->bytes, room);
        if (!more)
            return -ENOMEM;
        text->bytes = more;
        text->room = room;
    }
    memcpy(text->bytes + text->n, data, n);
    text->n += n;
    return 0;
}

static int text_give(struct text *text, int r, const char *path, char **ret_text, size_t *ret_bytes,
                     struct ttf_err *err)
{
    if (r == 0 && !text->bytes)
        text->bytes = malloc(1);
    if (r == 0 && !text->bytes)
        r = -ENOMEM;
    if (r < 0 || !text->bytes) {
        free(text->bytes);
        if (r == -EPROTO)
            ttf_err_set(err, r, path, "comes whole where a part was asked for: this is no ttfbox");
        if (r == -ENOMEM || r == -EFBIG)
            ttf_err_set(err, r, path, r == -ENOMEM ? "no memory" : "is longer than can be");
        return r;
    }
    text->bytes[text->n] = '\0';
    *ret_text = text->bytes;
    *ret_bytes = text->n;
    return 0;
}

int pull_wire_get_text(struct wire *wire, const char *path, int64_t first, int64_t last, size_t max,
                       char **ret_text, size_t *ret_bytes, struct ttf_err *err)
{
    struct text text = {.max = max, .first = first};
    const struct wire_sink sink = {text_begin, text_take, &text};
    int r = pull_wire_get(wire, path, first, last, NULL, &sink, err);

    return text_give(&text, r, path, ret_text, ret_bytes, err);
}

/* ---- asking ---- */

/* A request's own headers, before those of every one. NULL: no memory. */
static struct curl_slist *post_headers(const struct wire *wire, const char *json)
{
    struct curl_slist *marker = curl_slist_append(NULL, "X-Ttfbox: 1");
    /* Without a body none is announced, as libcurl would. */
    struct curl_slist *type =
        curl_slist_append(NULL, json ? "Content-Type: application/json" : "Content-Type:");

    if (!marker || !type) {
        curl_slist_free_all(marker);
        curl_slist_free_all(type);
        return NULL;
    }
    marker->next = type;
    type->next = wire->headers;
    return marker;
}

static int post(struct wire *wire, const char *path, const char *json, const struct wire_sink *sink,
                struct ttf_err *err)
{
    struct curl_slist *headers = post_headers(wire, json);
    int r;

    if (!headers)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    wire->asked_first = 0;
    (void)curl_easy_setopt(wire->curl, CURLOPT_RANGE, NULL);
    (void)curl_easy_setopt(wire->curl, CURLOPT_POSTFIELDS, json ? json : "");
    r = perform(wire, path, headers, sink, err);
    headers->next->next = NULL;
    curl_slist_free_all(headers);
    (void)curl_easy_setopt(wire->curl, CURLOPT_HTTPGET, 1L);
    return r;
}

int pull_wire_post_text(struct wire *wire, const char *path, const char *json, char **ret_text,
                        size_t *ret_bytes, struct ttf_err *err)
{
    struct text text = {.max = POST_MAX};
    const struct wire_sink sink = {text_begin, text_take, &text};
    int r = post(wire, path, json, &sink, err);

    return text_give(&text, r, path, ret_text, ret_bytes, err);
}
