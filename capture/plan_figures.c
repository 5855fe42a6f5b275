/* SPDX-License-Identifier: Apache-2.0 */
#include "plan_figures.h"

#include <string.h>

#include "exposure.h"
#include "flicker.h"
#include "lamp_programme.h"
#include "queue.h"
#include "stock.h"
#include "ttf/base/checked.h"
#include "ttf/base/time.h"

#define FILE_OVERHEAD_BYTES 8192
#define RECORD_BYTES        2048

struct ttf_camera *ttf_box_camera_find(const struct ttf_box *box, const char *name)
{
    for (unsigned i = 0; i < box->n_cameras; i++) {
        if (strcmp(box->cameras[i].name, name) == 0)
            return box->cameras[i].camera;
    }
    return NULL;
}

enum ttf_keep ttf_plan_keep(const struct ttf_plan *plan, const struct ttf_frame_format *format)
{
    /* A camera that develops by itself, or sees no colours, has nothing that a DNG would hold. */
    if (format->cfa == TTF_CFA_NONE)
        return TTF_KEEP_DEVELOPED;
    if (plan->keep != TTF_KEEP_DEFAULT)
        return plan->keep;
    return (int64_t)format->width * format->height > TTF_KEEP_RAW_ABOVE_PIXELS ? TTF_KEEP_RAW
                                                                               : TTF_KEEP_BOTH;
}

struct ttf_region ttf_plan_region(const struct ttf_plan *plan,
                                  const struct ttf_frame_format *format)
{
    struct ttf_region whole = {0, 0, format->width, format->height};

    return plan->region.width ? plan->region : whole;
}

/* Exposing all images of a shot, from the submission of the first set on. */
static int64_t exposing_ns(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                           const struct ttf_camera *camera)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(camera);
    int64_t total = 0;

    for (unsigned i = 0; i < ttf_shot_images(shot); i++) {
        struct ttf_exposure e = ttf_shot_exposure(shot, i, plan->mains_hz, caps->exposure_max_ns);

        total += ttf_exposure_lead_ns(caps, e.exposure_ns) +
                 ttf_exposures_span_ns(caps, e.exposure_ns, shot->average);
    }
    return total;
}

static unsigned level_of(const struct ttf_lamp_level *levels, unsigned n, const char *lamp)
{
    for (unsigned i = 0; i < n; i++) {
        if (strcmp(levels[i].lamp, lamp) == 0)
            return levels[i].permille;
    }
    return 0;
}

static bool levels_within(const struct ttf_plan_shot *a, const struct ttf_plan_shot *b)
{
    for (unsigned i = 0; i < a->n_levels; i++) {
        if (level_of(b->levels, b->n_levels, a->levels[i].lamp) != a->levels[i].permille)
            return false;
    }
    return true;
}

/* Lamps that burn from start to end and that no shot changes: they settle once. */
static bool steady_light(const struct ttf_plan *plan)
{
    if (plan->lamps != TTF_LAMPS_CONTINUOUS)
        return false;
    for (unsigned i = 1; i < plan->n_shots; i++) {
        if (!levels_within(&plan->shots[i], &plan->shots[0]) ||
            !levels_within(&plan->shots[0], &plan->shots[i]))
            return false;
    }
    return true;
}

int64_t ttf_first_settle_ns(const struct ttf_plan *plan, const struct ttf_box *box)
{
    return steady_light(plan) ? ttf_lamp_settle_ns(plan, &plan->shots[0], box->lamps) : 0;
}

/* What a shot of every slot waits for its lamps. */
static int64_t slot_settle_ns(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                              const struct ttf_box *box)
{
    return steady_light(plan) ? 0 : ttf_lamp_settle_ns(plan, shot, box->lamps);
}

int64_t ttf_shot_busy_ns(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                         const struct ttf_box *box)
{
    struct ttf_camera *camera = ttf_box_camera_find(box, shot->camera);

    return slot_settle_ns(plan, shot, box) + (camera ? exposing_ns(plan, shot, camera) : 0);
}

int64_t ttf_slot_lead_ns(const struct ttf_plan *plan, const struct ttf_box *box)
{
    const struct ttf_plan_shot *shot = &plan->shots[0];
    struct ttf_camera *camera = ttf_box_camera_find(box, shot->camera);
    const struct ttf_camera_caps *caps = ttf_camera_caps(camera);
    struct ttf_exposure e = ttf_shot_exposure(shot, 0, plan->mains_hz, caps->exposure_max_ns);

    return slot_settle_ns(plan, shot, box) + ttf_exposure_lead_ns(caps, e.exposure_ns);
}

