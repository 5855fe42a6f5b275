/* SPDX-License-Identifier: Apache-2.0 */
#include "session_box.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "slot_hash.h"
#include "ttf/hal/sim.h"

#define PIXELS 16

void session_box_break(struct session_box *s, const char *format, ...)
{
    va_list args;

    if (s->broken[0])
        return;
    va_start(args, format);
    vsnprintf(s->broken, sizeof(s->broken), format, args);
    va_end(args);
}

void session_box_init(struct session_box *s, struct ttf_io *io, int64_t slots, bool second)
{
    struct ttf_plan_shot *shot = &s->plan.shots[0];

    memset(s, 0, sizeof(*s));
    s->io = io;
    ttf_plan_defaults(&s->plan);
    snprintf(s->plan.title, sizeof(s->plan.title), "a capture");
    s->plan.interval_ns = TTF_NS_PER_MIN;
    s->plan.count = slots;
    s->plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    s->plan.settle_ns = 10 * TTF_NS_PER_S;
    s->plan.reserve_bytes = 0;
    shot->n_levels = 1;
    snprintf(shot->levels[0].lamp, sizeof(shot->levels[0].lamp), "left");
    shot->levels[0].permille = 1000;
    if (second)
        snprintf(s->plan.second_storage, sizeof(s->plan.second_storage), SESSION_SECOND);
}

void session_box_live(struct session_box *s, const struct living *living)
{
    s->living = living;
    s->plan = living->plans[0];
    s->asks = (UINT32_C(1) << living->n_asks) - 1;
}

/* Of one who asks once more. */
static bool makes_sense(const struct session_box *s, unsigned i)
{
    const struct living *living = s->living;

    if (s->promise.done & UINT32_C(1) << i)
        return false;
    if (living->asks[i].kind == TTF_ASK_STOP || living->asks[i].kind == TTF_ASK_UNTIL)
        return false;
    return living->plan_of[i] == 0 ||
           (living->plan_of[i] > s->promise.plan && living->plan_of[i] > s->given);
}

void session_box_go_on(struct session_box *s, int given, bool ask_again)
{
    s->asks = 0;
    if (!s->living)
        return;
    s->given = given;
    s->plan = s->living->plans[given];
    for (unsigned i = 0; ask_again && i < s->living->n_asks; i++)
        if (makes_sense(s, i))
            s->asks |= UINT32_C(1) << i;
}

/* The slots due before an instant, on the grid that the run began with: it is not moved by plans that end so. */
static int64_t count_until(const struct session_box *s, const struct ttf_plan *plan)
{
    struct ttf_reader *reader = NULL;
    struct ttf_segment first = {.origin_utc_ns = TTF_NS_UNKNOWN};
    int64_t length;

    if (ttf_reader_open(s->io, SESSION_PATH, &reader, NULL) == 0)
        (void)!ttf_reader_segment(reader, 0, &first);
    ttf_reader_close(reader);
    length = plan->until_utc_ns - first.origin_utc_ns;
    return first.origin_utc_ns == TTF_NS_UNKNOWN || length <= 0
               ? plan->count
               : (length - 1) / plan->interval_ns + 1;
}

int64_t session_box_count(const struct session_box *s)
{
    const struct ttf_plan *plan = s->living ? &s->living->plans[s->promise.plan] : &s->plan;

    return plan->end == TTF_END_UNTIL ? count_until(s, plan) : plan->count;
}

/* ---- asking ---- */

static void ask(struct session_box *s)
{
    s->control = ttf_control_create();
    if (!s->control)
        abort();
    for (unsigned i = 0; i < LIVING_ASKS_MAX; i++) {
        s->answers[i] = -ENOENT;
        if (!(s->asks & UINT32_C(1) << i))
            continue;
        s->numbers[i] = ttf_control_ask(s->control, &s->living->asks[i]);
        s->answers[i] = -EAGAIN;
        if (s->numbers[i] < 0)
            session_box_break(s, "ask %u is not even heard", i);
    }
}

static void answered(struct session_box *s, unsigned i)
{
    s->promise.done |= UINT32_C(1) << i;
    if (s->living->plan_of[i] > s->promise.plan)
        s->promise.plan = s->living->plan_of[i];
    s->stopped = s->stopped || s->living->asks[i].kind == TTF_ASK_STOP;
}

void session_box_hear(struct session_box *s)
{
    for (unsigned i = 0; s->control && i < LIVING_ASKS_MAX; i++) {
        if (s->answers[i] != -EAGAIN)
            continue;
        s->answers[i] = ttf_control_answer(s->control, s->numbers[i], NULL);
        if (s->answers[i] == 0)
            answered(s, i);
    }
}

int64_t session_box_elapsed_ns(const struct session_box *s)
{
    return ttf_sim_elapsed_ns(s->box, ttf_clock_now_ns(s->box->clock));
}

/* ---- records ---- */

void session_box_second_path(const struct session_box *s, char ret[600])
{
    ret[0] = '\0';
    if (s->plan.second_storage[0])
        snprintf(ret, 600, "%s%s", s->plan.second_storage, strrchr(SESSION_PATH, '/'));
}

