/* SPDX-License-Identifier: Apache-2.0 */
/* test_server.c: a whole server on a socket: orders pass pictures, and what dribbles in or loses its end holds nobody. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "scratch.h"
#include "ttf/hal/clock_backend.h"
#include "ttf/http/listen.h"
#include "ttf/http/server.h"

#define TOKEN     "0123456789abcdef0123"
#define PATIENCE  10 /* seconds that a test waits for what must come; libmicrohttpd's own are 30 */
#define PICTURES  6
#define ORDERS    8
#define NOTES     ((size_t)16 << 20)
#define LEFT      ((off_t)1 << 20)
#define SMALL_BUF 65536

struct hand_clock {
    struct ttf_clock base; /* first */
    int64_t now_ns;        /* atomically */
};

static int64_t hand_now_ns(struct ttf_clock *clock)
{
    return __atomic_load_n(&((struct hand_clock *)clock)->now_ns, __ATOMIC_RELAXED);
}

static const struct ttf_clock_ops CLOCK_OPS = {.now_ns = hand_now_ns};

/* ---- a box whose camera gives no picture until it is let ---- */

struct box {
    struct ttf_http_box base; /* first */
    pthread_mutex_t lock;
    pthread_cond_t changed;
    bool open;
    int waiting;
};

static int wait_until_open(struct box *box, char **ret)
{
    (void)pthread_mutex_lock(&box->lock);
    box->waiting++;
    (void)pthread_cond_broadcast(&box->changed);
    while (!box->open)
        (void)pthread_cond_wait(&box->changed, &box->lock);
    (void)pthread_mutex_unlock(&box->lock);
    *ret = strdup("jpeg");
    return *ret ? 0 : -ENOMEM;
}

static int box_live(struct ttf_http_box *base, const struct ttf_http_view *view,
                    struct ttf_http_shown *ret, struct ttf_err *err)
{
    char *text = NULL;
    int r = wait_until_open((struct box *)base, &text);

    (void)view;
    (void)err;
    *ret = (struct ttf_http_shown){text, 4, 12345678, 1500};
    return r;
}

static int box_ask(struct ttf_http_box *base, const struct ttf_http_ask *ask, char **ret_json,
                   struct ttf_err *err)
{
    (void)base;
    (void)ask;
    (void)err;
    *ret_json = strdup("{\"number\":1}");
    return *ret_json ? 0 : -ENOMEM;
}

/* Checked against devices that do not answer yet. */
static int box_start(struct ttf_http_box *base, const char *plan, const char *dataset,
                     char **ret_json, struct ttf_err *err)
{
    (void)plan;
    (void)dataset;
    (void)err;
    return wait_until_open((struct box *)base, ret_json);
}

static int box_check(struct ttf_http_box *base, const char *yaml, size_t bytes, char **ret_json,
                     struct ttf_err *err)
{
    (void)base;
    (void)yaml;
    (void)bytes;
    (void)err;
    *ret_json = strdup("{\"ok\":true}");
    return *ret_json ? 0 : -ENOMEM;
}

static const struct ttf_http_box_ops BOX_OPS = {
    .name = "test", .live = box_live, .ask = box_ask, .start = box_start, .plan_check = box_check};

struct fixture {
    struct hand_clock clock;
    struct box box;
    struct ttf_http_events *events;
    struct ttf_http_server *server;
    unsigned short port;
    int listening; /* the server's socket */
};

static void begin(struct fixture *f)
{
    struct ttf_http_config config = {.folder = "data",
                                     .io = ttf_io_posix(),
                                     .token = TOKEN,
                                     .clock = &f->clock.base,
                                     .box = &f->box.base};
    struct ttf_http_socket socket = {0};
    struct sockaddr_in at = {0};
    socklen_t size = sizeof at;

    *f = (struct fixture){.clock = {.base.ops = &CLOCK_OPS, .now_ns = TTF_NS_PER_S},
                          .box = {.base.ops = &BOX_OPS}};
    (void)pthread_mutex_init(&f->box.lock, NULL);
    (void)pthread_cond_init(&f->box.changed, NULL);
    assert_int_equal(ttf_http_events_create(&f->events, NULL), 0);
    config.events = f->events;
    scratch_file("data/grass/dataset.json", "{}", 2);
    assert_int_equal(ttf_http_server_create(&config, &f->server, NULL), 0);
    assert_int_equal(ttf_http_listen("127.0.0.1:0", false, &socket, NULL), 0);
    assert_int_equal(getsockname(socket.fd, (struct sockaddr *)&at, &size), 0);
    f->port = ntohs(at.sin_port);
    f->listening = socket.fd;
    assert_int_equal(ttf_http_server_listen(f->server, socket.fd, true, NULL), 0);
}

