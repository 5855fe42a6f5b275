/* SPDX-License-Identifier: Apache-2.0 */
/* test_idle.c: the owner of the devices, between runs: what is decided is begun, however many look through the camera. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "idle.h"
#include "parts.h"
#include "view.h"

#define VIEWERS 3
#define LONG_NS (60 * TTF_NS_PER_S) /* longer than anything here takes */

struct fixture {
    struct daemon d;
    struct daemon_options options;
    volatile int stop;
    char folder[64];
    pthread_t viewers[VIEWERS];
    int enough; /* atomically: viewers go */
    int seen;   /* atomically: pictures that they had */
};

static void begin(struct fixture *f)
{
    static const struct ttf_board_set REAL[] = {
        {"sim.clock", "real"}, {"sim.sensor.width", "96px"}, {"sim.sensor.height", "64px"}};
    struct ttf_err err = {0};

    memset(f, 0, sizeof *f);
    f->options.stop = &f->stop;
    f->d.options = &f->options;
    f->d.io = ttf_io_posix();
    f->d.clock = ttf_clock_real_create();
    (void)snprintf(f->folder, sizeof f->folder, "/tmp/ttfbox-idle.XXXXXX");
    if (!f->d.clock || !mkdtemp(f->folder)) {
        fail_msg("no clock, or no folder");
        return;
    }
    if (ttf_board_load(BOARD, REAL, 3, &f->d.view_board, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    f->d.wake = ttf_gate_create(f->d.clock);
    f->d.shadow = shadow_create();
    f->d.calibrations = calibrations_create(f->d.io, f->d.clock, f->folder, "");
    f->d.workshop = workshop_create(f->d.clock, f->d.wake);
    assert_int_equal(orders_create(f->d.io, f->folder, "", "", &f->d.orders, &err), 0);
    workshop_open(f->d.workshop, true);
}

static void end(struct fixture *f)
{
    char path[128];

    view_close(&f->d, true);
    orders_destroy(f->d.orders);
    workshop_destroy(f->d.workshop);
    shadow_destroy(f->d.shadow);
    calibrations_destroy(f->d.calibrations);
    ttf_gate_destroy(f->d.wake);
    ttf_clock_destroy(f->d.clock);
    (void)snprintf(path, sizeof path, "%s/run.json", f->folder);
    (void)unlink(path);
    (void)snprintf(path, sizeof path, "%s/run.json.reserve", f->folder);
    (void)unlink(path);
    assert_int_equal(rmdir(f->folder), 0);
}

/* Pictures without an end, as a browser asks for them: the next one as soon as there is one. */
static void *look(void *ctx)
{
    struct fixture *f = ctx;
    const struct ttf_http_view view = {.exposure_ns = TTF_NS_PER_MS};

    while (!__atomic_load_n(&f->enough, __ATOMIC_RELAXED)) {
        struct workshop_job job = {.view = &view};

        if (workshop_ask(f->d.workshop, &job, NULL) == 0)
            (void)__atomic_add_fetch(&f->seen, 1, __ATOMIC_RELAXED);
        free(job.shown.jpeg);
    }
    return NULL;
}

static void begin_looking(struct fixture *f)
{
    for (int i = 0; i < VIEWERS; i++)
        assert_int_equal(pthread_create(&f->viewers[i], NULL, look, f), 0);
}

static void end_looking(struct fixture *f)
{
    __atomic_store_n(&f->enough, 1, __ATOMIC_RELAXED);
    workshop_open(f->d.workshop, false);
    for (int i = 0; i < VIEWERS; i++)
        (void)pthread_join(f->viewers[i], NULL);
}

static void *start_when_pictures_come(void *ctx)
{
    struct fixture *f = ctx;

    while (__atomic_load_n(&f->seen, __ATOMIC_RELAXED) < 5)
        (void)ttf_clock_wait_until(f->d.clock, ttf_clock_now_ns(f->d.clock) + TTF_NS_PER_MS);
    if (orders_start(f->d.orders, "week", "interval: 1h\n", "moss", NULL) < 0)
        return ctx;
    ttf_gate_open(f->d.wake);
    return NULL;
}

static void a_run_begins_while_others_look_through_the_camera_without_an_end(void **state)
{
    struct fixture f;
    pthread_t starter;
    void *failed = NULL;
    int64_t began_ns;

    (void)state;
    begin(&f);
    began_ns = ttf_clock_now_ns(f.d.clock);
    begin_looking(&f);
    assert_int_equal(pthread_create(&starter, NULL, start_when_pictures_come, &f), 0);
    idle(&f.d, orders_generation(f.d.orders), TTF_NS_NEVER, TTF_LED_IDLE);
    assert_true(ttf_clock_now_ns(f.d.clock) - began_ns < LONG_NS);
    end_looking(&f);
    (void)pthread_join(starter, &failed);
    assert_null(failed);
    end(&f);
}

static void a_wait_ends_on_time_while_others_look_through_the_camera(void **state)
{
    struct fixture f;
    int64_t began_ns;

    (void)state;
    begin(&f);
    begin_looking(&f);
    began_ns = ttf_clock_now_ns(f.d.clock);
    idle(&f.d, orders_generation(f.d.orders), 200 * TTF_NS_PER_MS, TTF_LED_STOPPED);
    assert_true(ttf_clock_now_ns(f.d.clock) - began_ns < LONG_NS);
    end_looking(&f);
    end(&f);
}

static void what_was_decided_before_the_wait_began_is_not_slept_through(void **state)
{
    struct fixture f;
    int64_t before, began_ns;

    (void)state;
    begin(&f);
    before = orders_generation(f.d.orders);
    assert_int_equal(orders_start(f.d.orders, "week", "interval: 1h\n", "moss", NULL), 0);
    began_ns = ttf_clock_now_ns(f.d.clock);
    idle(&f.d, before, LONG_NS, TTF_LED_IDLE);
    assert_true(ttf_clock_now_ns(f.d.clock) - began_ns < LONG_NS);
    end(&f);
}

/* An exposure of some seconds: its picture is under way when a run is asked for. */
static void *start_soon(void *ctx)
{
    struct fixture *f = ctx;

    (void)ttf_clock_wait_until(f->d.clock, ttf_clock_now_ns(f->d.clock) + 500 * TTF_NS_PER_MS);
    if (orders_start(f->d.orders, "week", "interval: 1h\n", "moss", NULL) < 0)
        return ctx;
    __atomic_store_n(&f->d.view_stop, 1, __ATOMIC_SEQ_CST); /* as the door does */
    ttf_gate_open(f->d.wake);
    return NULL;
}

static void *look_for_long(void *ctx)
{
    struct fixture *f = ctx;
    const struct ttf_http_view view = {.exposure_ns = 2 * TTF_NS_PER_S};
    struct workshop_job job = {.view = &view};

    f->seen = workshop_ask(f->d.workshop, &job, NULL);
    free(job.shown.jpeg);
    return NULL;
}

static void a_picture_that_takes_its_time_ends_when_a_run_is_asked_for(void **state)
{
    struct fixture f;
    pthread_t starter, viewer;
    void *failed = NULL;
    int64_t began_ns;

    (void)state;
    begin(&f);
    began_ns = ttf_clock_now_ns(f.d.clock);
    assert_int_equal(pthread_create(&viewer, NULL, look_for_long, &f), 0);
    assert_int_equal(pthread_create(&starter, NULL, start_soon, &f), 0);
    idle(&f.d, orders_generation(f.d.orders), TTF_NS_NEVER, TTF_LED_IDLE);
    assert_true(ttf_clock_now_ns(f.d.clock) - began_ns < LONG_NS / 2);
    workshop_open(f.d.workshop, false);
    (void)pthread_join(viewer, NULL);
    (void)pthread_join(starter, &failed);
    assert_null(failed);
    assert_int_equal(f.seen, -EBUSY);
    end(&f);
}

/* What it asks for is what ends the wait. */
static void *look_by_lamplight(void *ctx)
{
    struct fixture *f = ctx;
    struct ttf_http_view view = {.exposure_ns = TTF_NS_PER_MS, .n_lamps = 1};
    struct workshop_job job = {.view = &view};

    (void)snprintf(view.lamps[0].name, sizeof view.lamps[0].name, "left");
    view.lamps[0].level_permille = 1000;
    f->seen = workshop_ask(f->d.workshop, &job, NULL);
    free(job.shown.jpeg);
    return start_soon(ctx);
}

/* Every board's do; and who looks moves a lens, or waits for the first picture. */
static void lamps_that_warm_up_for_minutes_keep_no_picture_waiting(void **state)
{
    struct fixture f;
    pthread_t viewer;
    int64_t began_ns;

    (void)state;
    begin(&f);
    for (unsigned i = 0; i < f.d.view_board.sim.n_lamps; i++)
        f.d.view_board.sim.lamps[i].info.warm_up_ns = LONG_NS;
    began_ns = ttf_clock_now_ns(f.d.clock);
    assert_int_equal(pthread_create(&viewer, NULL, look_by_lamplight, &f), 0);
    idle(&f.d, orders_generation(f.d.orders), LONG_NS, TTF_LED_IDLE);
    assert_true(ttf_clock_now_ns(f.d.clock) - began_ns < LONG_NS / 2);
    workshop_open(f.d.workshop, false);
    (void)pthread_join(viewer, NULL);
    assert_int_equal(f.seen, 0);
    end(&f);
}

/* ---- steps of a calibration ---- */

static void at(const struct fixture *f, const char *name, char ret[128])
{
    (void)snprintf(ret, 128, "%.60s/%.60s", f->folder, name);
}

static int ask_for_dark(struct fixture *f, const char *name, struct ttf_err *err)
{
    struct ttf_http_calibrate what = {
        .part = TTF_CALIBRATION_DARK, .frames = 2, .exposure_ns = TTF_NS_PER_MS};

    (void)snprintf(what.name, sizeof what.name, "%s", name);
    return calibrations_ask(f->d.calibrations, &what, err);
}

/* One look of the owner, which takes as long as what it does. */
static void look_once(struct fixture *f)
{
    ttf_gate_open(f->d.wake);
    idle(&f->d, orders_generation(f->d.orders), 200 * TTF_NS_PER_MS, TTF_LED_IDLE);
}

static void says(struct fixture *f, const char *text)
{
    char *json = NULL;

    assert_int_equal(calibrations_show(f->d.calibrations, &json, NULL), 0);
    if (!strstr(json, text))
        fail_msg("no %s in %s", text, json);
    free(json);
}

static void forget_calibration(struct fixture *f, const char *name)
{
    static const char *const FILES[] = {"/calibration.json", "/dark.tif", ""};
    char file[64], path[128];

    for (unsigned i = 0; i < TTF_COUNT_OF(FILES); i++) {
        (void)snprintf(file, sizeof file, "calibrations/%s%s", name, FILES[i]);
        at(f, file, path);
        (void)remove(path);
    }
    at(f, "calibrations", path);
    (void)rmdir(path);
}

static int hear_manager(struct fixture *f, char path[128])
{
    struct sockaddr_un here = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);

    at(f, "notify", path);
    memcpy(here.sun_path, path, strlen(path) + 1);
    assert_true(fd >= 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&here, sizeof here), 0);
    f->d.manager = (struct manager){.socket = path, .watchdog_ns = 20 * TTF_NS_PER_S};
    return fd;
}

