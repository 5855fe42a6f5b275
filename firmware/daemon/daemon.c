/* SPDX-License-Identifier: Apache-2.0 */
#include "daemon.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "light.h"
#include "lock.h"
#include "log.h"
#include "manager.h"
#include "run.h"
#include "ttf/config/daemon_file.h"
#include "ttf/dataset/reader.h"

#define LOOK_NS     (250 * TTF_NS_PER_MS) /* how soon a stop is seen while nothing runs */
#define PROGRESS_NS TTF_NS_PER_MIN
#define RETRY_MOST  12 /* times the first wait */

struct daemon {
    const struct daemon_options *options;
    struct ttf_daemon_config config;
    struct ttf_board board;
    struct ttf_board_set sets[TTF_DAEMON_SETS_MAX];
    struct ttf_io *io;
    struct ttf_clock *clock;
    struct manager manager;
    struct box_host host;
    struct box_lock lock;
    struct run run;
    int64_t captured, told_ns; /* of this run */
    int64_t wait_ns;           /* before what failed is tried again */
};

static bool told_to_end(const struct daemon *d)
{
    return __atomic_load_n(d->options->stop, __ATOMIC_RELAXED) != 0;
}

/* ---- before ---- */

static int load(struct daemon *d, struct ttf_err *err)
{
    static const char *const FOLDERS[] = {"/etc/ttfbox/boards", "boards", TTFBOX_INSTALLED_BOARDS,
                                          NULL};
    char path[512];
    int r = ttf_daemon_file_load(d->options->config, &d->config, err);

    if (r < 0)
        return r;
    for (unsigned i = 0; i < d->config.n_sets; i++)
        d->sets[i] = (struct ttf_board_set){d->config.set[i].path, d->config.set[i].value};
    r = ttf_board_locate(d->config.board, FOLDERS, path, sizeof path, err);
    if (r == 0)
        r = ttf_board_load(path, d->sets, d->config.n_sets, &d->board, err);
    if (r == 0 && d->board.simulated && !d->board.sim.real_time) {
        ttf_err_set(err, -EINVAL, path, "a daemon lives in real time, and this clock is virtual");
        ttf_err_hint(err, "write set: {sim.clock: real} in %s", d->options->config);
        r = -EINVAL;
    }
    return r;
}

static int own_box(struct daemon *d, struct ttf_err *err)
{
    char who[256];

    (void)snprintf(who, sizeof who, "ttfboxd, process %d, into %.180s", (int)getpid(),
                   d->config.dataset);
    return box_lock_take(d->board.lock, who, true, &d->lock, err);
}

static int load_plan(struct daemon *d, struct ttf_err *err)
{
    int r;

    ttf_plan_file_free(d->run.file);
    d->run.file = NULL;
    r = ttf_plan_file_load(d->config.plan, &d->run.file, err);
    if (r < 0)
        d->run.file = NULL;
    else
        ttf_plan_file_default_zone(d->run.file, d->config.zone);
    return r;
}

/* ---- waiting ---- */

/* So long, or until it is told to end; the manager sees that it lives. */
static void idle(struct daemon *d, int64_t for_ns, enum ttf_led led)
{
    int64_t now_ns = ttf_clock_now_ns(d->clock);
    int64_t until_ns = for_ns == TTF_NS_NEVER ? TTF_NS_NEVER : now_ns + for_ns;
    struct ttf_watchdog *watchdog;
    struct ttf_panel *light;
    int fed = 0;

    if (told_to_end(d))
        return;
    watchdog = manager_watchdog(&d->manager);
    light = light_show(&d->board, d->clock, led);
    while (!told_to_end(d) && now_ns < until_ns) {
        (void)ttf_clock_wait_until(d->clock,
                                   until_ns - now_ns < LOOK_NS ? until_ns : now_ns + LOOK_NS);
        if (watchdog && fed == 0)
            fed = ttf_watchdog_feed(watchdog);
        now_ns = ttf_clock_now_ns(d->clock);
    }
    ttf_panel_destroy(light);
    ttf_watchdog_destroy(watchdog);
}

