/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A request in libmicrohttpd's pieces: once when its headers are there, then its body as it comes, then once for an
 * answer, and again when a slow answer has been made. A request with a body is judged before any of it is taken in; the
 * connection ends then. One without is judged when it is whole, and the connection lives on.
 */
#include "call.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "access.h"
#include "answer.h"

struct call {
    struct call_socket *socket; /* that it came by; told when it has slept */
    struct ttf_http_match match;
    struct ttf_http_request request;
    struct ttf_http_answer answer;
    struct shelf *shelf; /* that the answer is made of, while it needs it; NULL: none */
    char *body;
    size_t expected, room; /* bytes of it; that fit, so far */
    int64_t until_ns;      /* by when all of it is to be there */
    bool judged, ran;
    int r; /* of the handler */
};

static const char *header(struct MHD_Connection *connection, const char *name)
{
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

const char *request_header(const struct ttf_http_request *request, const char *name)
{
    return header(request->connection, name);
}

const char *request_query(const struct ttf_http_request *request, const char *name)
{
    if (!ttf_http_asks(request->match->route->gives, name))
        return NULL;
    return MHD_lookup_connection_value(request->connection, MHD_GET_ARGUMENT_KIND, name);
}

/* ---- who ---- */

static const struct sockaddr *client_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);

    return info ? info->client_addr : NULL;
}

static struct guest *guest_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);

    return info ? info->socket_context : NULL;
}

/* A token was wrong. The right one is known before this is asked, and never suffers from it. */
static int count_wrong(const struct calls *calls, struct MHD_Connection *connection,
                       struct ttf_err *err)
{
    if (limits_wrong(calls->limits, client_of(connection)))
        return 0;
    ttf_err_set(err, -EUSERS, NULL, "too many wrong tokens came from this address");
    ttf_err_hint(err, "wait some seconds");
    return -EUSERS;
}

/* What a token that comes with it changes: where reading is free the answer to a reader is the same with any, and a guess learns nothing. */
static bool tells_of_token(enum ttf_http_access needs, bool free_to_read)
{
    return needs != TTF_HTTP_READ || !free_to_read;
}

/* May whoever asks do what this route does, and what else may they? */
static int judge_access(const struct call_socket *socket, struct call *call,
                        struct MHD_Connection *connection, struct ttf_err *err)
{
    const struct calls *calls = socket->calls;
    struct access_said said = {.host = header(connection, "Host"),
                               .authorization = header(connection, "Authorization"),
                               .cookie = header(connection, "Cookie"),
                               .origin = header(connection, "Origin"),
                               .site = header(connection, "Sec-Fetch-Site"),
                               .marker = header(connection, "X-Ttfbox")};
    enum ttf_http_access needs = call->match.route->access;
    enum access_verdict verdict;

    if (said.authorization && tells_of_token(needs, socket->free_to_read) &&
        !access_token(said.authorization, calls->token) && count_wrong(calls, connection, err) < 0)
        return err->code;
    call->request.may_read =
        access_decide(TTF_HTTP_READ, socket->free_to_read, &said, calls->token) == ACCESS_YES;
    call->request.may_change =
        access_decide(TTF_HTTP_TOKEN, false, &said, calls->token) == ACCESS_YES;
    call->request.at_cable = socket->free_to_read;
    verdict = access_decide(needs, socket->free_to_read, &said, calls->token);
    if (verdict == ACCESS_NEEDS_TOKEN) {
        ttf_err_set(err, -EACCES, NULL, "this needs the box's token");
        ttf_err_hint(err, "send it as Authorization: Bearer TOKEN");
    } else if (verdict == ACCESS_OTHER_PAGE) {
        ttf_err_set(err, -EPERM, NULL, "this may come from another page than the box's own");
        ttf_err_hint(err, "send X-Ttfbox: 1; with a cookie, from a page of this address");
    } else if (verdict == ACCESS_ELSEWHERE) {
        ttf_err_set(err, -EPERM, NULL, "this is had at the box's USB cable alone");
        ttf_err_hint(err, "ttfbox usb token");
    }
    return verdict == ACCESS_YES ? 0 : verdict == ACCESS_NEEDS_TOKEN ? -EACCES : -EPERM;
}

/* ---- what ---- */

static bool is_type(const char *said, const char *type)
{
    size_t n = strlen(type);

    return said && strncasecmp(said, type, n) == 0 &&
           (said[n] == '\0' || said[n] == ';' || said[n] == ' ');
}

