/* SPDX-License-Identifier: Apache-2.0 */
#include "runs.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_of_run.h"
#include "idle.h"
#include "log.h"
#include "ttf/dataset/reader.h"
#include "view.h"

#define PROGRESS_NS TTF_NS_PER_MIN
#define RETRY_MOST  12 /* times the first wait */
#define TOLD_NS     TTF_NS_PER_S

/* ---- what a run says ---- */

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

    mailbox_put(d->mailbox, p);
    switch (p->kind) {
    case TTF_PROGRESS_ARMED:
        d->wait_ns = d->config.retry_ns; /* it works again */
        absence_over(&d->absence);
        d->told_ns = p->now_ns;
        manager_status(&d->manager, "%sarmed: slot %" PRId64 " of %" PRId64 " is next",
                       d->board.simulated ? "SIMULATED, " : "", p->index, p->total);
        if (p->waits)
            manager_status(&d->manager, "%swaiting for the plan's start",
                           d->board.simulated ? "SIMULATED, " : "");
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
    case TTF_PROGRESS_ALARM_OVER: /* what ended it has an event */
        break;
    }
}

static void on_power_back(void *ctx, int64_t back_ns)
{
    (void)ctx;
    log_line(LOG_LEVEL_WARNING, "power", "simulated=lost back_h=%.2f",
             (double)back_ns / (double)TTF_NS_PER_H);
}

static void on_armed_box(void *ctx, const struct ttf_box *box, const struct ttf_plan *plan,
                         const struct ttf_plan_figures *figures)
{
    struct daemon *d = ctx;

    shadow_take(d->shadow, box);
    situation_storage(d->situation, figures->slot_bytes, plan->reserve_bytes);
}

void runs_prepare(struct daemon *d)
{
    const struct run_choices choices = {.sets = d->sets, .n_sets = d->config.n_sets};
    struct run *run = &d->run;

    run->io = d->io;
    run->board = &d->board;
    run->host = &d->host;
    run->power_back = on_power_back;
    run->box_ready = on_armed_box;
    run->box_ready_ctx = d;
    run_describe(d->io, &d->board, &choices, run->description);
    run->session = (struct ttf_session_config){
        .threads = d->config.threads,
        .progress = on_progress,
        .progress_ctx = d,
        .stop = d->options->stop,
    };
}

/* ---- a run ---- */

static int load_plan(struct daemon *d, const struct order *order, struct ttf_err *err)
{
    int r;

    ttf_plan_file_free(d->run.file);
    d->run.file = NULL;
    r = order->by_request
            ? ttf_plan_file_parse(order->plan, order->yaml, strlen(order->yaml), &d->run.file, err)
            : ttf_plan_file_load(d->config.plan, &d->run.file, err);
    if (r < 0)
        d->run.file = NULL;
    else
        ttf_plan_file_default_zone(d->run.file, d->config.zone);
    return r;
}

/* A plan of the configuration that is not there yet is waited for; 1: go on waiting. */
static int look_for_plan(struct daemon *d, const struct order *order, struct ttf_err *err)
{
    int r = load_plan(d, order, err);

    if (r != -ENOENT || order->by_request)
        return r;
    d->wanted = -1;
    manager_status(&d->manager, "waiting for a plan at %s", d->config.plan);
    if (situation_doing(d->situation) != DOING_WAITING)
        log_line(LOG_LEVEL_NOTICE, "waiting", "plan=\"%s\"", d->config.plan);
    daemon_does(d, DOING_WAITING, "for the plan's file", TTF_NS_UNKNOWN);
    workshop_open(d->workshop, true);
    idle(d, order->generation, d->config.retry_ns, TTF_LED_IDLE);
    return 1;
}

static const char *second_storage(const struct daemon *d)
{
    return ttf_plan_file_plan(d->run.file)->second_storage;
}

/* A new run whose plan has a start, in a box that does not know what time it is: somebody may set its clock any moment. 1: go on waiting. */
static int look_for_clock(struct daemon *d, const struct order *order, const char *path)
{
    struct ttf_err err = {0};
    struct ttf_io_stat st;
    struct ttf_utc utc;
    char file[640], text[900];

    (void)snprintf(file, sizeof file, "%s/dataset.json", path);
    ttf_clock_utc(d->clock, &utc);
    if (ttf_plan_file_check_clock(d->run.file, &utc, &err) == 0 ||
        d->io->ops->stat(d->io, file, &st) == 0)
        return 0;
    ttf_err_text(&err, text, sizeof text);
    manager_status(&d->manager, "waiting for a clock that somebody vouches for");
    if (situation_doing(d->situation) != DOING_WAITING)
        log_line(LOG_LEVEL_WARNING, "waiting", "for=clock dataset=\"%s\"", order->dataset);
    daemon_does(d, DOING_WAITING, text, TTF_NS_UNKNOWN);
    workshop_open(d->workshop, true);
    idle(d, order->generation, d->config.retry_ns, TTF_LED_STOPPED);
    return 1;
}

