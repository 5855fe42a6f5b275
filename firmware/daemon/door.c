/* SPDX-License-Identifier: Apache-2.0 */
#include "door.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "boards.h"
#include "check.h"
#include "check_board.h"
#include "library.h"
#include "log.h"
#include "parts.h"
#include "ttf/capture/note.h"
#include "ttf/http/token.h"

static struct daemon *of(struct ttf_http_box *box)
{
    return (struct daemon *)box;
}

/* ---- status ---- */

static void put_disk(struct daemon *d, struct ttf_json *json)
{
    struct ttf_io_space space;

    if (d->io->ops->space(d->io, d->config.data, &space) < 0)
        return;
    ttf_json_key(json, "disk");
    ttf_json_object(json);
    ttf_json_kint(json, "free_bytes", space.free_bytes);
    ttf_json_kint(json, "total_bytes", space.total_bytes);
    ttf_json_object_end(json);
}

static int door_status(struct ttf_http_box *box, char **ret_json, struct ttf_err *err)
{
    struct daemon *d = of(box);
    char id[TTF_HTTP_EVENT_ID_SIZE];
    struct ttf_json json;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "version", TTFBOX_VERSION);
    ttf_json_kstring(&json, "serial", d->serial);
    ttf_json_kstring(&json, "board", d->board.name);
    ttf_json_kbool(&json, "simulated", d->board.simulated);
    /* The id first: what happens meanwhile is told again, never left out. */
    ttf_json_kstring(&json, "last_event_id", ttf_http_events_last(d->events, id));
    situation_status(d->situation, &json);
    put_disk(d, &json);
    ttf_json_object_end(&json);
    return daemon_give(&json, ret_json, err);
}

/* ---- plans and boards ---- */

static int door_devices(struct ttf_http_box *box, char **ret_json, struct ttf_err *err)
{
    return check_devices(of(box), ret_json, err);
}

static int door_boards(struct ttf_http_box *box, char **ret_json, struct ttf_err *err)
{
    return boards_list(of(box), ret_json, err);
}

static int door_board(struct ttf_http_box *box, const char *name, const char *plan, char **ret_yaml,
                      struct ttf_err *err)
{
    return boards_show(of(box), name, plan, ret_yaml, err);
}

static int door_board_check(struct ttf_http_box *box, const char *yaml, size_t bytes,
                            char **ret_json, struct ttf_err *err)
{
    (void)box; /* the text alone is looked at */
    return check_board(yaml, bytes, NULL, ret_json, err);
}

static int door_board_put(struct ttf_http_box *box, const char *name, const char *yaml,
                          size_t bytes, char **ret_json, struct ttf_err *err)
{
    int r = boards_put(of(box), name, yaml, bytes, ret_json, err);

    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "board", "sent=\"%s\"", name);
    return r;
}

static int door_board_delete(struct ttf_http_box *box, const char *name, struct ttf_err *err)
{
    int r = boards_delete(of(box), name, err);

    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "board", "deleted=\"%s\"", name);
    return r;
}

static int door_plans(struct ttf_http_box *box, char **ret_json, struct ttf_err *err)
{
    return library_plans(of(box), ret_json, err);
}

static int door_plan(struct ttf_http_box *box, const char *name, char **ret_yaml,
                     struct ttf_err *err)
{
    return library_plan(of(box), name, ret_yaml, err);
}

static int door_plan_check(struct ttf_http_box *box, const char *yaml, size_t bytes,
                           char **ret_json, struct ttf_err *err)
{
    bool ok;

    return check_plan(of(box), "plan", yaml, bytes, ret_json, &ok, err);
}

static int door_plan_put(struct ttf_http_box *box, const char *name, const char *yaml, size_t bytes,
                         char **ret_json, struct ttf_err *err)
{
    char *json = NULL;
    bool ok = false;
    int r = check_plan(of(box), name, yaml, bytes, &json, &ok, err);

    if (r == 0 && !ok)
        r = err->code = -EINVAL;
    if (r == 0)
        r = library_put(of(box), name, yaml, bytes, err);
    if (r < 0) {
        free(json);
        return r;
    }
    log_line(LOG_LEVEL_NOTICE, "plan", "put=\"%s\"", name);
    *ret_json = json;
    return 0;
}

static int door_plan_delete(struct ttf_http_box *box, const char *name, struct ttf_err *err)
{
    int r = library_delete(of(box), name, err);

    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "plan", "deleted=\"%s\"", name);
    return r;
}

/* ---- a run ---- */

