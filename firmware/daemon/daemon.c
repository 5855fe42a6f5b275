/* SPDX-License-Identifier: Apache-2.0 */
#include "daemon.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "devices.h"
#include "door.h"
#include "keeper.h"
#include "log.h"
#include "parts.h"
#include "runs.h"
#include "ttf/http/listen.h"
#include "ttf/http/token.h"

bool daemon_told_to_end(const struct daemon *d)
{
    return __atomic_load_n(d->options->stop, __ATOMIC_RELAXED) == DAEMON_STOP;
}

/* ---- what is told ---- */

void daemon_publish(struct daemon *d, const char *kind, struct ttf_json *json)
{
    const char *text;
    size_t bytes;

    if (ttf_json_finish(json, &text, &bytes) == 0)
        ttf_http_events_publish(d->events, kind, text);
    ttf_json_free(json);
}

void daemon_tell_state(struct daemon *d)
{
    struct ttf_json json;

    ttf_json_init(&json, false);
    situation_state_event(d->situation, &json);
    daemon_publish(d, "state", &json);
}

int daemon_give(struct ttf_json *json, char **ret, struct ttf_err *err)
{
    int r = ttf_json_take(json, ret, NULL);

    return r < 0 ? ttf_err_set(err, r, NULL, "no memory") : 0;
}

void daemon_decided(int r, const struct ttf_err *err)
{
    char text[900], quoted[1000];

    if (r < 0)
        log_line(LOG_LEVEL_ERROR, "unsaved", "why=%s",
                 log_text(ttf_err_text(err, text, sizeof text), quoted, sizeof quoted));
}

void daemon_does(struct daemon *d, enum doing doing, const char *why, int64_t retry_ns)
{
    if (situation_set(d->situation, doing, why, retry_ns))
        daemon_tell_state(d);
}

/* ---- before ---- */

/* Whether each place to listen is one: whether it can be had is no matter yet. */
static int check_places(const struct daemon *d, struct ttf_err *err)
{
    const struct ttf_daemon_config *config = &d->config;
    char at[TTF_HTTP_WHERE_SIZE];

    for (unsigned i = 0; i < config->n_listen; i++) {
        const char *place = config->listen[i];
        struct ttf_err why = {0};

        if (ttf_http_listen_where(place, ttf_http_address_of, NULL, at, &why) == -EINVAL) {
            ttf_err_set(err, -EINVAL, d->options->config, "listen: '%s' %s", place, why.what);
            ttf_err_hint(err, "%s", why.hint);
            return -EINVAL;
        }
        for (unsigned j = 0; j < i; j++)
            if (strcmp(place, config->listen[j]) == 0)
                return ttf_err_set(err, -EINVAL, d->options->config, "listen: '%s' is there twice",
                                   place);
    }
    return 0;
}

static int load(struct daemon *d, struct ttf_err *err)
{
    char path[512];
    int r = ttf_daemon_file_load(d->options->config, &d->config, err);

    if (r == 0)
        r = check_places(d, err);
    if (r < 0)
        return r;
    for (unsigned i = 0; i < d->config.n_sets; i++)
        d->sets[i] = (struct ttf_board_set){d->config.set[i].path, d->config.set[i].value};
    r = ttf_board_locate(d->config.board, ttf_daemon_board_folders(), path, sizeof path, err);
    if (r == 0)
        r = ttf_board_load(path, d->sets, d->config.n_sets, &d->board, err);
    if (r == 0 && d->board.simulated && !d->board.sim.real_time) {
        ttf_err_set(err, -EINVAL, path, "a daemon lives in real time, and this clock is virtual");
        ttf_err_hint(err, "write set: {sim.clock: real} in %s", d->options->config);
        r = -EINVAL;
    }
    /* What is looked through between runs is not to be watched by it: the light and the watchdog are the daemon's. */
    d->view_board = d->board;
    d->view_board.device[TTF_DEVICE_PANEL] = NULL;
    d->view_board.device[TTF_DEVICE_WATCHDOG] = NULL;
    return r;
}

/* What is wrong with the configuration's plan is said at once; it need not be there. */
static int check_config_plan(struct daemon *d, struct ttf_err *err)
{
    struct ttf_plan_file *file = NULL;
    int r = *d->config.plan ? ttf_plan_file_load(d->config.plan, &file, err) : 0;

    ttf_plan_file_free(file);
    return r;
}

/* A token that somebody has written and that would not do. One that is not there is made, and so is an empty one where the
 * daemon makes it; one that is another user's is not ours to look at. */
static int check_token(struct daemon *d, struct ttf_err *err)
{
    struct ttf_err why = {0};
    size_t n = strlen(d->config.state);
    int r;

    if (strncmp(d->config.token_file, d->config.state, n) == 0 && d->config.token_file[n] == '/')
        return 0;
    r = ttf_http_token_read(d->config.token_file, d->token, &why);
    if (r == 0 || r == -ENOENT || r == -EACCES)
        return 0;
    *err = why;
    return r;
}