/* The longest time that it was told of, of those before it was back at its own; -1: it is not back. */
static int64_t longest_heard(int fd)
{
    int64_t longest = 0;
    char text[128];
    ssize_t n;

    while ((n = recv(fd, text, sizeof text - 1, MSG_DONTWAIT)) > 0) {
        int64_t usec;

        text[n] = '\0';
        if (strncmp(text, "WATCHDOG_USEC=", 14) != 0)
            continue;
        usec = strtoll(text + 14, NULL, 10);
        if (usec == 20000000 && longest > usec)
            return longest;
        if (usec > 20000000)
            assert_non_null(strstr(text, "\nWATCHDOG=1")); /* it counts from now on */
        longest = usec > longest ? usec : longest;
    }
    return -1;
}

static void the_manager_hears_how_long_a_step_of_a_calibration_may_take(void **state)
{
    struct fixture f;
    char path[128];
    int fd;

    (void)state;
    begin(&f);
    fd = hear_manager(&f, path);
    calibrations_open(f.d.calibrations);
    assert_int_equal(ask_for_dark(&f, "one", NULL), 0);
    look_once(&f);
    says(&f, "\"state\":\"done\"");
    assert_true(longest_heard(fd) > 120000000);
    (void)close(fd);
    (void)unlink(path);
    forget_calibration(&f, "one");
    end(&f);
}

