/* SPDX-License-Identifier: Apache-2.0 */
/* libcamera in a process of its own: what it says comes over whole; it may end, hang or be gone, and the next one is as good as the first. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "fake_module.h"
#include "remote.h"

#define PATIENCE_MS 5000

struct rig {
    struct lc_system system;
    struct lc_handle *handle;
    struct ttf_err err;
    int descriptors;
};

static int descriptors(void)
{
    DIR *folder = opendir("/proc/self/fd");
    int n = 0;

    assert_non_null(folder);
    while (readdir(folder)) /* NOLINT(concurrency-mt-unsafe): a folder of its own */
        n++;
    (void)closedir(folder);
    return n;
}

/* Of our own children: the process that has libcamera. */
static pid_t host_process(void)
{
    char path[64], line[64] = "";
    FILE *file;

    (void)snprintf(path, sizeof(path), "/proc/self/task/%d/children", (int)getpid());
    file = fopen(path, "re");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof(line), file));
    (void)fclose(file);
    return (pid_t)strtol(line, NULL, 10);
}

static int create(struct rig *rig, const char *host, const char *module, int patience_ms)
{
    rig->err = (struct ttf_err){0};
    return lc_remote_create(host, module, patience_ms, &rig->system, &rig->err);
}

static void open_camera(struct rig *rig)
{
    const struct lc_ask ask = {.fourcc = 7, .width = 64, .height = 48, .buffers = 3};
    struct lc_granted granted;
    struct lc_identity id;
    unsigned n;

    assert_int_equal(rig->system.ops->begin(rig->system.ctx), 0);
    assert_int_equal(rig->system.ops->list(rig->system.ctx, 0, &id), 1);
    assert_string_equal(id.id, "/fake/camera");
    assert_int_equal(rig->system.ops->hold(rig->system.ctx, id.id, &rig->handle), 0);
    assert_int_equal(rig->system.ops->configure(rig->handle, &ask, &granted), 0);
    assert_int_equal(granted.bytes, FAKE_BYTES);
    assert_int_equal(rig->system.ops->allocate(rig->handle, 3, &n), 0);
    assert_int_equal(n, 3);
    assert_int_equal(rig->system.ops->start(rig->handle, &(struct lc_settings){0}), 0);
}

static void close_camera(struct rig *rig)
{
    rig->system.ops->let_go(rig->handle);
    rig->handle = NULL;
    rig->system.ops->end(rig->system.ctx);
}

static int setup(void **state)
{
    struct rig *rig = calloc(1, sizeof(*rig));

    assert_non_null(rig);
    rig->descriptors = descriptors();
    assert_int_equal(create(rig, TEST_HOST, TEST_MODULE, PATIENCE_MS), 0);
    open_camera(rig);
    *state = rig;
    return 0;
}

/* Whatever happened, nothing is left: no descriptor, no process, not even one that waits to be asked for. */
static int teardown(void **state)
{
    struct rig *rig = *state;

    if (rig->handle)
        close_camera(rig);
    rig->system.destroy(rig->system.ctx);
    assert_int_equal(descriptors(), rig->descriptors);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
    free(rig);
    return 0;
}

static int ask_frame(struct rig *rig, unsigned buffer, double exposure_us)
{
    const struct lc_settings settings = {.set = 1u << LC_EXPOSURE, .value = {{exposure_us, 0}}};

    return rig->system.ops->queue(rig->handle, buffer, &settings);
}

/* What take says once there is something to say, or after 5 s. */
static int take(struct rig *rig, struct lc_done *ret)
{
    struct pollfd fd = {.fd = rig->system.ops->descriptor(rig->handle), .events = POLLIN};

    assert_int_equal(poll(&fd, 1, 5000), 1);
    return rig->system.ops->take(rig->handle, ret);
}

static void a_frame_comes(struct rig *rig, unsigned buffer, double exposure_us)
{
    const unsigned char *at;
    struct lc_done done;
    size_t length;

    assert_int_equal(ask_frame(rig, buffer, exposure_us), 0);
    assert_int_equal(take(rig, &done), 0);
    assert_int_equal(done.buffer, buffer);
    assert_int_equal(done.bytes, FAKE_BYTES);
    assert_true(done.told.value[LC_EXPOSURE][0] == exposure_us);
    assert_int_equal(rig->system.ops->buffer(rig->handle, buffer, (const void **)&at, &length), 0);
    assert_int_equal(length, FAKE_BYTES);
    for (unsigned i = 0; i < length; i++)
        assert_int_equal(at[i], (unsigned)exposure_us & 0xff);
}