static int wait_for_plan(struct daemon *d, struct ttf_err *err)
{
    bool said = false;
    int r;

    while ((r = load_plan(d, err)) == -ENOENT && !told_to_end(d)) {
        manager_status(&d->manager, "waiting for a plan at %s", d->config.plan);
        if (!said)
            log_line(LOG_LEVEL_NOTICE, "waiting", "plan=\"%s\"", d->config.plan);
        said = true;
        idle(d, d->config.retry_ns, TTF_LED_IDLE);
    }
    return told_to_end(d) ? 0 : r;
}

/* ---- a run ---- */

static void on_slot(struct daemon *d, const struct ttf_progress *p)
{
    char text[400];

    d->captured += p->result == TTF_RESULT_CAPTURED;
    manager_status(&d->manager, "%scapturing: %" PRId64 " of %" PRId64 " slots",
                   d->board.simulated ? "SIMULATED, " : "", p->index + 1, p->total);
    if (p->result != TTF_RESULT_CAPTURED)
        log_line(LOG_LEVEL_WARNING, "slot", "index=%" PRId64 " result=%s why=%s", p->index,
                 ttf_result_name((enum ttf_result)p->result),
                 log_text(p->text ? p->text : "", text, sizeof text));
    if (p->now_ns - d->told_ns < PROGRESS_NS && p->index + 1 < p->total)
        return;
    d->told_ns = p->now_ns;
    log_line(LOG_LEVEL_INFO, "progress", "slots=%" PRId64 " of=%" PRId64 " captured=%" PRId64,
             p->index + 1, p->total, d->captured);
}

static void on_progress(void *ctx, const struct ttf_progress *p)
{
    struct daemon *d = ctx;
    char text[800];

    switch (p->kind) {
    case TTF_PROGRESS_ARMED:
        d->wait_ns = d->config.retry_ns; /* it works again */
        d->told_ns = p->now_ns;
        manager_status(&d->manager, "%sarmed: slot %" PRId64 " of %" PRId64 " is next",
                       d->board.simulated ? "SIMULATED, " : "", p->index, p->total);
        log_line(LOG_LEVEL_INFO, "armed", "next=%" PRId64 " slots=%" PRId64, p->index, p->total);
        break;
    case TTF_PROGRESS_SLOT:
        on_slot(d, p);
        break;
    case TTF_PROGRESS_EVENT:
        log_line(LOG_LEVEL_NOTICE, "event", "text=%s",
                 log_text(p->text ? p->text : "", text, sizeof text));
        break;
    case TTF_PROGRESS_ALARM:
        log_line(LOG_LEVEL_ALERT, "alarm", "text=%s",
                 log_text(p->text ? p->text : "", text, sizeof text));
        break;
    }
}

static void on_power_back(void *ctx, int64_t back_ns)
{
    (void)ctx;
    log_line(LOG_LEVEL_WARNING, "power", "simulated=lost back_h=%.2f",
             (double)back_ns / (double)TTF_NS_PER_H);
}

static void prepare(struct daemon *d)
{
    const struct run_choices choices = {.sets = d->sets, .n_sets = d->config.n_sets};
    struct run *run = &d->run;

    run->io = d->io;
    run->board = &d->board;
    run->host = &d->host;
    run->power_back = on_power_back;
    run_describe(d->io, &d->board, &choices, run->description);
    run->session = (struct ttf_session_config){
        .path = d->config.dataset,
        .calibration_folder = *d->config.calibration ? d->config.calibration : NULL,
        .threads = d->config.threads,
        .progress = on_progress,
        .progress_ctx = d,
        .stop = d->options->stop,
    };
}

