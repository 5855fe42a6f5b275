/* SPDX-License-Identifier: Apache-2.0 */
#include "answer.h"

#include <errno.h>
#include <inttypes.h>
#include <nettle/base64.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "listeners.h"
#include "range.h"
#include "ttf/dataset/json_writer.h"

#define PIECE        65536
#define EVENTS_PIECE 8192

void answer_init(struct ttf_http_answer *answer)
{
    *answer = (struct ttf_http_answer){.fd = -1};
}

void answer_free(struct ttf_http_answer *answer)
{
    free(answer->text);
    if (answer->fd >= 0)
        (void)close(answer->fd);
    if (answer->source.done)
        answer->source.done(answer->source.ctx);
    listener_free(answer->listener);
    answer_init(answer);
}

void answer_file(struct ttf_http_answer *answer, int fd, int64_t bytes, const struct stat *st)
{
    answer->fd = fd;
    answer->bytes = bytes;
    (void)snprintf(answer->etag, sizeof answer->etag, "%" PRIx64 "-%" PRIx64 "-%" PRIx64 ".%lx",
                   (uint64_t)st->st_ino, (uint64_t)bytes, (uint64_t)st->st_mtim.tv_sec,
                   (unsigned long)st->st_mtim.tv_nsec);
}

void answer_json(struct ttf_http_answer *answer, char *text, size_t bytes)
{
    answer->text = text;
    answer->bytes = (int64_t)bytes;
}

int answer_done(struct ttf_http_request *request, struct ttf_http_answer *answer)
{
    char *text = strdup("{\"ok\":true}");

    if (!text)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    answer_json(answer, text, strlen(text));
    return 0;
}

/* ---- headers ---- */

void answer_header(struct ttf_http_answer *answer, const char *name, const char *fmt, ...)
{
    va_list args;

    if (answer->n_headers == ANSWER_HEADERS_MAX)
        return;
    answer->headers[answer->n_headers].name = name;
    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vsnprintf(answer->headers[answer->n_headers].value, sizeof answer->headers[0].value, fmt,
                    args);
    va_end(args);
    answer->n_headers++;
}

static void put(struct MHD_Response *response, const char *name, const char *value)
{
    (void)MHD_add_response_header(response, name, value);
}

/* What every answer has. type: NULL of one without a body. */
static void put_common(struct MHD_Response *response, const char *type, bool page)
{
    if (type)
        put(response, "Content-Type", type);
    put(response, "Cache-Control", "private, no-cache");
    put(response, "X-Content-Type-Options", "nosniff");
    put(response, "Cross-Origin-Resource-Policy", "same-origin");
    put(response, "Referrer-Policy", "no-referrer");
    put(response, "Content-Security-Policy",
        page ? "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: "
               "data:; "
               "media-src 'self' blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
               "frame-ancestors 'none'"
             : "default-src 'none'; frame-ancestors 'none'");
}

static unsigned nibble(char c)
{
    return (unsigned)(c <= '9' ? c - '0' : c - 'a' + 10);
}

/* RFC 9530, 3: the digest of the representation, whatever part of it is sent. */
static void put_digest(struct MHD_Response *response, const char *hex)
{
    char text[9 + BASE64_ENCODE_RAW_LENGTH(32) + 2] = "sha-256=:";
    uint8_t raw[32];

    for (size_t i = 0; i < sizeof raw; i++)
        raw[i] = (uint8_t)(nibble(hex[2 * i]) << 4 | nibble(hex[2 * i + 1]));
    base64_encode_raw(text + 9, sizeof raw, raw);
    text[9 + BASE64_ENCODE_RAW_LENGTH(32)] = ':';
    text[9 + BASE64_ENCODE_RAW_LENGTH(32) + 1] = '\0';
    put(response, "Repr-Digest", text);
}

