/* SPDX-License-Identifier: Apache-2.0 */
#include "keeper.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "announce.h"
#include "devices.h"
#include "follow.h"
#include "log.h"
#include "preview_watch.h"
#include "sockets.h"
#include "ttf/http/server.h"
#include "ttf/http/token.h"

#define LOOK_NS (50 * TTF_NS_PER_MS)
#define AGAIN_NS \
    (5 * TTF_NS_PER_S)          /* until the disk is asked again for what it did not give or take */
#define LISTEN_NS  TTF_NS_PER_S /* until it is looked again what is to be listened on */
#define TICK_NS    (10 * TTF_NS_PER_S) /* that listeners hear something */
#define PREVIEW_NS (2 * TTF_NS_PER_S)  /* until the preview's state is looked at again */
#define NICE       5                   /* behind everything that a slot waits for */
#define LAST_CLASS ((2 << 13) | 7)     /* of those who share the disk fairly, the last */
#define BOX_NAMES  3                   /* that it has by itself */

struct keeper {
    struct daemon *d;
    pthread_t thread;
    int stop; /* atomically */
    struct follow follow;
    struct preview_watch preview;
    struct ttf_http_server *server;
    struct ttf_http_places sockets;
    struct announce announce;
    bool complained; /* that there is no server */
    int64_t again_ns, look_ns, save_ns, tick_ns, preview_ns, follow_ns;
};

/* ---- sockets ---- */

static int make_server(struct keeper *k, struct ttf_err *err)
{
    struct daemon *d = k->d;
    const char *names[TTF_DAEMON_NAMES_MAX + BOX_NAMES + 1] = {NULL};
    char host[200] = "", local[264], serial[96];
    struct ttf_http_config config = {.folder = d->config.data,
                                     .io = d->io,
                                     .token = d->token,
                                     .names = names,
                                     .clock = d->clock,
                                     .box = &d->door,
                                     .events = d->events};
    unsigned n = 0;
    int r = ttf_io_mkdirs(d->io, d->config.data, err);

    if (r == 0)
        r = ttf_io_mkdirs(d->io, d->config.state, err);
    if (r == 0)
        r = ttf_http_token_load_to_show(d->config.token_file, d->token, err);
    if (r < 0)
        return r;
    if (gethostname(host, sizeof host - 1) == 0 && *host) {
        (void)snprintf(local, sizeof local, "%s.local", host);
        names[n++] = host;
        names[n++] = local;
    }
    (void)snprintf(serial, sizeof serial, "ttfbox-%s.local", d->serial);
    names[n++] = serial;
    for (unsigned i = 0; i < d->config.n_names; i++)
        names[n++] = d->config.names[i];
    return ttf_http_server_create(&config, &k->server, err);
}

static void make_server_some_time(struct keeper *k, int64_t now_ns)
{
    char text[900], quoted[1000];
    struct ttf_err err = {0};

    if (now_ns < k->again_ns)
        return;
    k->again_ns = now_ns + AGAIN_NS;
    if (make_server(k, &err) == 0)
        return;
    if (!k->complained)
        log_line(LOG_LEVEL_WARNING, "unreachable", "at=\"%s\" why=%s", k->d->config.data,
                 log_text(ttf_err_text(&err, text, sizeof text), quoted, sizeof quoted));
    k->complained = true;
}

static void open_sockets(struct keeper *k, int64_t now_ns)
{
    if (k->d->config.n_listen == 0 || now_ns < k->look_ns)
        return;
    k->look_ns = now_ns + LISTEN_NS;
    if (!k->server)
        make_server_some_time(k, now_ns);
    if (k->server)
        (void)ttf_http_places_look(&k->sockets, k->server, NULL);
    announce_follow(&k->announce, &k->sockets, now_ns);
}

/* What was decided and the disk did not take, until it does; and what it did not give. */
static void keep_orders(struct keeper *k, int64_t now_ns)
{
    if (now_ns < k->save_ns)
        return;
    k->save_ns = now_ns + AGAIN_NS;
    (void)!orders_save(k->d->orders, NULL);
    if (orders_read_again(k->d->orders)) {
        log_line(LOG_LEVEL_NOTICE, "orders", "read=%s", "late");
        __atomic_store_n(&k->d->view_stop, 1, __ATOMIC_SEQ_CST);
        ttf_gate_open(k->d->wake);
    }
}

/* ---- what happens ---- */

static void tell_text(struct daemon *d, const char *kind, const char *text)
{
    char dataset[65];
    struct ttf_json json;

    situation_dataset(d->situation, dataset);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "dataset", dataset);
    ttf_json_kstring(&json, "text", text);
    ttf_json_object_end(&json);
    daemon_publish(d, kind, &json);
}

static void tell_slot(struct daemon *d, const struct letter *letter)
{
    struct ttf_json json;

    ttf_json_init(&json, false);
    situation_slot_event(d->situation, letter, &json);
    daemon_publish(d, "slot", &json);
}

