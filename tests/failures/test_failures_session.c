/* SPDX-License-Identifier: Apache-2.0 */
/* Every file operation of a whole capture fails, once or for good, in every way; and a disk that fills up (README.md). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crash/session_judge.h"
#include "faults.h"
#include "ttf/dataset/calibration.h"

#define LOG_ROOM 6000
#define SHARE    67
#define SLOTS    3
#define PIXELS   16 /* a side of the box's frame */

static bool everything; /* set once, by main */

/* What a session begins with: the disk, and who asks what. */
struct scene {
    bool second; /* storage */
    bool asks,
        later; /* people ask for something; the boot that fails is the second one, with a calibration */
};

static struct living living;

static void make_calibration(struct ttf_io *io)
{
    struct ttf_calibration calibration;

    ttf_calibration_init(&calibration);
    calibration.has_dark = true; /* of a camera that is as dark as it says everywhere */
    calibration.width = calibration.height = PIXELS;
    calibration.cfa = TTF_CFA_RGGB;
    calibration.dark_frames = 4;
    calibration.dark_settings.exposure_ns = 20 * TTF_NS_PER_MS;
    calibration.dark_settings.gain_milli = 1000;
    calibration.dark_temp_mdegc = INT32_MIN;
    calibration.black_level = 256;
    calibration.white_level = 4095;
    calibration.dark_offset_16 = calloc((size_t)PIXELS * PIXELS, sizeof(int32_t));
    assert_non_null(calibration.dark_offset_16);
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
    assert_int_equal(io->ops->mkdir(io, "/cal"), 0);
    assert_int_equal(ttf_calibration_save(&calibration, io, "/cal", NULL), 0);
    ttf_calibration_free(&calibration);
}

static void disk_init(struct model_disk *disk)
{
    struct ttf_io *io = &disk->io;

    model_disk_init(disk);
    assert_int_equal(io->ops->mkdir(io, "/data"), 0);
    assert_int_equal(io->ops->mkdir(io, SESSION_SECOND), 0);
    make_calibration(io);
    for (int i = 0; i < disk->n_names; i++) { /* the root's sync is not modelled */
        disk->names[i].kept = disk->names[i].seen;
        disk->names[i].dirty = false;
    }
}

/* What is asked; the first boot of a scene that fails later ends after its first slot. */
static void people_ask(struct session_box *s, const struct scene *scene)
{
    living_init(&living, &s->plan);
    living_ask(&living, TTF_ASK_NOTE, 0, 0);
    if (scene->later)
        living_ask(&living, TTF_ASK_STOP, 1, 0);
    living_ask(&living, TTF_ASK_INTERVAL, 1, 50 * TTF_NS_PER_S);
    living_ask(&living, TTF_ASK_NOTE, 1, 0);
    living_ask(&living, TTF_ASK_PAUSE, 2, 0);
    living_ask(&living, TTF_ASK_COUNT, 2, SLOTS + 1);
    session_box_live(s, &living);
}

static void append(struct ttf_io *io, const char *path, const char *text)
{
    int file = io->ops->open(io, path, TTF_IO_APPEND);

    assert_true(file >= 0);
    assert_int_equal(ttf_io_append_all(io, file, text, strlen(text)), 0);
    assert_int_equal(io->ops->close(io, file), 0);
}

/* As a kill in the middle of a slot's commit leaves it: repairing has something to do. */
static void leave_a_slot_half_done(struct ttf_io *io, int64_t index)
{
    static const char *const ends[] = {"", ".tmp"};
    char path[200];

    for (unsigned i = 0; i < 2; i++) {
        snprintf(path, sizeof(path), SESSION_PATH "/frames/main/%06lld.tif%s", (long long)index,
                 ends[i]);
        assert_int_equal(ttf_io_write_file(io, path, "half", 4, NULL), 0);
    }
    append(io, SESSION_PATH "/records.jsonl", "{\"type\":\"slot\",\"se");
    append(io, SESSION_PATH "/events.jsonl", "{\"type\":\"ev");
}

/* Up to the boot that is to fail. */
static void begin(const struct scene *scene, struct session_box *s, struct model_disk *disk)
{
    disk_init(disk);
    session_box_init(s, &disk->io, SLOTS, scene->second);
    if (scene->asks || scene->later)
        people_ask(s, scene);
    if (scene->later) {
        session_box_boot(s);
        session_look_whole(s);
        assert_string_equal(s->broken, "");
        assert_true(s->stopped);
        leave_a_slot_half_done(&disk->io, s->promise.n_slots);
        s->calibration_folder = "/cal";
        s->power_on_ns = s->ended_ns + TTF_NS_PER_MIN;
        session_box_go_on(s, 0, true);
    }
    model_disk_fail(disk, (struct model_fault){0});
}