/* Whether the second dataset is there and has this slot's time. */
static bool is_seconds(const struct session_box *s, const char *second, int64_t index)
{
    struct ttf_reader *reader = NULL;
    struct ttf_segment segment;
    bool is = false;

    if (second[0] == '\0' || ttf_reader_open(s->io, second, &reader, NULL) < 0)
        return false;
    if (ttf_reader_segment(reader, 0, &segment) == 0)
        is = segment.first_index <= index;
    ttf_reader_close(reader);
    return is;
}

int session_box_record(const struct session_box *s, int64_t index, struct ttf_slot_record *ret)
{
    struct ttf_reader *reader = NULL;
    char second[600];
    int64_t i;
    int r;

    session_box_second_path(s, second);
    r = ttf_reader_open(s->io, is_seconds(s, second, index) ? second : SESSION_PATH, &reader, NULL);
    if (r < 0)
        return r;
    i = ttf_reader_find(reader, index);
    r = i < 0 ? (int)i : ttf_reader_slot(reader, i, ret, NULL);
    ttf_reader_close(reader);
    return r;
}

/* ---- what the session tells ---- */

/* A pause is of the boot in which it was asked for; slots that have passed before it was heard are lost ones. */
static void look_paused(struct session_box *s, const struct ttf_progress *progress)
{
    const char *reason = s->living ? living_paused(s->living, s->asks, progress->index) : NULL;

    if (progress->result == TTF_RESULT_PAUSED &&
        (!reason || !progress->text || strcmp(progress->text, reason) != 0))
        session_box_break(s, "slot %lld is paused, and nobody asked for that: %s",
                          (long long)progress->index, progress->text ? progress->text : "");
    if (reason &&
        (progress->result == TTF_RESULT_CAPTURED || progress->result == TTF_RESULT_PARTIAL))
        session_box_break(s, "slot %lld is captured in a pause", (long long)progress->index);
}

static void told_slot(struct session_box *s, const struct ttf_progress *progress)
{
    struct session_promise *promise = &s->promise;
    struct session_slot *slot = &promise->slots[promise->n_slots];
    struct ttf_slot_record record;

    if (progress->index != promise->n_slots || promise->n_slots == SESSION_SLOTS_MAX) {
        session_box_break(s, "slot %lld is acknowledged, and the next one is %lld",
                          (long long)progress->index, (long long)promise->n_slots);
        return;
    }
    *slot = (struct session_slot){.acknowledged = true, .result = progress->result};
    promise->n_slots++;
    look_paused(s, progress);
    if (!s->read_back)
        return;
    if (session_box_record(s, progress->index, &record) < 0) {
        session_box_break(s, "slot %lld is acknowledged and cannot be read",
                          (long long)progress->index);
        return;
    }
    slot->hash = slot_hash(&record);
    ttf_slot_record_free(&record);
}

static void told(void *ctx, const struct ttf_progress *progress)
{
    struct session_box *s = ctx;

    switch (progress->kind) {
    case TTF_PROGRESS_ARMED:
        if (s->given > s->promise.plan)
            s->promise.plan = s->given;
        s->armed = s->promise.armed = true;
        break;
    case TTF_PROGRESS_SLOT:
        told_slot(s, progress);
        break;
    case TTF_PROGRESS_EVENT:
        if (s->promise.n_events < SESSION_EVENTS_MAX)
            snprintf(s->events[s->promise.n_events++], SESSION_TEXT_BYTES, "%s", progress->text);
        break;
    case TTF_PROGRESS_ALARM:
        s->alarms++;
        break;
    case TTF_PROGRESS_ALARM_OVER:
        s->alarms_over++;
        break;
    }
}

/* ---- a boot ---- */

static int make_box(const struct session_box *s, struct ttf_box *ret, struct ttf_err *err)
{
    struct ttf_sim_config config;
    struct ttf_scene scene;
    int r;

    ttf_sim_config_defaults(&config);
    config.width = config.height = PIXELS;
    config.power_on_ns = s->power_on_ns;
    r = ttf_scene_procedural("chart", config.seed, TTF_NS_PER_DAY, &scene, err);
    return r < 0 ? r : ttf_sim_box_create(&config, &scene, ret, err);
}

void session_box_boot(struct session_box *s)
{
    struct ttf_session_config config = {.io = s->io,
                                        .path = SESSION_PATH,
                                        .plan = &s->plan,
                                        .plan_yaml = "# as given\n",
                                        .calibration_folder = s->calibration_folder,
                                        .threads = 1,
                                        .progress = told,
                                        .progress_ctx = s,
                                        .skip_speed_check = true};
    struct ttf_box box;

    memset(&s->err, 0, sizeof(s->err));
    memset(&s->result, 0, sizeof(s->result));
    s->armed = false;
    s->alarms = s->alarms_over = 0;
    s->stopped = false;
    s->slots_before = s->promise.n_slots;
    s->code = make_box(s, &box, &s->err);
    if (s->code < 0) {
        session_box_break(s, "no box: %s: %s", s->err.where, s->err.what);
        return;
    }
    if (s->living)
        ask(s);
    s->box = config.box = &box;
    config.control = s->control;
    s->code = ttf_session_run(&config, &s->result, &s->err);
    s->ended_ns = session_box_elapsed_ns(s);
    session_box_hear(s);
    ttf_control_destroy(s->control);
    s->control = NULL;
    s->promise.sealed = s->promise.sealed || (s->code == 0 && s->result.sealed);
    s->box = NULL;
    ttf_box_destroy(&box);
}