/* Time on at `on_ns` in each `period_ns`, at worst, within any window. */
static int64_t worst_in_window(int64_t on_ns, int64_t period_ns, int64_t window_ns)
{
    int64_t rest = window_ns % period_ns;
    int64_t worst;

    if (on_ns >= period_ns)
        return window_ns;
    worst = window_ns / period_ns * on_ns;
    /* The window can begin with one stretch and end with another. */
    worst += rest < on_ns ? rest : on_ns;
    return worst < window_ns ? worst : window_ns;
}

/* Time that a lamp burns within one slot's own work. */
static int64_t lamp_slot_ns(const struct ttf_plan *plan, const struct ttf_box *box,
                            const char *lamp, unsigned *ret_stretches)
{
    int64_t on = 0;
    bool lit = false;

    *ret_stretches = 0;
    for (unsigned i = 0; i < plan->n_shots; i++) {
        const struct ttf_plan_shot *shot = &plan->shots[i];
        bool now = level_of(shot->levels, shot->n_levels, lamp) > 0;

        if (now)
            on += ttf_shot_busy_ns(plan, shot, box);
        if (now && !lit)
            (*ret_stretches)++;
        lit = now;
    }
    return on;
}

static void fill_lamp(const struct ttf_plan *plan, const struct ttf_box *box, unsigned i,
                      struct ttf_plan_figures *f)
{
    const struct ttf_lamp_info *info = ttf_lamps_info(box->lamps, i);
    int64_t whole = f->duration_ns + f->slot_busy_ns + ttf_first_settle_ns(plan, box);
    int64_t window = info->duty_window_ns > 0 ? info->duty_window_ns : whole;
    unsigned stretches = 0;
    int64_t slot_ns = lamp_slot_ns(plan, box, info->name, &stretches);
    bool by_day = level_of(plan->day_levels, plan->n_day_levels, info->name) > 0;
    bool always = plan->lamps == TTF_LAMPS_CONTINUOUS &&
                  level_of(plan->shots[0].levels, plan->shots[0].n_levels, info->name) > 0;
    int64_t worst = always ? window : worst_in_window(slot_ns, plan->interval_ns, window);

    f->lamp_on_ns[i] = always ? whole : slot_ns * f->slots;
    f->lamp_switchings[i] = always ? 1 : stretches * f->slots;
    if (plan->lamps == TTF_LAMPS_PHOTOPERIOD && by_day) {
        int64_t periods = whole / plan->period_ns;
        int64_t rest = whole % plan->period_ns;

        f->lamp_on_ns[i] = periods * plan->day_ns + (rest < plan->day_ns ? rest : plan->day_ns) +
                           (int64_t)((double)f->lamp_on_ns[i] *
                                     (1 - (double)plan->day_ns / (double)plan->period_ns));
        f->lamp_switchings[i] += periods + 1;
        worst += worst_in_window(plan->day_ns, plan->period_ns, window);
    }
    /* No window has more than all of the run. */
    worst = worst < f->lamp_on_ns[i] ? worst : f->lamp_on_ns[i];
    worst = worst < window ? worst : window;
    f->lamp_duty_permille[i] =
        window > 0 ? (unsigned)((double)worst * 1000 / (double)window + 0.5) : 0;
}

/* Of the shortest exposure of a shot, all its dimmed lamps together: at worst their bands coincide. */
static int64_t shot_flicker_ppm(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                                const struct ttf_box *box, int64_t exposure_max_ns)
{
    int64_t shortest_ns = INT64_MAX, ppm = 0;

    for (unsigned i = 0; i < ttf_shot_images(shot); i++) {
        int64_t ns = ttf_shot_exposure(shot, i, plan->mains_hz, exposure_max_ns).exposure_ns;

        if (ns < shortest_ns)
            shortest_ns = ns;
    }
    for (unsigned i = 0; box->lamps && i < ttf_lamps_count(box->lamps); i++) {
        const struct ttf_lamp_info *info = ttf_lamps_info(box->lamps, i);

        ppm += ttf_flicker_ppm(shortest_ns, info->pwm_period_ns,
                               level_of(shot->levels, shot->n_levels, info->name));
    }
    return ppm;
}