static int started(struct daemon *d, const char *dataset, char **ret_json, struct ttf_err *err)
{
    struct ttf_json json;

    log_line(LOG_LEVEL_NOTICE, "asked", "for=start dataset=\"%s\"", dataset);
    __atomic_store_n(&d->view_stop, 1, __ATOMIC_SEQ_CST);
    ttf_gate_open(d->wake);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "dataset", dataset);
    ttf_json_object_end(&json);
    return daemon_give(&json, ret_json, err);
}

static int go_on(struct daemon *d, char **ret_json, struct ttf_err *err)
{
    struct order order = {0};
    int r = orders_go_on(d->orders, err);

    if (r == 0)
        r = orders_get(d->orders, &order);
    if (r == 0)
        r = started(d, order.dataset, ret_json, err);
    order_free(&order);
    return r;
}

static int start(struct daemon *d, const char *plan, const char *dataset, char **ret_json,
                 struct ttf_err *err)
{
    char *yaml = NULL, *json = NULL;
    bool ok = false;
    int r;

    r = library_plan(d, plan, &yaml, err);
    if (r == 0)
        r = check_plan(d, plan, yaml, strlen(yaml), &json, &ok, err);
    if (r == 0 && !ok)
        r = err->code = -EINVAL;
    if (r == 0)
        r = library_may_start(d, dataset, yaml, err);
    if (r == 0)
        r = orders_start(d->orders, plan, yaml, dataset, err);
    if (r == 0)
        r = started(d, dataset, ret_json, err);
    free(yaml);
    free(json);
    return r;
}

/* Checking may take as long as a camera does to answer: who comes meanwhile is told so, and keeps nobody's place. */
static int door_start(struct ttf_http_box *box, const char *plan, const char *dataset,
                      char **ret_json, struct ttf_err *err)
{
    struct daemon *d = of(box);
    int r;

    if (!*plan && !*dataset)
        return go_on(d, ret_json, err);
    if (!*plan)
        return ttf_err_set(err, -EINVAL, "plan", "is missing");
    if (pthread_mutex_trylock(&d->starting) != 0)
        return ttf_err_set(err, -EBUSY, NULL, "another run is just being started");
    r = start(d, plan, *dataset ? dataset : plan, ret_json, err);
    (void)pthread_mutex_unlock(&d->starting);
    return r;
}

static int show(struct daemon *d, int64_t number, char **ret_json, struct ttf_err *err)
{
    struct ttf_json json;
    int r;

    ttf_json_init(&json, false);
    r = asks_show(d->asks, number, &json);
    if (r == 0)
        return daemon_give(&json, ret_json, err);
    ttf_json_free(&json);
    return ttf_err_set(err, r, NULL, "nothing of this number was asked, or long ago");
}

/*
 * A stop is a decision first, on the disk, and then an end of what runs (orders.h: of that alone). What runs may have ended, and answered
 * what was asked, before the decision is told here: so the number is there before it.
 */
static int stop(struct daemon *d, char **ret_json, struct ttf_err *err)
{
    int64_t number = asks_stop(d->asks);
    int r = orders_stop(d->orders, err);

    if (r < 0) {
        asks_take_back(d->asks, number);
        return r;
    }
    log_line(LOG_LEVEL_NOTICE, "asked", "for=stop");
    if (situation_turn(d->situation, DOING_CAPTURING, DOING_STOPPING) ||
        situation_turn(d->situation, DOING_PAUSED, DOING_STOPPING) ||
        situation_turn(d->situation, DOING_WAITING, DOING_STOPPING))
        daemon_tell_state(d);
    ttf_gate_open(d->wake);
    return show(d, number, ret_json, err);
}

static int door_ask(struct ttf_http_box *box, const struct ttf_http_ask *ask, char **ret_json,
                    struct ttf_err *err)
{
    struct daemon *d = of(box);
    int64_t number;

    if (ask->kind == TTF_HTTP_ASK_STOP)
        return stop(d, ret_json, err);
    number = asks_put(d->asks, ask, err);
    return number < 0 ? (int)number : show(d, number, ret_json, err);
}

static int door_asked(struct ttf_http_box *box, int64_t number, char **ret_json,
                      struct ttf_err *err)
{
    return show(of(box), number, ret_json, err);
}