/* The operations of a session on which nothing fails. */
static long clean_run(const struct scene *scene, struct model_call *log)
{
    static struct session_box s;
    struct model_disk disk;
    long n;

    begin(scene, &s, &disk);
    disk.log = log;
    disk.log_room = LOG_ROOM;
    session_box_boot(&s);
    n = disk.n;
    disk.log = NULL;
    session_look_whole(&s);
    assert_string_equal(s.broken, "");
    assert_true(!s.living || s.promise.plan == 2);
    model_disk_free(&disk);
    assert_true(n > 200 && n < LOG_ROOM);
    return n;
}

struct figures {
    long injections, whole, moved, lacking, stopped, refused, wrong;
};

static void wrong(struct figures *figures, const char *what, const char *text)
{
    if (figures->wrong++ < 20)
        print_error("%s: %s\n", what, text);
}

/* Resumed on a sound disk: what was acknowledged is there, and the run ends well. */
static void look_and_resume(const struct session_box *before, struct model_disk *disk,
                            const char *what, struct figures *figures)
{
    static struct session_box s;

    s = *before;
    s.io = &disk->io;
    s.power_on_ns = before->ended_ns + TTF_NS_PER_MIN;
    model_disk_fail(disk, (struct model_fault){0});
    session_look(&s, &before->promise);
    if (!s.broken[0]) {
        session_box_go_on(&s, 0, true);
        session_box_boot(&s);
        session_look_whole(&s);
    }
    if (s.broken[0])
        wrong(figures, what, s.broken);
    if (model_disk_open_handles(disk) != 0)
        wrong(figures, what, "the resumed run left a handle open");
}

static void judge_end(struct session_box *s)
{
    if (s->code < 0 && s->err.what[0] == '\0')
        session_box_break(s, "it stops (%d) and does not say why", s->code);
    else if (s->code < 0 && s->armed && s->alarms == 0)
        session_box_break(s, "it stops without an alarm: %s: %s", s->err.where, s->err.what);
    else if (s->code == 0 && s->promise.n_slots < session_box_count(s))
        session_box_break(s, "it ends well, with %d slots", (int)s->promise.n_slots);
}

static void count(struct figures *figures, const struct session_box *s)
{
    int64_t good = s->result.captured;

    figures->injections++;
    figures->moved += s->result.second_storage;
    figures->whole += s->code == 0 && good == session_box_count(s);
    figures->lacking += s->code == 0 && !s->result.second_storage && good < session_box_count(s);
    figures->stopped += s->code < 0 && s->armed;
    figures->refused += s->code < 0 && !s->armed;
}

static void one(const struct scene *scene, const struct fault_kind *kind, long at,
                const struct model_call *call, struct figures *figures)
{
    static struct session_box s;
    char what[300], dark_what[340];
    struct model_fault fault = kind->fault;
    struct model_disk disk, dark;

    fault_text(kind, at, call, what);
    begin(scene, &s, &disk);
    s.promise.troubled = true;
    fault.at = at;
    model_disk_fail(&disk, fault);
    session_box_boot(&s);
    count(figures, &s);
    judge_end(&s);
    if (s.broken[0])
        wrong(figures, what, s.broken);
    if (model_disk_open_handles(&disk) != 0)
        wrong(figures, what, "a handle was left open");
    model_disk_copy(&dark, &disk);
    model_disk_lose_power(&dark);
    look_and_resume(&s, &disk, what, figures);
    snprintf(dark_what, sizeof(dark_what), "%s, then a power cut", what);
    look_and_resume(&s, &dark, dark_what, figures);
    model_disk_free(&dark);
    model_disk_free(&disk);
}

static void each_operation_fails(const struct scene *scene)
{
    static struct model_call log[LOG_ROOM];
    long n = clean_run(scene, log), all_wrong = 0;

    for (unsigned i = 0; i < n_fault_kinds; i++) {
        struct figures figures = {0};

        for (long at = 1; at <= n; at++)
            if (fault_fits(&fault_kinds[i], &log[at - 1]) &&
                (everything || (at + 5 * (long)i) % SHARE == 0))
                one(scene, &fault_kinds[i], at, &log[at - 1], &figures);
        print_message(
            "%-28s %5ld injected: %ld captured all, %ld lack something, %ld in the second "
            "storage, %ld stopped, %ld did not begin\n",
            fault_kinds[i].name, figures.injections, figures.whole, figures.lacking, figures.moved,
            figures.stopped, figures.refused);
        all_wrong += figures.wrong;
    }
    assert_int_equal(all_wrong, 0);
}

static void a_capture_loses_nothing_whatever_fails(void **state)
{
    (void)state;
    each_operation_fails(&(struct scene){0});
}

static void a_capture_with_a_second_storage_loses_nothing_whatever_fails(void **state)
{
    (void)state;
    each_operation_fails(&(struct scene){.second = true});
}