static void the_manager_hears_how_long_a_picture_may_take(void **state)
{
    struct fixture f;
    pthread_t viewer;
    char path[128];
    int fd;

    (void)state;
    begin(&f);
    fd = hear_manager(&f, path);
    assert_int_equal(pthread_create(&viewer, NULL, look, &f), 0);
    assert_int_equal(ttf_gate_wait(f.d.wake, TTF_NS_NEVER), 0); /* it has asked */
    look_once(&f);
    __atomic_store_n(&f.enough, 1, __ATOMIC_RELAXED);
    workshop_open(f.d.workshop, false);
    (void)pthread_join(viewer, NULL);
    assert_true(longest_heard(fd) >= 120000000);
    (void)close(fd);
    (void)unlink(path);
    end(&f);
}

static void no_step_waits_while_a_run_has_the_devices_or_is_to_have_them(void **state)
{
    struct ttf_err err = {0};
    struct fixture f;

    (void)state;
    begin(&f);
    calibrations_open(f.d.calibrations);
    assert_int_equal(ask_for_dark(&f, "one", NULL), 0);
    calibrations_give_up(f.d.calibrations);
    says(&f, "\"state\":\"refused\"");
    assert_int_equal(ask_for_dark(&f, "one", &err), -EBUSY);
    assert_non_null(strstr(err.what, "a run has the devices"));
    calibrations_open(f.d.calibrations);
    look_once(&f); /* nothing is left over, to be done later with all lamps lit */
    says(&f, "\"state\":\"refused\"");
    end(&f);
}

