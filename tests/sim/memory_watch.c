/* SPDX-License-Identifier: Apache-2.0 */
#include "memory_watch.h"

#include "cmocka_includes.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "ttf/capture/guided_calibration.h"

static char calibration_folder[128];

/* Without stdio, whose buffers would be counted. */
static long resident_kb(void)
{
    char line[128] = "";
    int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    ssize_t got = file < 0 ? -1 : read(file, line, sizeof(line) - 1);
    char *end;

    if (file >= 0)
        close(file);
    if (got <= 0)
        return 0;
    (void)strtol(line, &end, 10); /* the whole; then what is resident, in pages */
    return strtol(end, NULL, 10) * (sysconf(_SC_PAGESIZE) / 1024);
}

static struct memory_sample look(void)
{
    return (struct memory_sample){.ours = alloc_hook_counts(ALLOC_OURS),
                                  .all = alloc_hook_counts(ALLOC_ALL),
                                  .resident_kb = resident_kb()};
}

static void compare(struct memory_watch *w)
{
    long off = w->last.all.live - w->first.all.live;
    long off_bytes = w->last.all.live_bytes - w->first.all.live_bytes;

    if (labs(off) > labs(w->live_off))
        w->live_off = off;
    if (labs(off_bytes) > labs(w->live_off_bytes))
        w->live_off_bytes = off_bytes;
}

static void watch(struct sim_run *run, const struct ttf_progress *progress)
{
    struct memory_watch *w = (struct memory_watch *)run;

    switch (progress->kind) {
    case TTF_PROGRESS_ARMED:
        alloc_hook_watch_sites(true);
        w->armed = look();
        break;
    case TTF_PROGRESS_EVENT:
        w->events++;
        break;
    case TTF_PROGRESS_SLOT:
        w->last = look();
        if (w->slots++ == 0)
            w->first = w->last;
        if (w->slots == MEMORY_EARLY_SLOT)
            w->early = w->last;
        compare(w);
        if (progress->index + 1 == run->plan.count)
            alloc_hook_watch_sites(false); /* sealing may allocate */
        break;
    default:
        break;
    }
}

void memory_watch_init(struct memory_watch *w)
{
    memset(w, 0, sizeof(*w));
    sim_run_init(&w->run);
    w->run.on_progress = watch;
    w->run.plain_disk = true;
}

/* Dark and flat of this box, beside the dataset. */
static void calibrate(struct sim_run *run)
{
    struct ttf_calibration calibration;
    struct ttf_scene white;
    struct ttf_box box;
    struct ttf_guided_config config = {
        .box = &box, .shot = &run->plan.shots[0], .mains_hz = 50, .frames = 8, .reflectance = 0.9};
    struct ttf_sim_config even = run->config;
    struct ttf_err err = {0};
    int r;

    even.margin_reflectance = 0.9;
    even.n_faults = 0;
    ttf_calibration_init(&calibration);
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&even, &white, &box, NULL), 0);
    r = ttf_guided_dark(&config, &calibration, &err);
    if (r == 0)
        r = ttf_guided_flat(&config, &calibration, &err);
    if (r < 0)
        print_error("calibration: %s: %s\n", err.where, err.what);
    assert_int_equal(r, 0);
    ttf_box_destroy(&box);
    snprintf(calibration_folder, sizeof(calibration_folder), "%s/calibration", run->folder);
    assert_int_equal(ttf_calibration_save(&calibration, ttf_io_posix(), calibration_folder, &err),
                     0);
    ttf_calibration_free(&calibration);
    run->calibration = calibration_folder;
}

void memory_watch_rich(struct memory_watch *w, int64_t slots)
{
    struct ttf_plan *plan = &w->run.plan;
    struct ttf_plan_shot *first = &plan->shots[0], *second = &plan->shots[1];

    plan->count = slots;
    plan->keep = TTF_KEEP_BOTH;
    plan->reference = (struct ttf_region){.x = 8, .y = 8, .width = 16, .height = 8};
    first->average = 3;
    *second = *first;
    plan->n_shots = 2;
    strcpy(second->stream, "side");
    strcpy(second->levels[0].lamp, "right");
    second->average = 1;
    second->n_brackets = 3;
    second->brackets[0] = 0.5;
    second->brackets[1] = 1;
    second->brackets[2] = 2;
    calibrate(&w->run);
}

static void at_random(struct memory_watch *w, enum ttf_fault_kind kind, uint32_t per_million)
{
    sim_run_fault(&w->run, kind, 0)->rate_per_million = per_million;
}

void memory_watch_faults(struct memory_watch *w)
{
    at_random(w, TTF_FAULT_FRAME_CORRUPT, 30000);
    at_random(w, TTF_FAULT_FRAME_MISSING, 20000);
    at_random(w, TTF_FAULT_FRAME_SHORT, 10000);
    at_random(w, TTF_FAULT_WRONG_SETTINGS, 20000);
    at_random(w, TTF_FAULT_LAMP_DEAD, 20000);
    at_random(w, TTF_FAULT_SENSOR_GONE, 50000);
    at_random(w, TTF_FAULT_DOOR_OPEN, 50000);
    at_random(w, TTF_FAULT_CAMERA_HANG, 20000);
    for (int i = 1; i <= 8; i++)
        sim_run_fault(&w->run, TTF_FAULT_CLOCK_STEP, i * 11 * TTF_NS_PER_MIN)->amount =
            i % 2 ? 5 : -5;
}

static double seconds(void)
{
    struct timespec ts;

    clock_gettime(CLOCK_MONOTONIC, &ts);
    return (double)ts.tv_sec + (double)ts.tv_nsec / 1e9;
}

static void print_sample(const char *when, const struct memory_sample *s)
{
    print_message(
        "%-12s ours: %ld blocks, %ld bytes; all: %ld blocks, %ld bytes; resident %ld KB\n", when,
        s->ours.live, s->ours.live_bytes, s->all.live, s->all.live_bytes, s->resident_kb);
}

void memory_watch_run(struct memory_watch *w)
{
    double began = seconds();
    int64_t n = w->run.plan.count;

    assert_int_equal(sim_run_boot(&w->run), 0);
    began = seconds() - began;
    print_message(
        "%lld slots and %lld events in %.1f s; after arming we allocated %ld times, "
        "libraries %ld times\n",
        (long long)w->slots, (long long)w->events, began, w->last.ours.calls - w->armed.ours.calls,
        (w->last.all.calls - w->last.ours.calls) - (w->armed.all.calls - w->armed.ours.calls));
    print_sample("armed", &w->armed);
    print_sample("slot 1", &w->first);
    print_sample("slot 10", &w->early);
    print_sample("the last", &w->last);
    if (w->last.ours.calls != w->armed.ours.calls)
        alloc_hook_print_sites(stdout);
    assert_int_equal(w->slots, n);
    assert_true(w->run.result.sealed);
}

void memory_watch_finish(struct memory_watch *w)
{
    sim_run_finish(&w->run);
}