static int own_box(struct daemon *d, struct ttf_err *err)
{
    char who[256];

    (void)snprintf(who, sizeof who, "ttfboxd, process %d, into %.180s", (int)getpid(),
                   *d->config.dataset ? d->config.dataset : d->config.data);
    return box_lock_take(d->board.lock, who, true, &d->lock, err);
}

static void find_serial(struct daemon *d)
{
    (void)snprintf(d->serial, sizeof d->serial, "%s", d->board.serial);
    if (!*d->serial)
        box_host_serial(&d->host, d->serial);
}

/* ---- parts ---- */

static int make_parts(struct daemon *d, struct ttf_err *err)
{
    uint64_t random;
    int r;

    if (getrandom(&random, sizeof random, 0) != (ssize_t)sizeof random)
        return ttf_err_set(err, -EIO, NULL, "no random number");
    d->door.ops = &DOOR_OPS;
    d->wake = ttf_gate_create(d->clock);
    d->mailbox = calloc(1, sizeof *d->mailbox);
    d->situation = situation_create(d->clock);
    d->asks = asks_create(random);
    d->shadow = shadow_create();
    d->workshop = d->wake ? workshop_create(d->clock, d->wake) : NULL;
    d->calibrations = calibrations_create(d->io, d->clock, d->config.state, d->config.calibration);
    if (!d->mailbox || !d->situation || !d->asks || !d->shadow || !d->workshop || !d->calibrations)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = ttf_http_events_create(&d->events, err);
    if (r == 0)
        r = orders_create(d->io, d->config.state, d->config.plan, d->config.dataset, &d->orders,
                          err);
    if (r == 0)
        orders_flag(d->orders, d->options->stop, DAEMON_STOP_RUN);
    return r;
}

static void free_parts(struct daemon *d)
{
    keeper_stop(d->keeper);
    orders_destroy(d->orders);
    ttf_http_events_destroy(d->events);
    workshop_destroy(d->workshop);
    calibrations_destroy(d->calibrations);
    shadow_destroy(d->shadow);
    asks_destroy(d->asks);
    situation_destroy(d->situation);
    free(d->mailbox);
    ttf_gate_destroy(d->wake);
}

/* ---- whole ---- */

static int live(struct daemon *d, struct ttf_err *err)
{
    struct ttf_err unheard = {0};
    char text[900], quoted[1000];
    int r = make_parts(d, err);

    if (r < 0)
        return r;
    runs_prepare(d);
    log_line(LOG_LEVEL_NOTICE, "started", "version=%s board=%s simulated=%s dataset=\"%s\"",
             TTFBOX_VERSION, d->board.name, d->board.simulated ? "yes" : "no", d->config.dataset);
    /* A box that cannot be asked captures all the same. */
    if (keeper_start(d, &d->keeper, &unheard) < 0)
        log_line(LOG_LEVEL_ERROR, "unreachable", "why=%s",
                 log_text(ttf_err_text(&unheard, text, sizeof text), quoted, sizeof quoted));
    /* Looking at a long dataset comes before anything is armed, and takes as long as it takes. */
    manager_tell(&d->manager, d->manager.watchdog_ns > 0 ? "READY=1\nWATCHDOG_USEC=0" : "READY=1");
    runs_live(d);
    manager_tell(&d->manager, "STOPPING=1");
    log_line(LOG_LEVEL_NOTICE, "stopped", "%s", "");
    return 0;
}

static int begin(struct daemon *d, struct ttf_err *err)
{
    int r = load(d, err);

    if (r < 0)
        return r;
    if (d->options->check) {
        r = check_config_plan(d, err);
        return r < 0 ? r : check_token(d, err);
    }
    manager_find(&d->manager);
    d->host.notify = d->manager.socket;
    d->host.watchdog_ns = d->manager.watchdog_ns;
    d->io = ttf_io_posix();
    find_serial(d);
    d->clock = ttf_clock_real_create();
    if (!d->clock)
        return ttf_err_set(err, -errno, "clock", "the machine's clock cannot be had");
    d->host.host_time = d->host_time = ttf_host_time_create();
    if (!d->host_time)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    ttf_clock_trust_host(d->clock, d->host_time);
    r = own_box(d, err);
    return r < 0 ? r : live(d, err);
}

int daemon_run(const struct daemon_options *options, struct ttf_err *err)
{
    struct daemon *d = calloc(1, sizeof *d);
    int r;

    if (!d)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    d->options = options;
    d->lock.fd = -1;
    (void)pthread_mutex_init(&d->plans, NULL);
    (void)pthread_mutex_init(&d->starting, NULL);
    r = begin(d, err);
    free_parts(d);
    box_lock_drop(&d->lock);
    ttf_clock_destroy(d->clock);
    ttf_host_time_destroy(d->host_time);
    (void)pthread_mutex_destroy(&d->plans);
    (void)pthread_mutex_destroy(&d->starting);
    free(d);
    return r;
}