/* How long the body will be, or what is wrong with it. */
static int64_t body_expected(struct MHD_Connection *connection, struct ttf_err *err)
{
    const char *length = header(connection, "Content-Length");
    unsigned long long bytes;
    char *end;

    if (header(connection, "Transfer-Encoding"))
        return ttf_err_set(err, -EFBIG, NULL, "a body has to say its length");
    if (!length)
        return 0;
    errno = 0;
    bytes = strtoull(length, &end, 10);
    if (*length < '0' || *length > '9' || *end || errno != 0 || bytes > TTF_HTTP_BODY_MAX)
        return ttf_err_set(err, -EFBIG, NULL, "a body has at most %zu bytes", TTF_HTTP_BODY_MAX);
    return (int64_t)bytes;
}

/* Bytes: what whoever has no token may send is kept small. */
static size_t body_max(const struct ttf_http_route *route)
{
    if (route->body == TTF_HTTP_YAML)
        return TTF_HTTP_BODY_MAX;
    return route->access == TTF_HTTP_OPEN ? TTF_HTTP_OPEN_BODY_MAX : TTF_HTTP_JSON_BODY_MAX;
}

static int judge_body(struct call *call, struct MHD_Connection *connection, struct ttf_err *err)
{
    const char *type = header(connection, "Content-Type");
    size_t most = body_max(call->match.route);

    if (call->expected > most)
        return ttf_err_set(err, -EFBIG, NULL, "a body has at most %zu bytes here", most);
    switch (call->match.route->body) {
    case TTF_HTTP_NO_BODY:
        break;
    case TTF_HTTP_JSON_MAYBE:
        if (call->expected == 0)
            return 0;
        /* fall through */
    case TTF_HTTP_JSON:
        return is_type(type, "application/json")
                   ? 0
                   : ttf_err_set(err, -EPROTOTYPE, "Content-Type", "application/json is meant");
    case TTF_HTTP_YAML:
        return is_type(type, "application/yaml")
                   ? 0
                   : ttf_err_set(err, -EPROTOTYPE, "Content-Type", "application/yaml is meant");
    }
    return call->expected == 0 ? 0 : ttf_err_set(err, -EFBIG, NULL, "no body is expected here");
}

static int judge_place(const struct calls *calls, struct call *call, const char *host,
                       const char *method, const char *url, struct ttf_err *err)
{
    int r;

    if (!access_host(host, calls->names)) {
        r = ttf_err_set(err, -EXDEV, "Host", "this is not a name of this box");
        ttf_err_hint(err, "ask by its address or by its own name");
        return r;
    }
    r = ttf_http_route_find(method, url, &call->match);
    if (r == -ENOENT)
        ttf_err_set(err, r, NULL, "there is nothing of this name here");
    else if (r < 0)
        ttf_err_set(err, r, NULL, "this cannot be done with it");
    return r;
}

/* 0, or an error that is answered. */
static int judge(const struct call_socket *socket, struct call *call,
                 struct MHD_Connection *connection, const char *method, const char *url,
                 struct ttf_err *err)
{
    int r = judge_place(socket->calls, call, header(connection, "Host"), method, url, err);

    if (r == 0)
        r = judge_access(socket, call, connection, err);
    if (r == 0)
        r = judge_body(call, connection, err);
    call->judged = r == 0;
    return r;
}

/* ---- from the headers to an answer ---- */

static enum MHD_Result refuse(struct MHD_Connection *connection, const char *url,
                              const struct ttf_err *err)
{
    char methods[64] = "";

    if (err->code == -ENOTSUP)
        (void)ttf_http_route_methods(url, methods);
    return answer_error(connection, methods, err);
}

static struct call *begin(struct call_socket *socket, struct MHD_Connection *connection)
{
    const struct calls *calls = socket->calls;
    struct call *call = calloc(1, sizeof *call);

    if (!call)
        return NULL;
    call->socket = socket;
    answer_init(&call->answer);
    call->request = (struct ttf_http_request){.io = calls->io,
                                              .box = calls->box,
                                              .events = calls->events,
                                              .leaving = &socket->leaving,
                                              .match = &call->match,
                                              .connection = connection,
                                              .token = calls->token,
                                              .body = ""};
    return call;
}