/* What a run said is told before its end is: whoever hears that nothing runs finds all its slots counted. */
static void let_be_told(struct daemon *d)
{
    int64_t until_ns = ttf_clock_now_ns(d->clock) + TOLD_NS;

    while (!mailbox_all_told(d->mailbox) && ttf_clock_now_ns(d->clock) < until_ns)
        (void)ttf_clock_wait_until(d->clock, ttf_clock_now_ns(d->clock) + 5 * TTF_NS_PER_MS);
}

static int run_it(struct daemon *d, const struct order *order, const char *path,
                  struct ttf_err *err)
{
    int r = ttf_io_mkdirs(d->io, d->config.data, err);

    d->captured = 0;
    memset(&d->run.result, 0, sizeof d->run.result);
    d->run.session.path = path;
    if (r == 0)
        r = run_look(&d->run, err);
    if (r == 0)
        r = calibration_of_run(d->calibrations, d->io, d->run.dataset, d->run.exists,
                               d->calibration, err);
    if (r < 0) {
        calibrations_let_go(d->calibrations);
        return r;
    }
    d->run.session.calibration_folder = r == 1 ? d->calibration : NULL;
    manager_status(&d->manager, "%s %s", d->run.exists ? "going on with" : "beginning", path);
    if (d->wait_ns == d->config.retry_ns) /* not each time that it is tried again */
        log_line(LOG_LEVEL_NOTICE, d->run.exists ? "resuming" : "beginning",
                 "dataset=\"%s\" next=%" PRId64, path, d->run.next_index);
    d->run.session.control = asks_begin(d->asks);
    d->run.session.absence = absence_of(&d->absence, order->dataset);
    r = run_boots(&d->run, err);
    d->run.session.control = NULL;
    calibrations_let_go(d->calibrations);
    asks_end(d->asks);
    let_be_told(d);
    return r;
}

static void tell_end(struct daemon *d)
{
    const struct ttf_session_result *s = &d->run.result;

    log_line(LOG_LEVEL_NOTICE, s->sealed ? "done" : "cut",
             "slots=%" PRId64 " captured=%" PRId64 " partial=%" PRId64 " missed=%" PRId64
             " failed=%" PRId64 " power=%" PRId64 " sealed=%s digest=%s",
             s->slots, s->captured, s->partial, s->missed, s->failed, s->power,
             s->sealed ? "yes" : "no", s->sealed ? s->digest : "none");
    if (s->sealed)
        manager_status(&d->manager, "done: %" PRId64 " of %" PRId64 " slots captured, sealed",
                       s->captured, s->slots);
}

/* It ended well: its plan is done, or somebody wanted it to end. */
static void ended(struct daemon *d, const struct order *order)
{
    struct ttf_err err = {0};

    tell_end(d);
    if (d->run.result.sealed) {
        situation_sealed(d->situation);
        daemon_decided(orders_ended(d->orders, order->generation, ORDER_DONE, &err), &err);
        daemon_does(d, DOING_IDLE, NULL, TTF_NS_UNKNOWN);
    } else if (!daemon_told_to_end(d)) {
        /* By a request, which is on the disk already (and what was decided since then holds), or by the button. */
        daemon_decided(orders_ended(d->orders, order->generation, ORDER_STOPPED, &err), &err);
    }
}

/* What a person has to mend is no use to try again soon; whatever else may pass. */
static bool may_pass(int error)
{
    return run_exit_code(error) == 1 || error == -ENOENT;
}

/* The run lies on a disk that is not there: that does not mend itself. Told once, until a run is armed again. */
static void tell_second_away(struct daemon *d, const struct ttf_err *err)
{
    const struct ttf_progress p = {
        .kind = TTF_PROGRESS_ALARM, .until = TTF_ALARM_UNTIL_ARMED, .text = err->what};

    if (err->code == -ENODEV && strcmp(err->where, "storage.second") == 0 &&
        d->wait_ns == d->config.retry_ns)
        on_progress(d, &p);
}