/* All raw sums, the camera's own buffers, dark and flat per pixel, strips of work. */
static int64_t memory_of(const struct ttf_camera *camera)
{
    const struct ttf_frame_format *format = ttf_camera_format(camera);
    int64_t pixels = (int64_t)format->width * format->height;
    size_t samples;

    if (ttf_raw_sum_samples(format, &samples) < 0)
        samples = 0; /* refused when it is armed */
    return ttf_queue_raws(samples) * (int64_t)(samples * TTF_RAW_SUM_BYTES) + pixels * (4 + 2) +
           (int64_t)ttf_camera_caps(camera)->buffers * (int64_t)format->stride * format->height +
           (INT64_C(8) << 20);
}

static void fill_shot(const struct ttf_plan *plan, const struct ttf_box *box, unsigned i,
                      struct ttf_plan_figures *f)
{
    const struct ttf_plan_shot *shot = &plan->shots[i];
    const struct ttf_camera *camera = ttf_box_camera_find(box, shot->camera);
    const struct ttf_frame_format *format = ttf_camera_format(camera);
    enum ttf_keep keep = ttf_plan_keep(plan, format);
    struct ttf_region region = ttf_plan_region(plan, format);
    int64_t raw_px = (int64_t)format->width * format->height;
    int64_t kept_px = (int64_t)region.width * region.height;
    int64_t image = 0;
    int64_t memory = memory_of(camera);

    if (keep != TTF_KEEP_DEVELOPED)
        image += raw_px * 2 + FILE_OVERHEAD_BYTES;
    if (keep != TTF_KEEP_RAW)
        image += kept_px * 6 + FILE_OVERHEAD_BYTES;
    f->slot_bytes += image * (int64_t)ttf_shot_images(shot) + RECORD_BYTES;
    f->slot_busy_ns += ttf_shot_busy_ns(plan, shot, box);
    f->exposure_ns[i] = ttf_exposure_snap(shot->exposure.exposure_ns, plan->mains_hz,
                                          ttf_camera_caps(camera)->exposure_max_ns);
    f->flicker_ppm[i] = shot_flicker_ppm(plan, shot, box, ttf_camera_caps(camera)->exposure_max_ns);
    if (memory > f->memory_bytes)
        f->memory_bytes = memory;
}

void ttf_plan_figures_fill(const struct ttf_plan *plan, const struct ttf_box *box,
                           struct ttf_plan_figures *ret)
{
    struct ttf_plan_figures f = {.slots = plan->count};

    if (!ttf_mul_i64(plan->count - 1, plan->interval_ns, &f.duration_ns))
        f.duration_ns = TTF_NS_NEVER;
    for (unsigned i = 0; i < plan->n_shots; i++) {
        if (box)
            fill_shot(plan, box, i, &f);
        else
            f.exposure_ns[i] =
                ttf_exposure_snap(plan->shots[i].exposure.exposure_ns, plan->mains_hz, 0);
    }
    if (!ttf_mul_i64(f.slot_bytes, plan->count, &f.bytes))
        f.bytes = INT64_MAX;
    for (unsigned i = 0; box && box->lamps && i < ttf_lamps_count(box->lamps); i++)
        fill_lamp(plan, box, i, &f);
    if (box) {
        const struct ttf_stock_size slots = ttf_stock_size_of(plan);

        f.ready_ns = ttf_first_settle_ns(plan, box) + ttf_slot_lead_ns(plan, box);
        f.memory_bytes += ttf_stock_bytes(&slots);
    }
    *ret = f;
}

void ttf_plan_figures_put(const struct ttf_plan *plan, const struct ttf_plan_figures *figures,
                          struct ttf_json *j)
{
    const struct ttf_plan_figures *f = figures;

    ttf_json_kstring(j, "title", plan->title);
    ttf_json_kint(j, "slots", f->slots);
    ttf_json_kint(j, "interval_ns", plan->interval_ns);
    ttf_json_kint(j, "duration_ns", f->duration_ns);
    ttf_json_kint(j, "ready_ns", f->ready_ns);
    ttf_json_kint(j, "bytes", f->bytes);
    ttf_json_kint(j, "slot_bytes", f->slot_bytes);
    ttf_json_kint(j, "slot_busy_ns", f->slot_busy_ns);
    ttf_json_kint(j, "memory_bytes", f->memory_bytes);
    ttf_json_key(j, "flicker_ppm");
    ttf_json_array(j);
    for (unsigned i = 0; i < plan->n_shots; i++)
        ttf_json_int(j, f->flicker_ppm[i]);
    ttf_json_array_end(j);
}