/* The headers are there. */
static enum MHD_Result on_headers(struct call_socket *socket, struct MHD_Connection *connection,
                                  const char *url, const char *method, void **of_request)
{
    struct call *call = begin(socket, connection);
    struct ttf_err err = {0};
    int64_t expected = body_expected(connection, &err);

    if (!call)
        return MHD_NO;
    *of_request = call;
    guest_is_answered(guest_of(connection));
    if (expected < 0)
        return answer_error(connection, "", &err);
    if (expected == 0)
        return MHD_YES;
    guest_reads_body(guest_of(connection));
    call->expected = (size_t)expected;
    call->until_ns = ttf_clock_now_ns(socket->calls->clock) + GUEST_BODY_NS;
    if (judge(socket, call, connection, method, url, &err) == 0)
        return MHD_YES;
    guest_is_answered(guest_of(connection));
    return refuse(connection, url, &err);
}

/* Memory for what has come, not for what was announced. */
static bool make_room(struct call *call, size_t bytes)
{
    size_t room = 2 * bytes < call->expected ? 2 * bytes : call->expected;
    char *more;

    if (call->body && bytes <= call->room)
        return true;
    more = realloc(call->body, room + 1);
    if (!more)
        return false;
    call->body = more;
    call->room = room;
    return true;
}

static enum MHD_Result on_body(const struct calls *calls, struct call *call, const char *data,
                               size_t *bytes)
{
    size_t room = call->expected - call->request.body_bytes;

    if (!call->judged || *bytes > room || ttf_clock_now_ns(calls->clock) > call->until_ns ||
        !make_room(call, call->request.body_bytes + *bytes))
        return MHD_NO;
    memcpy(call->body + call->request.body_bytes, data, *bytes);
    call->request.body_bytes += *bytes;
    call->body[call->request.body_bytes] = '\0';
    call->request.body = call->body;
    *bytes = 0;
    return MHD_YES;
}

static bool brings_token(const struct call *call)
{
    return call->match.route->access == TTF_HTTP_OPEN && call->match.route->body == TTF_HTTP_JSON;
}

static void give_shelf(struct call *call)
{
    if (call->shelf)
        shelves_give(call->socket->calls->shelves, call->shelf);
    call->shelf = NULL;
}

static void answer_by_shelf(struct call *call)
{
    const struct ttf_http_gives *gives = call->match.route->gives;

    call->shelf = shelves_take(call->socket->calls->shelves);
    call->request.folder = &call->shelf->folder;
    call->request.summaries = call->shelf->summaries;
    call->request.derived = call->shelf->derived;
    call->answer.status = gives->status;
    call->answer.type = ttf_http_type_of(gives, call->match.path);
    call->r = call->match.route->answer(&call->request, &call->answer);
}

/*
 * Libraries find files by the folder's path: where that led elsewhere by the end, what they read may be of another disk than the
 * rest, and it is read anew. Only where asking twice changes nothing.
 */
static bool is_of_two_folders(const struct call *call)
{
    return strcmp(call->match.route->method, "GET") == 0 && !call->answer.listener &&
           shelves_other(call->socket->calls->shelves, call->shelf);
}

static void handle(struct call *call)
{
    const struct ttf_http_gives *gives = call->match.route->gives;

    answer_by_shelf(call);
    if (is_of_two_folders(call)) {
        answer_free(&call->answer);
        call->request.err = (struct ttf_err){0};
        give_shelf(call);
        answer_by_shelf(call);
    }
    if (!call->answer.source.read)
        give_shelf(call);
    if (!gives->tagged)
        call->answer.etag[0] = '\0';
    call->answer.ranges = call->answer.ranges && gives->ranges;
    if (call->answer.none && gives->none) {
        call->answer.status = MHD_HTTP_NO_CONTENT;
        call->answer.type = NULL;
    }
    /* What the disk refuses is no wrong token: that is told of the session's body alone. */
    if (call->r == -EACCES && !brings_token(call)) {
        call->r = -EIO;
        if (call->request.err.code == -EACCES)
            call->request.err.code = -EIO;
    }
    if (call->r < 0 && call->request.err.code == 0)
        ttf_err_set(&call->request.err, call->r, NULL, "%s", strerrordesc_np(-call->r));
    call->ran = true;
}

/* ---- what takes more than a moment ---- */