static void wait_to_try_again(struct daemon *d, const struct order *order,
                              const struct ttf_err *err)
{
    bool passes = may_pass(err->code);
    char text[900], quoted[1000];

    ttf_err_text(err, text, sizeof text);
    manager_status(&d->manager, "%s: %.200s", passes ? "trying again" : "stopped", text);
    log_line(passes ? LOG_LEVEL_WARNING : LOG_LEVEL_ERROR, passes ? "retry" : "stuck",
             "in_s=%.1f why=%s", (double)d->wait_ns / 1e9, log_text(text, quoted, sizeof quoted));
    daemon_does(d, passes ? DOING_RETRYING : DOING_STOPPED, text, d->wait_ns);
    /* What passes is tried again on time: no picture is taken meanwhile. */
    workshop_open(d->workshop, !passes);
    idle(d, order->generation, d->wait_ns, TTF_LED_STOPPED);
    d->wait_ns *= 2;
    if (d->wait_ns > RETRY_MOST * d->config.retry_ns)
        d->wait_ns = RETRY_MOST * d->config.retry_ns;
}

static void one_run(struct daemon *d, const struct order *order)
{
    int64_t begun_ns = ttf_clock_now_ns(d->clock);
    struct ttf_err err = {0};
    char path[600];
    int r = look_for_plan(d, order, &err);

    if (r > 0)
        return;
    (void)snprintf(path, sizeof path, "%s/%s", d->config.data, order->dataset);
    d->mailbox->run = situation_run(d->situation, order, r == 0 ? second_storage(d) : NULL);
    if (d->wanted != order->generation)
        d->run.wanted_ns = begun_ns;
    d->wanted = order->generation;
    if (r == 0 && look_for_clock(d, order, path) == 1)
        return;
    if (r == 0) {
        workshop_open(d->workshop, false);
        view_close(d, true);
        daemon_does(d, DOING_ARMING, NULL, TTF_NS_UNKNOWN);
        r = run_it(d, order, path, &err);
    }
    if (r == 0) {
        ended(d, order);
        return;
    }
    err.code = r;
    absence_tried(&d->absence, order->dataset, begun_ns);
    tell_second_away(d, &err);
    wait_to_try_again(d, order, &err);
}

/* ---- between runs ---- */

/* What rests is told of too: where its slots lie, its plan says. */
static void know(struct daemon *d, const struct order *order)
{
    if (*order->dataset)
        (void)situation_run(d->situation, order,
                            load_plan(d, order, NULL) == 0 ? second_storage(d) : NULL);
}

static void rest(struct daemon *d, const struct order *order)
{
    int64_t from_ns = ttf_clock_now_ns(d->clock);

    if (order->state == ORDER_STOPPED) {
        const char *why = *order->why ? order->why : "stopped by a person";
        char quoted[500];

        know(d, order);
        manager_status(&d->manager, "%s: %s", why, order->dataset);
        if (situation_doing(d->situation) != DOING_STOPPED)
            log_line(*order->why ? LOG_LEVEL_ERROR : LOG_LEVEL_NOTICE, "resting",
                     "why=%s dataset=\"%s\"", log_text(why, quoted, sizeof quoted), order->dataset);
        daemon_does(d, DOING_STOPPED, why, TTF_NS_UNKNOWN);
    } else {
        if (order->state == ORDER_NONE)
            manager_status(&d->manager, "idle");
        else
            know(d, order);
        if (order->state == ORDER_DONE) /* it is that by its seal alone */
            situation_sealed(d->situation);
        daemon_does(d, DOING_IDLE, NULL, TTF_NS_UNKNOWN);
    }
    workshop_open(d->workshop, true);
    /* Nothing is to run: what is, and waits for its plan's file or a clock, is not held up by minutes of a calibration. */
    calibrations_open(d->calibrations);
    idle(d, order->generation, TTF_NS_NEVER,
         order->state == ORDER_STOPPED ? TTF_LED_STOPPED : TTF_LED_IDLE);
    calibrations_give_up(d->calibrations);
    if (order->state == ORDER_STOPPED && !*order->why)
        absence_rested(&d->absence, order->dataset, from_ns, ttf_clock_now_ns(d->clock));
}

void runs_live(struct daemon *d)
{
    d->wait_ns = d->config.retry_ns;
    workshop_open(d->workshop, true);
    while (!daemon_told_to_end(d)) {
        struct order order = {0};
        struct ttf_err err = {0};

        if (orders_take(d->orders, &order, &err) < 0) {
            wait_to_try_again(d, &order, &err);
        } else if (order.state == ORDER_RUN) {
            one_run(d, &order);
        } else {
            d->wait_ns = d->config.retry_ns;
            asks_end(d->asks);
            rest(d, &order);
        }
        order_free(&order);
    }
    workshop_open(d->workshop, false);
    view_close(d, true);
    asks_end(d->asks);
    ttf_plan_file_free(d->run.file);
}