static void let(struct fixture *f)
{
    (void)pthread_mutex_lock(&f->box.lock);
    f->box.open = true;
    (void)pthread_cond_broadcast(&f->box.changed);
    (void)pthread_mutex_unlock(&f->box.lock);
}

static void end(struct fixture *f)
{
    let(f);
    ttf_http_server_destroy(f->server);
    ttf_http_events_destroy(f->events);
    (void)pthread_cond_destroy(&f->box.changed);
    (void)pthread_mutex_destroy(&f->box.lock);
}

/* ---- a client ---- */

static int dial(const struct fixture *f)
{
    const struct timeval patience = {.tv_sec = PATIENCE};
    struct sockaddr_in at = {.sin_family = AF_INET,
                             .sin_port = htons(f->port),
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), small = SMALL_BUF;

    (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    assert_int_equal(connect(fd, (struct sockaddr *)&at, sizeof at), 0);
    return fd;
}

static void say(int fd, const char *text)
{
    assert_int_equal(send(fd, text, strlen(text), MSG_NOSIGNAL), (ssize_t)strlen(text));
}

static void ask(int fd, const char *line, const char *headers)
{
    char text[400];

    (void)snprintf(text, sizeof text,
                   "%s HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " TOKEN "\r\n%s\r\n",
                   line, headers);
    say(fd, text);
}

/* The status of what comes; 0: the connection ended, or nothing came. */
static int status_of(int fd)
{
    char text[4096] = "";
    ssize_t n = recv(fd, text, sizeof text - 1, 0);

    return n > 12 ? (int)strtol(text + 9, NULL, 10) : 0;
}

/* Bytes until the connection ends; -1: it does not. */
static int64_t drain(int fd)
{
    static char text[SMALL_BUF];
    int64_t bytes = 0;
    ssize_t n;

    while ((n = recv(fd, text, sizeof text, 0)) > 0)
        bytes += n;
    return n == 0 || errno == ECONNRESET ? bytes : -1;
}

/* ---- */

static void a_stop_passes_pictures_that_are_waited_for(void **state)
{
    struct fixture f;
    int pictures[PICTURES], fd;

    (void)state;
    begin(&f);
    for (int i = 0; i < PICTURES; i++) {
        pictures[i] = dial(&f);
        ask(pictures[i], "GET /api/v1/live", "");
    }
    (void)pthread_mutex_lock(&f.box.lock);
    while (f.box.waiting < 2) /* all that make pictures do so */
        (void)pthread_cond_wait(&f.box.changed, &f.box.lock);
    (void)pthread_mutex_unlock(&f.box.lock);
    fd = dial(&f);
    ask(fd, "POST /api/v1/run/stop", "Content-Length: 0\r\n");
    assert_int_equal(status_of(fd), 202);
    (void)close(fd);
    fd = dial(&f);
    ask(fd, "POST /api/v1/plans/check", "Content-Type: application/yaml\r\nContent-Length: 1\r\n");
    say(fd, "x");
    assert_int_equal(status_of(fd), 200);
    (void)close(fd);
    let(&f);
    for (int i = 0; i < PICTURES; i++) {
        assert_int_equal(status_of(pictures[i]), 200);
        (void)close(pictures[i]);
    }
    end(&f);
}

static void a_stop_passes_whatever_other_orders_wait(void **state)
{
    static const char BODY[] = "{\"plan\":\"week\"}";
    struct fixture f;
    char headers[100];
    int starts[ORDERS], fd;

    (void)state;
    begin(&f);
    (void)snprintf(headers, sizeof headers,
                   "Content-Type: application/json\r\nContent-Length: %zu\r\n", sizeof BODY - 1);
    for (int i = 0; i < ORDERS; i++) {
        starts[i] = dial(&f);
        ask(starts[i], "POST /api/v1/run", headers);
        say(starts[i], BODY);
    }
    (void)pthread_mutex_lock(&f.box.lock);
    while (f.box.waiting < 4) /* all that take orders do so, and others wait for them */
        (void)pthread_cond_wait(&f.box.changed, &f.box.lock);
    (void)pthread_mutex_unlock(&f.box.lock);
    fd = dial(&f);
    ask(fd, "POST /api/v1/run/stop", "Content-Length: 0\r\n");
    assert_int_equal(status_of(fd), 202);
    (void)close(fd);
    let(&f);
    for (int i = 0; i < ORDERS; i++) {
        assert_int_equal(status_of(starts[i]), 202);
        (void)close(starts[i]);
    }
    end(&f);
}

/* Until nobody listens at its port: connections are taken and dropped until the socket is closed. */
static bool is_closed(struct fixture *f)
{
    struct sockaddr_in at = {.sin_family = AF_INET,
                             .sin_port = htons(f->port),
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    bool refused = connect(fd, (struct sockaddr *)&at, sizeof at) < 0 && errno == ECONNREFUSED;

    (void)close(fd);
    return refused;
}

static void a_socket_that_is_left_answers_what_it_began_and_takes_nothing_new(void **state)
{
    struct fixture f;
    int picture, stream, late;

    (void)state;
    begin(&f);
    picture = dial(&f);
    ask(picture, "GET /api/v1/live", "");
    (void)pthread_mutex_lock(&f.box.lock);
    while (f.box.waiting < 1)
        (void)pthread_cond_wait(&f.box.changed, &f.box.lock);
    (void)pthread_mutex_unlock(&f.box.lock);
    stream = dial(&f);
    ask(stream, "GET /api/v1/events", "");
    assert_int_equal(status_of(stream), 200);
    ttf_http_server_leave(f.server, f.listening);
    late = dial(&f);
    assert_true(drain(late) >= 0); /* not one byte, and its end */
    ttf_http_server_tidy(f.server);
    assert_false(is_closed(&f)); /* a picture is still made */
    let(&f);
    assert_int_equal(status_of(picture), 200);
    while (!is_closed(&f))
        ttf_http_server_tidy(f.server);
    assert_true(drain(stream) >= 0);
    (void)close(picture);
    (void)close(stream);
    (void)close(late);
    end(&f);
}

static void a_body_that_dribbles_in_is_given_up(void **state)
{
    struct fixture f;
    int fd;

    (void)state;
    begin(&f);
    fd = dial(&f);
    ask(fd, "POST /api/v1/plans/check",
        "Content-Type: application/yaml\r\nContent-Length: 30\r\nExpect: 100-continue\r\n");
    assert_int_equal(status_of(fd), 100); /* from now on its time passes */
    __atomic_add_fetch(&f.clock.now_ns, 61 * TTF_NS_PER_S, __ATOMIC_RELAXED);
    say(fd, "0123456789");
    assert_int_equal(drain(fd), 0);
    (void)close(fd);
    end(&f);
}

static void headers_that_dribble_in_are_given_up(void **state)
{
    struct pollfd ended = {.events = POLLIN};
    struct fixture f;
    int fd;

    (void)state;
    begin(&f);
    fd = ended.fd = dial(&f);
    ask(fd, "GET /api/v1/health", ""); /* it is known to be there */
    assert_int_equal(status_of(fd), 200);
    say(fd, "GET /api/v1/health HTTP/1.1\r\nHost: ");
    ttf_http_server_tidy(f.server);
    say(fd, "local");
    /* More than once: that it waits again the server knows a moment after its answer is here. */
    for (unsigned i = 0; i < 10 * PATIENCE && poll(&ended, 1, 100) == 0; i++) {
        __atomic_add_fetch(&f.clock.now_ns, 41 * TTF_NS_PER_S, __ATOMIC_RELAXED);
        ttf_http_server_tidy(f.server);
    }
    assert_int_equal(drain(fd), 0);
    (void)close(fd);
    end(&f);
}

static void the_right_token_is_taken_however_many_were_wrong(void **state)
{
    static const char WRONG[] = "GET /api/v1/session HTTP/1.1\r\nHost: localhost\r\n"
                                "Authorization: Bearer no\r\n\r\n";
    static const char GUESS[] = "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\n"
                                "Content-Type: application/json\r\nContent-Length: 14\r\n\r\n"
                                "{\"token\":\"no\"}";
    static const char RIGHT[] = "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\n"
                                "Content-Type: application/json\r\nContent-Length: 32\r\n\r\n"
                                "{\"token\":\"" TOKEN "\"}";
    struct fixture f;
    int fd, status = 0;

    (void)state;
    begin(&f);
    fd = dial(&f);
    for (unsigned i = 0; i < 30; i++) {
        say(fd, i % 2 ? WRONG : GUESS);
        status = status_of(fd);
    }
    assert_int_equal(status, 429);
    ask(fd, "GET /api/v1/session", "");
    assert_int_equal(status_of(fd), 200);
    say(fd, RIGHT);
    assert_int_equal(status_of(fd), 200);
    say(fd, GUESS);
    assert_int_equal(status_of(fd), 429);
    (void)close(fd);
    end(&f);
}

static void a_token_that_nothing_depends_on_is_not_counted(void **state)
{
    static const char READ[] = "GET /api/v1/datasets HTTP/1.1\r\nHost: localhost\r\n"
                               "Authorization: Bearer no\r\n\r\n";
    static const char STOP[] = "POST /api/v1/run/stop HTTP/1.1\r\nHost: localhost\r\n"
                               "Authorization: Bearer no\r\nContent-Length: 0\r\n\r\n";
    struct fixture f;
    int fd, status = 0;

    (void)state;
    begin(&f);
    fd = dial(&f);
    for (unsigned i = 0; i < 30; i++) {
        say(fd, READ);
        assert_int_equal(status_of(fd), 200);
    }
    (void)close(fd);
    for (unsigned i = 0; i < 30; i++) {
        fd = dial(&f);
        say(fd, STOP);
        status = status_of(fd);
        assert_int_equal(status, i < 10 ? 401 : 429);
        (void)close(fd);
    }
    end(&f);
}

static void a_file_that_loses_its_end_while_it_is_sent_ends_the_connection(void **state)
{
    struct fixture f;
    char *notes = malloc(NOTES);
    int64_t bytes;
    int fd;

    (void)state;
    if (!notes)
        return;
    memset(notes, 'x', NOTES);
    for (size_t i = 99; i < NOTES; i += 100)
        notes[i] = '\n';
    notes[NOTES - 1] = '\n';
    begin(&f);
    scratch_file("data/grass/notes.jsonl", notes, NOTES);
    free(notes);
    fd = dial(&f);
    ask(fd, "GET /api/v1/datasets/grass/notes", "");
    assert_int_equal(status_of(fd), 200);
    assert_int_equal(truncate("data/grass/notes.jsonl", LEFT), 0);
    bytes = drain(fd);
    assert_true(bytes > 0 && bytes < (int64_t)NOTES);
    (void)close(fd);
    end(&f);
}

#define IN_SCRATCH(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

/* ---- the folder at the data folder's path is another one: its disk came late, or went and came back ---- */

static int status_of_dataset(const struct fixture *f, const char *name)
{
    char line[100];
    int fd = dial(f), status;

    (void)snprintf(line, sizeof line, "GET /api/v1/datasets/%s/files/dataset.json", name);
    ask(fd, line, "");
    status = status_of(fd);
    (void)close(fd);
    return status;
}

static void what_lies_at_the_path_now_is_served(void **state)
{
    struct fixture f;

    (void)state;
    begin(&f);
    assert_int_equal(status_of_dataset(&f, "grass"), 200);
    assert_int_equal(rename("data", "disk"), 0);
    assert_int_equal(status_of_dataset(&f, "grass"), 200); /* nothing else is there yet */
    scratch_file("data/moss/dataset.json", "{}", 2);
    assert_int_equal(status_of_dataset(&f, "grass"), 404);
    assert_int_equal(status_of_dataset(&f, "moss"), 200);
    assert_int_equal(rename("data", "other"), 0);
    assert_int_equal(rename("disk", "data"), 0);
    assert_int_equal(status_of_dataset(&f, "grass"), 200);
    assert_int_equal(status_of_dataset(&f, "moss"), 404);
    end(&f);
}

/* Answers of one folder alone: read anew where the path led elsewhere meanwhile. */
static void an_answer_is_of_one_folder(void **state)
{
    struct fixture f;
    int picture;

    (void)state;
    begin(&f);
    picture = dial(&f);
    ask(picture, "GET /api/v1/live", "");
    (void)pthread_mutex_lock(&f.box.lock);
    while (f.box.waiting < 1)
        (void)pthread_cond_wait(&f.box.changed, &f.box.lock);
    (void)pthread_mutex_unlock(&f.box.lock);
    assert_int_equal(rename("data", "disk"), 0);
    scratch_file("data/moss/dataset.json", "{}", 2);
    let(&f);
    assert_int_equal(status_of(picture), 200);
    assert_int_equal(f.box.waiting, 2);
    (void)close(picture);
    end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_SCRATCH(a_stop_passes_pictures_that_are_waited_for),
        IN_SCRATCH(a_stop_passes_whatever_other_orders_wait),
        IN_SCRATCH(a_socket_that_is_left_answers_what_it_began_and_takes_nothing_new),
        IN_SCRATCH(a_body_that_dribbles_in_is_given_up),
        IN_SCRATCH(headers_that_dribble_in_are_given_up),
        IN_SCRATCH(the_right_token_is_taken_however_many_were_wrong),
        IN_SCRATCH(a_token_that_nothing_depends_on_is_not_counted),
        IN_SCRATCH(a_file_that_loses_its_end_while_it_is_sent_ends_the_connection),
        IN_SCRATCH(what_lies_at_the_path_now_is_served),
        IN_SCRATCH(an_answer_is_of_one_folder),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