/* Both are asked for while there is nothing of the name; before they are begun there is. */
static void what_is_there_when_a_step_begins_is_not_overwritten(void **state)
{
    char from[128], to[128];
    struct fixture f;
    struct stat st;

    (void)state;
    begin(&f);
    calibrations_open(f.d.calibrations);
    assert_int_equal(ask_for_dark(&f, "one", NULL), 0);
    look_once(&f);
    assert_int_equal(ask_for_dark(&f, "two", NULL), 0);
    at(&f, "calibrations/one", from);
    at(&f, "calibrations/two", to);
    assert_int_equal(rename(from, to), 0);
    look_once(&f);
    says(&f, "holds a dark already");
    forget_calibration(&f, "two");

    at(&f, "calibrations", to);
    assert_int_equal(mkdir(to, 0700), 0);
    at(&f, "calibrations/odd", to);
    assert_int_equal(mkdir(to, 0700), 0);
    at(&f, "calibrations/odd/calibration.json", to);
    assert_int_equal(symlink(to, to), 0); /* it is there, and nobody can say what it is */
    assert_int_equal(ask_for_dark(&f, "odd", NULL), 0);
    look_once(&f);
    says(&f, "\"state\":\"refused\"");
    assert_int_equal(lstat(to, &st), 0);
    assert_true(S_ISLNK(st.st_mode));
    forget_calibration(&f, "odd");
    end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_begins_while_others_look_through_the_camera_without_an_end),
        cmocka_unit_test(a_wait_ends_on_time_while_others_look_through_the_camera),
        cmocka_unit_test(what_was_decided_before_the_wait_began_is_not_slept_through),
        cmocka_unit_test(lamps_that_warm_up_for_minutes_keep_no_picture_waiting),
        cmocka_unit_test(a_picture_that_takes_its_time_ends_when_a_run_is_asked_for),
        cmocka_unit_test(the_manager_hears_how_long_a_step_of_a_calibration_may_take),
        cmocka_unit_test(the_manager_hears_how_long_a_picture_may_take),
        cmocka_unit_test(no_step_waits_while_a_run_has_the_devices_or_is_to_have_them),
        cmocka_unit_test(what_is_there_when_a_step_begins_is_not_overwritten),
    };

    (void)alarm(100); /* what waits for ever fails */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