static void tell_letter(struct keeper *k, const struct letter *letter)
{
    struct daemon *d = k->d;
    bool other = situation_letter(d->situation, letter);

    /* Of a run before: whoever wants to know reads its records, which lie under its name. */
    if (!situation_is_of(d->situation, letter) && letter->kind != TTF_PROGRESS_ALARM &&
        letter->kind != TTF_PROGRESS_ALARM_OVER)
        return;
    if (letter->kind == TTF_PROGRESS_SLOT)
        tell_slot(d, letter);
    else if (letter->kind == TTF_PROGRESS_EVENT)
        tell_text(d, "event", letter->text);
    else if (letter->kind == TTF_PROGRESS_ALARM)
        tell_text(d, "alarm", letter->text);
    if (other || letter->kind == TTF_PROGRESS_ARMED)
        daemon_tell_state(d);
}

static void empty_mailbox(struct keeper *k)
{
    struct daemon *d = k->d;
    struct letter letter;
    bool read = false;
    uint32_t dropped;

    while (mailbox_take(d->mailbox, &letter)) {
        /* Its record is read first, so that what is told of a slot, or another end, knows of it. */
        if (!read && (letter.kind == TTF_PROGRESS_SLOT || letter.kind == TTF_PROGRESS_ARMED ||
                      letter.kind == TTF_PROGRESS_EVENT)) {
            follow_read(&k->follow, d);
            read = true;
        }
        tell_letter(k, &letter);
        mailbox_tell(d->mailbox);
    }
    dropped = mailbox_dropped(d->mailbox);
    if (dropped > 0) {
        log_line(LOG_LEVEL_WARNING, "untold", "events=%u", dropped);
        ttf_http_events_publish(d->events, "missed", "{}");
    }
}

static void tell_answers(struct daemon *d)
{
    for (;;) {
        struct ttf_json json;

        ttf_json_init(&json, false);
        if (!asks_answered(d->asks, &json)) {
            ttf_json_free(&json);
            return;
        }
        daemon_publish(d, "asked", &json);
    }
}

/* Whatever becomes of it is told by a letter; but its disk may come late, and nobody says so. */
static void follow_records(struct keeper *k, int64_t now_ns)
{
    bool late = k->follow.missing && now_ns >= k->follow_ns;

    if (!late && !follow_elsewhere(&k->follow, k->d))
        return;
    k->follow_ns = now_ns + AGAIN_NS;
    follow_read(&k->follow, k->d);
}

static void *keep(void *ctx)
{
    struct keeper *k = ctx;
    struct ttf_clock *clock = k->d->clock;
    int tid = (int)syscall(SYS_gettid);

    /* Of this thread alone, and of those that it makes: of Linux they are a thread's. */
    (void)setpriority(PRIO_PROCESS, (id_t)tid, NICE);
    (void)syscall(SYS_ioprio_set, 1, tid, LAST_CLASS);
    while (!__atomic_load_n(&k->stop, __ATOMIC_RELAXED)) {
        int64_t now_ns = ttf_clock_now_ns(clock);

        if (daemon_told_to_end(k->d)) /* nor does a step of a calibration keep the end waiting */
            __atomic_store_n(&k->d->view_stop, 1, __ATOMIC_SEQ_CST);
        open_sockets(k, now_ns);
        announce_hear(&k->announce, now_ns);
        keep_orders(k, now_ns);
        follow_records(k, now_ns);
        empty_mailbox(k);
        tell_answers(k->d);
        if (now_ns >= k->preview_ns) {
            preview_watch_look(&k->preview, k->d);
            k->preview_ns = now_ns + PREVIEW_NS;
        }
        if (now_ns >= k->tick_ns) {
            ttf_http_events_tick(k->d->events);
            k->tick_ns = now_ns + TICK_NS;
        }
        (void)ttf_clock_wait_until(clock, now_ns + LOOK_NS);
    }
    return NULL;
}

int keeper_start(struct daemon *d, struct keeper **ret, struct ttf_err *err)
{
    struct keeper *k = calloc(1, sizeof *k);
    int r;

    if (!k)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    k->d = d;
    sockets_init(&k->sockets, &d->config);
    announce_init(&k->announce, d->serial);
    r = -pthread_create(&k->thread, NULL, keep, k);
    if (r < 0) {
        free(k);
        return ttf_err_set(err, r, NULL, "no thread for the interface");
    }
    *ret = k;
    return 0;
}

void keeper_stop(struct keeper *k)
{
    if (!k)
        return;
    __atomic_store_n(&k->stop, 1, __ATOMIC_RELAXED);
    (void)pthread_join(k->thread, NULL);
    empty_mailbox(k);
    announce_end(&k->announce);
    ttf_http_server_destroy(k->server);
    free(k);
}