static int one_run(struct daemon *d, struct ttf_err *err)
{
    const struct ttf_session_result *s = &d->run.result;
    int r = ttf_io_mkdirs(d->io, d->config.data, err);

    d->captured = 0;
    memset(&d->run.result, 0, sizeof d->run.result);
    if (r == 0)
        r = run_look(&d->run, err);
    if (r < 0)
        return r;
    manager_status(&d->manager, "%s %s", d->run.exists ? "going on with" : "beginning",
                   d->config.dataset);
    if (d->wait_ns == d->config.retry_ns) /* not each time that it is tried again */
        log_line(LOG_LEVEL_NOTICE, d->run.exists ? "resuming" : "beginning",
                 "dataset=\"%s\" next=%" PRId64, d->config.dataset, d->run.next_index);
    r = run_boots(&d->run, err);
    if (r < 0)
        return r;
    log_line(LOG_LEVEL_NOTICE, s->sealed ? "done" : "cut",
             "slots=%" PRId64 " captured=%" PRId64 " partial=%" PRId64 " missed=%" PRId64
             " failed=%" PRId64 " power=%" PRId64 " sealed=%s digest=%s",
             s->slots, s->captured, s->partial, s->missed, s->failed, s->power,
             s->sealed ? "yes" : "no", s->sealed ? s->digest : "none");
    if (s->sealed)
        manager_status(&d->manager, "done: %" PRId64 " of %" PRId64 " slots captured, sealed",
                       s->captured, s->slots);
    return 0;
}

/* What a person has to mend is no use to try again; whatever else may pass. */
static bool may_pass(int error)
{
    return run_exit_code(error) == 1 || error == -ENOENT;
}

static void wait_to_try_again(struct daemon *d, const struct ttf_err *err)
{
    char text[900], quoted[1000];

    ttf_err_text(err, text, sizeof text);
    manager_status(&d->manager, "trying again: %.200s", text);
    log_line(LOG_LEVEL_WARNING, "retry", "in_s=%.1f why=%s", (double)d->wait_ns / 1e9,
             log_text(text, quoted, sizeof quoted));
    idle(d, d->wait_ns, TTF_LED_STOPPED);
    d->wait_ns *= 2;
    if (d->wait_ns > RETRY_MOST * d->config.retry_ns)
        d->wait_ns = RETRY_MOST * d->config.retry_ns;
}

/* Until it is told to end. */
static int live(struct daemon *d, struct ttf_err *err)
{
    int r = wait_for_plan(d, err);

    d->wait_ns = d->config.retry_ns;
    while (r == 0 && !told_to_end(d)) {
        memset(err, 0, sizeof *err);
        r = one_run(d, err);
        if (r == 0)
            idle(d, TTF_NS_NEVER, TTF_LED_IDLE); /* done, or told to end */
        else if (may_pass(r))
            wait_to_try_again(d, err);
        if (r < 0 && may_pass(r))
            r = 0;
    }
    return r;
}

/* ---- whole ---- */

static int begin(struct daemon *d, struct ttf_err *err)
{
    int r = load(d, err);

    if (r < 0)
        return r;
    if (d->options->check)
        return load_plan(d, err);
    manager_find(&d->manager);
    d->host.notify = d->manager.socket;
    d->host.watchdog_ns = d->manager.watchdog_ns;
    d->io = ttf_io_posix();
    d->clock = ttf_clock_real_create();
    if (!d->clock)
        return ttf_err_set(err, -errno, "clock", "the machine's clock cannot be had");
    r = own_box(d, err);
    if (r < 0)
        return r;
    prepare(d);
    log_line(LOG_LEVEL_NOTICE, "started", "version=%s board=%s simulated=%s dataset=\"%s\"",
             TTFBOX_VERSION, d->board.name, d->board.simulated ? "yes" : "no", d->config.dataset);
    /* Looking at a long dataset comes before anything is armed, and takes as long as it takes. */
    manager_tell(&d->manager, d->manager.watchdog_ns > 0 ? "READY=1\nWATCHDOG_USEC=0" : "READY=1");
    r = live(d, err);
    manager_tell(&d->manager, "STOPPING=1");
    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "stopped", "%s", "");
    return r;
}

int daemon_run(const struct daemon_options *options, struct ttf_err *err)
{
    struct daemon *d = calloc(1, sizeof *d);
    int r;

    if (!d)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    d->options = options;
    d->lock.fd = -1;
    r = begin(d, err);
    ttf_plan_file_free(d->run.file);
    box_lock_drop(&d->lock);
    ttf_clock_destroy(d->clock);
    free(d);
    return r;
}