/* ---- what is said comes over ---- */

static void what_it_says_comes_over_whole(void **state)
{
    struct rig *rig = *state;
    const struct lc_ops *ops = rig->system.ops;
    struct lc_ask much = {.width = 65};
    struct lc_granted granted;
    struct lc_identity id;
    struct lc_limits limits;
    struct lc_offer offer;
    struct lc_handle *other;
    char text[160];

    assert_string_equal(ops->version(rig->system.ctx), "9.8.7");
    ops->complaint(rig->system.ctx, text, sizeof(text));
    assert_string_equal(text, "nothing answers on the bus");
    assert_int_equal(ops->list(rig->system.ctx, 1, &id), 0);
    assert_int_equal(ops->hold(rig->system.ctx, "/fake/camera", &other), -EBUSY);
    assert_int_equal(ops->offer(rig->handle, LC_PROCESSED, 1, &offer), 1);
    assert_int_equal(offer.fourcc, 0x20363153u);
    assert_int_equal(ops->offer(rig->handle, LC_RAW, 2, &offer), 0);
    assert_int_equal(ops->limits(rig->handle, &limits), 0);
    assert_true(limits.max[LC_EXPOSURE] == 2000000);
    assert_int_equal(ops->configure(rig->handle, &much, &granted), -EINVAL);
}

static void frames_come_with_their_settings_and_pixels(void **state)
{
    struct rig *rig = *state;
    struct lc_done done;

    assert_int_equal(rig->system.ops->take(rig->handle, &done), -EAGAIN);
    for (unsigned i = 0; i < 30; i++)
        a_frame_comes(rig, i % 3, 1000.0 + i);
    assert_int_equal(rig->system.ops->take(rig->handle, &done), -EAGAIN);
}

static void a_frame_of_before_a_stop_is_none_of_after(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(ask_frame(rig, 0, 50), 0);
    assert_int_equal(rig->system.ops->stop(rig->handle), 0);
    assert_int_equal(rig->system.ops->start(rig->handle, &(struct lc_settings){0}), 0);
    a_frame_comes(rig, 1, 60);
}

/* ---- what goes wrong ---- */

static void a_camera_that_is_gone_is_told_to_whoever_waits(void **state)
{
    struct rig *rig = *state;
    struct lc_done done;

    assert_int_equal(ask_frame(rig, 0, FAKE_GOES_US), 0);
    assert_int_equal(take(rig, &done), -ENODEV);
    assert_int_equal(rig->system.ops->take(rig->handle, &done), -ENODEV);
    close_camera(rig);
    open_camera(rig);
    a_frame_comes(rig, 0, 90);
}

static void one_that_ends_is_a_camera_that_is_gone_and_another_takes_its_place(void **state)
{
    struct rig *rig = *state;
    struct lc_done done;
    char text[160];

    for (unsigned i = 0; i < 3; i++) {
        a_frame_comes(rig, 0, 70.0 + i);
        assert_int_equal(ask_frame(rig, 1, FAKE_DIES_US), -ENODEV);
        assert_int_equal(take(rig, &done), -ENODEV);
        assert_int_equal(ask_frame(rig, 2, 80), -ENODEV);
        assert_int_equal(rig->system.ops->stop(rig->handle), -ENODEV);
        rig->system.ops->complaint(rig->system.ctx, text, sizeof(text));
        assert_string_equal(text, "its process has ended");
        close_camera(rig);
        open_camera(rig);
    }
    a_frame_comes(rig, 2, 90);
}

static void one_that_is_killed_while_nobody_asks_is_heard_of(void **state)
{
    struct rig *rig = *state;
    struct lc_done done;

    assert_int_equal(kill(host_process(), SIGKILL), 0);
    assert_int_equal(take(rig, &done), -ENODEV);
}

static void one_that_hangs_is_given_up_in_time(void **state)
{
    struct rig *rig = *state;

    close_camera(rig);
    rig->system.destroy(rig->system.ctx);
    assert_int_equal(create(rig, TEST_HOST, TEST_MODULE, 3000), 0);
    open_camera(rig);
    assert_int_equal(ask_frame(rig, 0, FAKE_HANGS_US), -ENODEV);
    close_camera(rig);
    open_camera(rig);
    a_frame_comes(rig, 0, 90);
}