/* What the clock makes of it, the run under way writes into its dataset by itself. */
static int door_time(struct ttf_http_box *box, int64_t utc_ns, char **ret_json, struct ttf_err *err)
{
    struct daemon *d = of(box);
    struct ttf_err why = {0};
    struct ttf_json json;
    int r = ttf_host_time_offer(d->host_time, d->clock, utc_ns, &why);

    if (r < 0 && r != -EALREADY) {
        if (err)
            *err = why;
        return r;
    }
    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "time", "from=host utc_ns=%" PRId64, utc_ns);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kbool(&json, "taken", r == 0);
    if (r < 0)
        ttf_json_kstring(&json, "why", why.what);
    ttf_json_object_end(&json);
    return daemon_give(&json, ret_json, err);
}

static int door_note(struct ttf_http_box *box, const char *dataset, const struct ttf_note *note,
                     struct ttf_err *err)
{
    struct daemon *d = of(box);
    struct ttf_note *timed = malloc(sizeof *timed);
    struct ttf_utc utc;
    char path[600];
    int r;

    if (!timed)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    *timed = *note;
    ttf_clock_utc(d->clock, &utc);
    if (utc.trust != TTF_TRUST_NONE)
        timed->utc_ns = utc.utc_ns;
    (void)snprintf(path, sizeof path, "%s/%s", d->config.data, dataset);
    r = ttf_note_add(d->clock, d->io, path, timed, err);
    free(timed);
    return r;
}

/* ---- calibrations ---- */

static int door_calibrations(struct ttf_http_box *box, char **ret_json, struct ttf_err *err)
{
    return calibrations_show(of(box)->calibrations, ret_json, err);
}

/* While nothing runs the owner of the devices looks for it. */
static int door_calibrate(struct ttf_http_box *box, const struct ttf_http_calibrate *what,
                          char **ret_json, struct ttf_err *err)
{
    struct daemon *d = of(box);
    int r = calibrations_ask(d->calibrations, what, err);

    if (r < 0)
        return r;
    log_line(LOG_LEVEL_NOTICE, "asked", "for=%s calibration=\"%s\"",
             ttf_calibration_part_name(what->part), what->name);
    ttf_gate_open(d->wake);
    return calibrations_show(d->calibrations, ret_json, err);
}

static int door_calibration_use(struct ttf_http_box *box, const char *name, struct ttf_err *err)
{
    int r = calibrations_use(of(box)->calibrations, name, err);

    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "calibration", "used=\"%s\"", name);
    return r;
}

static int door_calibration_delete(struct ttf_http_box *box, const char *name, struct ttf_err *err)
{
    int r = calibrations_remove(of(box)->calibrations, name, err);

    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "calibration", "removed=\"%s\"", name);
    return r;
}

/* ---- pictures ---- */

static int door_live(struct ttf_http_box *box, const struct ttf_http_view *view,
                     struct ttf_http_shown *ret, struct ttf_err *err)
{
    struct workshop_job job = {.view = view};
    int r = workshop_ask(of(box)->workshop, &job, err);

    if (r == 0)
        *ret = job.shown;
    return r;
}

static int door_newest(struct ttf_http_box *box, char ret_dataset[65], struct ttf_err *err)
{
    situation_dataset(of(box)->situation, ret_dataset);
    return *ret_dataset ? 0 : ttf_err_set(err, -ENOENT, NULL, "nothing was captured yet");
}

/* ---- the token ---- */

static bool door_token_waits(struct ttf_http_box *box)
{
    return ttf_http_token_waits(of(box)->config.token_file, of(box)->token);
}

static int door_token_show(struct ttf_http_box *box, struct ttf_err *err)
{
    int r = ttf_http_token_show(of(box)->config.token_file, of(box)->token, err);

    if (r == 0)
        log_line(LOG_LEVEL_NOTICE, "token", "shown=once to=cable");
    return r;
}

const struct ttf_http_box_ops DOOR_OPS = {
    .name = "ttfboxd",
    .status = door_status,
    .devices = door_devices,
    .boards = door_boards,
    .board = door_board,
    .board_check = door_board_check,
    .board_put = door_board_put,
    .board_delete = door_board_delete,
    .plans = door_plans,
    .plan = door_plan,
    .plan_check = door_plan_check,
    .plan_put = door_plan_put,
    .plan_delete = door_plan_delete,
    .start = door_start,
    .ask = door_ask,
    .asked = door_asked,
    .time = door_time,
    .note = door_note,
    .calibrations = door_calibrations,
    .calibrate = door_calibrate,
    .calibration_use = door_calibration_use,
    .calibration_delete = door_calibration_delete,
    .live = door_live,
    .newest = door_newest,
    .token_waits = door_token_waits,
    .token_show = door_token_show,
};