static void put_entity(struct MHD_Response *response, const struct ttf_http_answer *answer)
{
    char text[128];

    if (answer->ranges)
        put(response, "Accept-Ranges", "bytes");
    if (*answer->etag) {
        (void)snprintf(text, sizeof text, "\"%s\"", answer->etag);
        put(response, "ETag", text);
    }
    if (*answer->sha256)
        put_digest(response, answer->sha256);
    if (*answer->file_name) {
        (void)snprintf(text, sizeof text, "attachment; filename=\"%s\"", answer->file_name);
        put(response, "Content-Disposition", text);
    }
    for (unsigned i = 0; i < answer->n_headers; i++)
        put(response, answer->headers[i].name, answer->headers[i].value);
}

/* ---- conditions ---- */

bool answer_lists_tag(const char *header, const char *etag)
{
    char quoted[96];

    if (!header || !*etag)
        return false;
    (void)snprintf(quoted, sizeof quoted, "\"%s\"", etag);
    return strcmp(header, "*") == 0 || strstr(header, quoted) != NULL;
}

static struct range wanted(struct MHD_Connection *connection, bool parts,
                           const struct ttf_http_answer *answer)
{
    const char *range = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Range");
    const char *only = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "If-Range");

    if (!parts || !answer->ranges ||
        (only && (*only != '"' || !answer_lists_tag(only, answer->etag))))
        range = NULL; /* it is another entity by now: all of it */
    return range_read(range, answer->bytes);
}

/* ---- bodies ---- */

struct stream {
    struct answer_source source;
    int64_t first;
};

static ssize_t stream_read(void *ctx, uint64_t at, char *buf, size_t n)
{
    struct stream *stream = ctx;
    ssize_t got = stream->source.read(stream->source.ctx, stream->first + (int64_t)at, buf, n);

    /* The length was said before: cutting the connection off is the one way left to say that this failed. */
    return got > 0 ? got : MHD_CONTENT_READER_END_WITH_ERROR;
}

static void stream_done(void *ctx)
{
    struct stream *stream = ctx;

    stream->source.done(stream->source.ctx);
    free(stream);
}

static struct MHD_Response *stream_response(struct ttf_http_answer *answer,
                                            const struct range *part)
{
    struct stream *stream = malloc(sizeof *stream);
    struct MHD_Response *response;

    if (!stream)
        return NULL;
    *stream = (struct stream){answer->source, part->first};
    response = MHD_create_response_from_callback((uint64_t)part->bytes, PIECE, stream_read, stream,
                                                 stream_done);
    if (response)
        answer->source = (struct answer_source){0};
    else
        free(stream);
    return response;
}

static struct MHD_Response *body(struct ttf_http_answer *answer, const struct range *part)
{
    struct MHD_Response *response;

    if (answer->source.read)
        return stream_response(answer, part);
    if (answer->fixed)
        return MHD_create_response_from_buffer((size_t)answer->bytes, (void *)answer->fixed,
                                               MHD_RESPMEM_PERSISTENT);
    if (answer->fd >= 0) {
        response = MHD_create_response_from_fd_at_offset64((uint64_t)part->bytes, answer->fd,
                                                           (uint64_t)part->first);
        if (response)
            answer->fd = -1;
        return response;
    }
    response =
        MHD_create_response_from_buffer((size_t)answer->bytes, answer->text, MHD_RESPMEM_MUST_FREE);
    if (response)
        answer->text = NULL;
    return response;
}

/* ---- answers ---- */

static struct MHD_Response *empty(void)
{
    return MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT);
}

static enum MHD_Result queue(struct MHD_Connection *connection, unsigned status,
                             struct MHD_Response *response)
{
    enum MHD_Result r;

    if (!response)
        return MHD_NO; /* no memory: the connection ends */
    r = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return r;
}

/* An answer that goes on as long as somebody listens. */
static enum MHD_Result send_events(struct MHD_Connection *connection,
                                   struct ttf_http_answer *answer)
{
    struct MHD_Response *response;

    listener_connect(answer->listener, connection);
    response = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, EVENTS_PIECE, listener_read,
                                                 answer->listener, listener_free);
    if (response) {
        answer->listener = NULL;
        put_common(response, answer->type, false);
    }
    return queue(connection, MHD_HTTP_OK, response);
}