/* systemd tells all processes of a service to end, a terminal all of the foreground; the program ends its slot first. */
static void told_to_end_it_stays_for_the_slot_that_is_under_way(void **state)
{
    struct rig *rig = *state;
    pid_t host = host_process();

    assert_int_not_equal(getpgid(host), getpgid(0));
    assert_int_equal(kill(host, SIGTERM), 0);
    assert_int_equal(kill(host, SIGINT), 0);
    assert_int_equal(kill(host, SIGHUP), 0);
    a_frame_comes(rig, 0, 90);
    assert_int_equal(host_process(), host);
}

/* ---- without it ---- */

static void what_cannot_be_loaded_is_said_with_what_to_do(void **state)
{
    struct rig rig = {0};
    const int before = descriptors();

    assert_int_equal(create(&rig, TEST_HOST, "/nonexistent/module.so", PATIENCE_MS), -ENOTSUP);
    assert_non_null(strstr(rig.err.what, "cannot be loaded"));
    assert_non_null(strstr(rig.err.what, "No such file"));
    assert_non_null(strstr(rig.err.hint, "reinstall"));
    assert_int_equal(create(&rig, TEST_HOST, TEST_OLD_MODULE, PATIENCE_MS), -ENOTSUP);
    assert_non_null(strstr(rig.err.what, "another version of ttfbox"));
    assert_int_equal(create(&rig, "/nonexistent/host", TEST_MODULE, PATIENCE_MS), -ENOTSUP);
    assert_non_null(strstr(rig.err.what, "No such file"));
    assert_int_equal(create(&rig, "/bin/true", TEST_MODULE, PATIENCE_MS), -ENOTSUP);
    assert_non_null(strstr(rig.err.what, "ended at once"));
    assert_int_equal(descriptors(), before);
}

/* One that nobody has waited for yet counts. */
static bool is_gone(pid_t process)
{
    char path[64], line[256];
    const char *state = NULL;
    FILE *file;

    (void)snprintf(path, sizeof(path), "/proc/%d/stat", (int)process);
    file = fopen(path, "re");
    if (!file)
        return true;
    if (fgets(line, sizeof(line), file))
        state = strrchr(line, ')');
    (void)fclose(file);
    return !state || state[2] == 'Z';
}

static void assert_gone(pid_t process)
{
    for (int i = 0; i < 500 && !is_gone(process); i++)
        (void)poll(NULL, 0, 10);
    assert_true(is_gone(process));
}

static void it_ends_with_the_program_that_started_it(void **state)
{
    struct rig rig = {0};
    int ends[2];
    pid_t child, host = 0;

    assert_int_equal(pipe(ends), 0);
    child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (create(&rig, TEST_HOST, TEST_MODULE, PATIENCE_MS) == 0)
            host = host_process();
        (void)!write(ends[1], &host, sizeof(host));
        _exit(0);
    }
    assert_int_equal(read(ends[0], &host, sizeof(host)), sizeof(host));
    assert_true(host > 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_gone(host);
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void one_that_hangs_ends_with_its_program_too(void **state)
{
    struct rig rig = {0};
    int ends[2];
    pid_t child, host = 0;

    assert_int_equal(pipe(ends), 0);
    child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (create(&rig, TEST_HOST, TEST_MODULE, 60000) < 0)
            _exit(1);
        open_camera(&rig);
        host = host_process();
        (void)!write(ends[1], &host, sizeof(host));
        (void)ask_frame(&rig, 0, FAKE_HANGS_US);
        _exit(2);
    }
    assert_int_equal(read(ends[0], &host, sizeof(host)), sizeof(host));
    (void)poll(NULL, 0, 300); /* it is asked meanwhile */
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_gone(host);
    (void)close(ends[0]);
    (void)close(ends[1]);
}

#define ON_RIG(f) cmocka_unit_test_setup_teardown(f, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_RIG(what_it_says_comes_over_whole),
        ON_RIG(frames_come_with_their_settings_and_pixels),
        ON_RIG(a_frame_of_before_a_stop_is_none_of_after),
        ON_RIG(a_camera_that_is_gone_is_told_to_whoever_waits),
        ON_RIG(one_that_ends_is_a_camera_that_is_gone_and_another_takes_its_place),
        ON_RIG(one_that_is_killed_while_nobody_asks_is_heard_of),
        ON_RIG(one_that_hangs_is_given_up_in_time),
        ON_RIG(told_to_end_it_stays_for_the_slot_that_is_under_way),
        cmocka_unit_test(what_cannot_be_loaded_is_said_with_what_to_do),
        cmocka_unit_test(it_ends_with_the_program_that_started_it),
        cmocka_unit_test(one_that_hangs_ends_with_its_program_too),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