/* Where a socket is being left none may: said before it is asked, so that one of the two sees the other. */
static bool fall_asleep(struct call *call)
{
    struct call_socket *socket = call->socket;

    (void)__atomic_add_fetch(&socket->asleep, 1, __ATOMIC_SEQ_CST);
    if (!__atomic_load_n(&socket->leaving, __ATOMIC_SEQ_CST)) {
        guest_sleeps(guest_of(call->request.connection));
        MHD_suspend_connection(call->request.connection);
        return true;
    }
    (void)__atomic_sub_fetch(&socket->asleep, 1, __ATOMIC_SEQ_CST);
    return false;
}

static void wake(struct call *call)
{
    struct call_socket *socket = call->socket;

    guest_is_answered(guest_of(call->request.connection));
    MHD_resume_connection(
        call->request.connection); /* from here on the call is the connection's again */
    (void)__atomic_sub_fetch(&socket->asleep, 1, __ATOMIC_SEQ_CST);
}

void call_run(struct call *call)
{
    handle(call);
    wake(call);
}

void call_cancel(struct call *call, const char *why)
{
    call->r = ttf_err_set(&call->request.err, -EAGAIN, NULL, "%s", why);
    call->ran = true;
    wake(call);
}

static enum MHD_Result send_it(struct call *call, struct MHD_Connection *connection,
                               const struct calls *calls, const char *method)
{
    if (call->answer.listener)
        guest_sleeps(guest_of(connection));
    if (call->r == 0)
        return answer_send(connection, strcmp(method, "GET") == 0, &call->answer);
    /* A token in a body is a token too. */
    if (call->r == -EACCES)
        (void)count_wrong(calls, connection, &call->request.err);
    return answer_error(connection, "", &call->request.err);
}

/* The whole request is there. */
static enum MHD_Result on_whole(struct call_socket *socket, struct call *call,
                                struct MHD_Connection *connection, const char *url,
                                const char *method)
{
    struct ttf_err err = {0};

    guest_is_answered(guest_of(connection));
    if (call->ran)
        return send_it(call, connection, socket->calls, method);
    if (!call->judged && judge(socket, call, connection, method, url, &err) < 0)
        return refuse(connection, url, &err);
    if (call->match.route->lane == TTF_HTTP_AT_ONCE) {
        handle(call);
        return send_it(call, connection, socket->calls, method);
    }
    if (!fall_asleep(call)) {
        ttf_err_set(&err, -EAGAIN, NULL, "this address is about to be left");
        return refuse(connection, url, &err);
    }
    if (slow_put(socket->calls->lanes[call->match.route->lane], call) < 0)
        call_cancel(call, "too much is asked at once, or this server is about to end");
    return MHD_YES;
}

enum MHD_Result call_admit(void *ctx, const struct sockaddr *address, socklen_t size)
{
    struct call_socket *socket = ctx;

    (void)address;
    (void)size;
    return __atomic_load_n(&socket->leaving, __ATOMIC_SEQ_CST) ? MHD_NO : MHD_YES;
}

void call_comes_and_goes(void *ctx, struct MHD_Connection *connection, void **of_connection,
                         enum MHD_ConnectionNotificationCode what)
{
    const struct call_socket *socket = ctx;
    const union MHD_ConnectionInfo *fd;

    if (what == MHD_CONNECTION_NOTIFY_STARTED) {
        fd = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
        if (fd)
            *of_connection = guests_enter(socket->guests, client_of(connection), fd->connect_fd);
    } else { /* its descriptor is open still */
        guest_leaves(*of_connection);
        *of_connection = NULL;
    }
}

enum MHD_Result call_on(void *ctx, struct MHD_Connection *connection, const char *url,
                        const char *method, const char *version, const char *data,
                        /* NOLINTNEXTLINE(readability-non-const-parameter): libmicrohttpd's */
                        size_t *data_bytes, void **of_request)
{
    struct call_socket *socket = ctx;

    (void)version;
    if (!*of_request)
        return on_headers(socket, connection, url, method, of_request);
    if (*data_bytes > 0)
        return on_body(socket->calls, *of_request, data, data_bytes);
    return on_whole(socket, *of_request, connection, url, method);
}

void call_done(void *ctx, struct MHD_Connection *connection, void **of_request,
               enum MHD_RequestTerminationCode how)
{
    struct call *call = *of_request;

    (void)ctx;
    (void)how;
    guest_waits(guest_of(connection));
    if (!call)
        return;
    answer_free(&call->answer);
    give_shelf(call);
    free(call->body);
    free(call);
    *of_request = NULL;
}