enum MHD_Result answer_send(struct MHD_Connection *connection, bool parts,
                            struct ttf_http_answer *answer)
{
    const char *none = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "If-None-Match");
    struct range part = wanted(connection, parts, answer);
    struct MHD_Response *response;
    unsigned status = answer->status;
    char text[80];

    if (answer->listener)
        return send_events(connection, answer);
    if (answer_lists_tag(none, answer->etag)) {
        response = empty();
        status = MHD_HTTP_NOT_MODIFIED;
    } else if (part.kind == RANGE_OUTSIDE) {
        response = empty();
        status = MHD_HTTP_RANGE_NOT_SATISFIABLE;
        (void)snprintf(text, sizeof text, "bytes */%" PRId64, answer->bytes);
    } else {
        response = body(answer, &part);
        (void)snprintf(text, sizeof text, "bytes %" PRId64 "-%" PRId64 "/%" PRId64, part.first,
                       part.first + part.bytes - 1, answer->bytes);
    }
    if (response) {
        put_common(response, answer->type, answer->page);
        put_entity(response, answer);
        if (part.kind == RANGE_PART && status == answer->status)
            status = MHD_HTTP_PARTIAL_CONTENT;
        if (status == MHD_HTTP_PARTIAL_CONTENT || status == MHD_HTTP_RANGE_NOT_SATISFIABLE)
            put(response, "Content-Range", text);
    }
    return queue(connection, status, response);
}

static unsigned status_of(int code)
{
    switch (-code) {
    case EINVAL:
        return MHD_HTTP_BAD_REQUEST;
    case EACCES:
        return MHD_HTTP_UNAUTHORIZED;
    case EPERM:
        return MHD_HTTP_FORBIDDEN;
    case ENOENT:
        return MHD_HTTP_NOT_FOUND;
    case ENOTSUP:
        return MHD_HTTP_METHOD_NOT_ALLOWED;
    case EFBIG:
        return MHD_HTTP_CONTENT_TOO_LARGE;
    case EPROTOTYPE:
        return MHD_HTTP_UNSUPPORTED_MEDIA_TYPE;
    case EUSERS:
        return MHD_HTTP_TOO_MANY_REQUESTS;
    case EXDEV:
        return MHD_HTTP_MISDIRECTED_REQUEST;
    case EBUSY:
    case EEXIST:
        return MHD_HTTP_CONFLICT;
    case EAGAIN:
    case ENODEV:
    case ENOMEM:
    case EMFILE:
    case ENFILE:
        return MHD_HTTP_SERVICE_UNAVAILABLE;
    default:
        return MHD_HTTP_INTERNAL_SERVER_ERROR;
    }
}

enum MHD_Result answer_error(struct MHD_Connection *connection, const char *methods,
                             const struct ttf_err *err)
{
    unsigned status = status_of(err->code);
    struct MHD_Response *response = NULL;
    struct ttf_json json;
    char *text;
    size_t bytes;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "error", *err->what ? err->what : strerrordesc_np(-err->code));
    if (*err->where)
        ttf_json_kstring(&json, "where", err->where);
    if (*err->hint)
        ttf_json_kstring(&json, "hint", err->hint);
    ttf_json_object_end(&json);
    if (ttf_json_take(&json, &text, &bytes) == 0) {
        response = MHD_create_response_from_buffer(bytes, text, MHD_RESPMEM_MUST_FREE);
        if (!response)
            free(text);
    }
    if (response) {
        put_common(response, "application/json", false);
        if (status == MHD_HTTP_UNAUTHORIZED)
            put(response, "WWW-Authenticate", "Bearer realm=\"ttfbox\"");
        if (status == MHD_HTTP_TOO_MANY_REQUESTS)
            put(response, "Retry-After", "5");
        if (*methods)
            put(response, "Allow", methods);
    }
    return queue(connection, status, response);
}