static void a_capture_that_is_asked_for_things_keeps_what_it_answered_whatever_fails(void **state)
{
    (void)state;
    each_operation_fails(&(struct scene){.asks = true});
}

static void a_capture_that_is_gone_on_with_loses_nothing_whatever_fails(void **state)
{
    (void)state;
    each_operation_fails(&(struct scene){.later = true});
}

static void one_gone_on_with_that_may_move_loses_nothing_whatever_fails(void **state)
{
    (void)state;
    each_operation_fails(&(struct scene){.later = true, .second = true});
}

/* ---- a disk that fills up ---- */

#define PREVIEWS      6
#define PREVIEW_BYTES 2000
#define PREVIEW_PATH  SESSION_PATH "/preview/main/%06d.jpg"

static void make_previews(struct ttf_io *io)
{
    static const char bytes[PREVIEW_BYTES];
    char path[100];

    assert_int_equal(io->ops->mkdir(io, SESSION_PATH "/preview"), 0);
    assert_int_equal(io->ops->mkdir(io, SESSION_PATH "/preview/main"), 0);
    for (int i = 0; i < PREVIEWS; i++) {
        snprintf(path, sizeof(path), PREVIEW_PATH, i);
        assert_int_equal(ttf_io_write_file(io, path, bytes, sizeof(bytes), NULL), 0);
    }
}

/* How many there are, and whether those are the newest. */
static int previews_left(struct model_disk *disk, bool *ret_newest)
{
    char path[100];
    int left = 0;

    *ret_newest = true;
    for (int i = 0; i < PREVIEWS; i++) {
        snprintf(path, sizeof(path), PREVIEW_PATH, i);
        if (model_disk_has(disk, path))
            left++;
        else if (left > 0)
            *ret_newest = false;
    }
    return left;
}

/* Some room is left, and the run goes on in it: previews go first; what is lost then is slots, with their reason. */
static int in_so_much_room(const struct session_box *before, struct model_disk *with_previews,
                           int64_t room, struct figures *figures)
{
    static struct session_box s;
    struct model_disk disk;
    char what[60];
    bool newest;
    int left;

    snprintf(what, sizeof(what), "with %lld bytes of room", (long long)room);
    model_disk_copy(&disk, with_previews);
    disk.capacity_bytes = model_disk_used(&disk) + room;
    s = *before;
    s.io = &disk.io;
    s.plan.count = 8;
    s.promise.sealed = false;
    s.promise.maybe_sealed = s.promise.troubled = true;
    s.power_on_ns = before->ended_ns + TTF_NS_PER_MIN;
    session_box_boot(&s);
    count(figures, &s);
    judge_end(&s);
    left = previews_left(&disk, &newest);
    if (!newest)
        session_box_break(&s, "a newer preview went before an older one");
    if (left > 0 && s.armed &&
        (s.code < 0 || s.result.missed + s.result.power + s.result.captured != s.plan.count))
        session_box_break(&s, "%d previews stayed, and a slot did not: %s", left, s.err.what);
    if (s.broken[0])
        wrong(figures, what, s.broken);
    disk.capacity_bytes = 0;
    look_and_resume(&s, &disk, what, figures);
    model_disk_free(&disk);
    return left;
}

static void on_a_disk_that_fills_up_previews_go_first_and_nothing_committed(void **state)
{
    static struct session_box s;
    struct figures figures = {0};
    struct model_disk disk;
    int left = 0;

    (void)state;
    disk_init(&disk);
    session_box_init(&s, &disk.io, 1, false);
    session_box_boot(&s);
    session_look_whole(&s);
    assert_string_equal(s.broken, "");
    make_previews(&disk.io);
    for (int64_t room = 0; room < 40000; room += everything ? 100 : 2500)
        left = in_so_much_room(&s, &disk, room, &figures);
    print_message(
        "%ld sizes: %ld captured all, %ld lack something, %ld stopped, %ld did not begin; "
        "%d previews left in the largest\n",
        figures.injections, figures.whole, figures.lacking, figures.stopped, figures.refused, left);
    model_disk_free(&disk);
    assert_int_equal(figures.wrong, 0);
}

/* "all": every operation fails in every way; else a share of it, in some seconds. */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_capture_loses_nothing_whatever_fails),
        cmocka_unit_test(a_capture_with_a_second_storage_loses_nothing_whatever_fails),
        cmocka_unit_test(a_capture_that_is_asked_for_things_keeps_what_it_answered_whatever_fails),
        cmocka_unit_test(a_capture_that_is_gone_on_with_loses_nothing_whatever_fails),
        cmocka_unit_test(one_gone_on_with_that_may_move_loses_nothing_whatever_fails),
        cmocka_unit_test(on_a_disk_that_fills_up_previews_go_first_and_nothing_committed),
    };

    everything = argc > 1 && strcmp(argv[1], "all") == 0;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
