/* SPDX-License-Identifier: Apache-2.0 */
/* rig_camera_cases.c: slots as capture takes them (again, then the ladder), and vivid's faults in one of them. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "rig_camera.h"
#include "ttf/base/time.h"

#define INTERVAL_NS  (TTF_NS_PER_S / 2)
#define RECOVERED_NS (10 * TTF_NS_PER_S)
#define SLOTS        12
#define WRONG_SLOT   4

enum act {
    ACT_CONTROL,
    ACT_UNBIND, /* and bound again after BACK_NS */
    ACT_UNBIND_HELD /* the same, with the old node held open elsewhere: it comes back under another number */
};

#define BACK_NS (2 * TTF_NS_PER_S)

static const struct fault {
    const char *name;
    enum act act;
    uint32_t control;
    int value, after; /* after: the control's value from the next slot on; -1: as it is */
    unsigned slots;
    unsigned may_lose;
    bool restart; /* shows only when the stream is set going: do so */
} FAULTS[] = {
    {"disconnect", ACT_CONTROL, VIVID_DISCONNECT, 1, -1, SLOTS, 1, false},
    {"error-flag", ACT_CONTROL, VIVID_ERROR_FLAG, 1, -1, SLOTS, 1, false},
    {"reqbufs", ACT_CONTROL, VIVID_REQBUFS, 1, -1, SLOTS, 1, true},
    {"qbuf", ACT_CONTROL, VIVID_QBUF, 1, -1, SLOTS, 1, false},
    {"streamon", ACT_CONTROL, VIVID_STREAMON, 1, -1, SLOTS, 1, true},
    {"fatal", ACT_CONTROL, VIVID_FATAL, 1, -1, SLOTS, 1, false},
    {"dropped-30", ACT_CONTROL, VIVID_DROPPED, 30, -1, 40, 1, false},
    {"unbind", ACT_UNBIND, 0, 0, -1, 3 * SLOTS, 20, false},
    {"unbind-renumbered", ACT_UNBIND_HELD, 0, 0, -1, 3 * SLOTS, 20, false},
};

struct run {
    struct ttf_clock *clock;
    struct ttf_camera *camera;
    unsigned lost, again, recoveries, gaps;
    int64_t trouble_ns; /* since when nothing comes; 0: all is well */
    int64_t longest_ns; /* of those */
    enum ttf_camera_recovery step;
    char said[512];
};

static int64_t now_ns(struct run *run)
{
    return ttf_clock_now_ns(run->clock);
}

/* One exposure; 0 for a good frame. */
static int attempt(struct run *run, int64_t middle_ns)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(run->camera);
    struct ttf_exposure asked = {.exposure_ns = caps->exposure_max_ns / 4, .gain_milli = 1000};
    struct ttf_camera_set set = {.settings = &asked, .n = 1, .middle_ns = middle_ns};
    struct ttf_frame *frame = NULL;
    struct ttf_err err = {0};
    int64_t until = now_ns(run) + caps->lead_ns + 3 * caps->frame_period_ns + TTF_NS_PER_S / 2;
    int r = ttf_camera_submit(run->camera, &set, &err);

    if (r == 0)
        r = ttf_camera_next(run->camera, until, &frame, &err);
    if (r < 0 || !frame) {
        (void)ttf_err_text(&err, run->said, sizeof(run->said));
        ttf_camera_cancel(run->camera);
        return r < 0 ? r : -EIO;
    }
    if (frame->flags & (TTF_FRAME_ERROR | TTF_FRAME_SHORT)) {
        (void)snprintf(run->said, sizeof(run->said), "a frame in error");
        r = -EBADMSG;
    }
    ttf_camera_release(run->camera, frame);
    return r;
}

/* As capture does it: once more, then from where the ladder was left, until it is too late for this slot. */
static bool slot(struct run *run, int64_t due_ns)
{
    int64_t give_up = due_ns + INTERVAL_NS * 3 / 4;
    int r = attempt(run, due_ns);

    if (r < 0 && r != -ENODEV && r != -EIO) {
        run->again++;
        r = attempt(run, 0);
    }
    if (r < 0 && run->trouble_ns == 0)
        run->trouble_ns = now_ns(run);
    while (r < 0) {
        struct ttf_err err = {0};
        char text[512];

        r = ttf_camera_recover(run->camera, run->step, &err);
        run->recoveries++;
        if (r < 0)
            printf("    %s: %s\n", ttf_camera_recovery_name(run->step),
                   ttf_err_text(&err, text, sizeof(text)));
        if (run->step < TTF_CAMERA_REOPEN)
            run->step++;
        r = r < 0 ? r : attempt(run, 0);
        if (r < 0 && now_ns(run) >= give_up)
            return false;
        if (r < 0 && run->step == TTF_CAMERA_REOPEN)
            ttf_clock_wait_until(run->clock, now_ns(run) + TTF_NS_PER_S / 10);
    }
    if (run->trouble_ns != 0 && now_ns(run) - run->trouble_ns > run->longest_ns)
        run->longest_ns = now_ns(run) - run->trouble_ns;
    run->trouble_ns = 0;
    run->step = TTF_CAMERA_REQUEUE;
    return now_ns(run) < due_ns + INTERVAL_NS;
}

static int write_to(const char *path, const char *text)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    ssize_t n;

    if (fd < 0)
        return -errno;
    n = write(fd, text, strlen(text));
    (void)close(fd);
    return n < 0 ? -errno : 0;
}

static void *bind_later(void *arg)
{
    struct run *run = arg;

    ttf_clock_wait_until(run->clock, now_ns(run) + BACK_NS);
    if (write_to("/sys/bus/platform/drivers/vivid/bind", "vivid.0") < 0)
        printf("    vivid.0 cannot be bound\n");
    return NULL;
}

/* 0 or what is wrong with the case itself. */
static int strike(struct run *run, const struct fault *fault, pthread_t *thread, int *held)
{
    struct ttf_v4l2_info info;
    int r;

    ttf_v4l2_camera_info(run->camera, &info);
    if (fault->act == ACT_CONTROL) {
        r = rig_set(fault->control, fault->value);
        if (r == 0 && fault->restart) {
            ttf_camera_stop(run->camera);
            r = ttf_camera_start(run->camera, NULL);
            printf("    starting anew: %d\n", r);
            if (r == 0)
                return -EINVAL; /* it did not bite */
            r = 0;
        }
        return r;
    }
    if (fault->act == ACT_UNBIND_HELD)
        *held = open(info.device, O_RDWR | O_CLOEXEC | O_NONBLOCK);
    r = write_to("/sys/bus/platform/drivers/vivid/unbind", "vivid.0");
    return r < 0 ? r : -pthread_create(thread, NULL, bind_later, run);
}

static int begin(struct run *run)
{
    struct ttf_camera_mode native = {0};
    struct ttf_err err = {0};
    char text[512];
    int r;

    run->clock = ttf_clock_real_create();
    if (!run->clock)
        return -errno;
    r = rig_camera("RGGB", run->clock, &run->camera, &err);
    if (r == 0)
        r = ttf_camera_configure(run->camera, &native, NULL, &err);
    if (r == 0)
        r = ttf_camera_start(run->camera, &err);
    if (r == 0)
        r = attempt(run, 0);
    if (r < 0)
        printf("    %s %s\n", ttf_err_text(&err, text, sizeof(text)), run->said);
    return r;
}

static void end(struct run *run)
{
    ttf_camera_destroy(run->camera);
    ttf_clock_destroy(run->clock);
}

static void all_slots(struct run *run, const struct fault *fault, unsigned slots, pthread_t *thread,
                      int *held)
{
    int64_t first = now_ns(run) + TTF_NS_PER_S;

    for (unsigned i = 0; i < slots; i++) {
        int64_t due = first + (int64_t)i * INTERVAL_NS;
        int64_t lead = 4 * ttf_camera_caps(run->camera)->frame_period_ns;

        if (now_ns(run) > due) { /* it came while another was being brought back */
            run->lost++;
            continue;
        }
        ttf_clock_wait_until(run->clock, due - lead);
        if (fault && i == WRONG_SLOT) {
            int r = strike(run, fault, thread, held);

            if (r < 0) {
                printf("    the fault cannot be made: %d\n", r);
                run->lost = UINT_MAX;
                return;
            }
        }
        if (!slot(run, due)) {
            printf("    slot %u lost: %s\n", i, run->said);
            run->lost++;
        }
    }
}

int rig_case(const char *name)
{
    struct run run = {0};
    struct ttf_v4l2_info before, after;
    const struct fault *fault = NULL;
    pthread_t thread = 0;
    int held = -1;
    bool good;

    for (unsigned i = 0; i < TTF_COUNT_OF(FAULTS); i++)
        if (strcmp(FAULTS[i].name, name) == 0)
            fault = &FAULTS[i];
    if (!fault || begin(&run) < 0)
        return 2;
    ttf_v4l2_camera_info(run.camera, &before);
    all_slots(&run, fault, fault->slots, &thread, &held);
    ttf_v4l2_camera_info(run.camera, &after);
    if (thread)
        pthread_join(thread, NULL);
    if (held >= 0)
        (void)close(held);
    good = run.lost <= fault->may_lose && run.longest_ns <= RECOVERED_NS && run.trouble_ns == 0;
    if (fault->act == ACT_UNBIND_HELD && strcmp(before.device, after.device) == 0)
        good = false;
    printf("%s: %u slots, %u lost, %u taken again, %u steps of recovery, well again after %lld ms, "
           "%s -> %s\n",
           name, fault->slots, run.lost, run.again, run.recoveries,
           (long long)(run.longest_ns / TTF_NS_PER_MS), before.device, after.device);
    end(&run);
    return !good;
}

static unsigned descriptors(void)
{
    DIR *folder = opendir("/proc/self/fd");
    unsigned n = 0;

    while (folder && readdir(folder)) /* NOLINT(concurrency-mt-unsafe): a stream of its own */
        n++;
    if (folder)
        (void)closedir(folder);
    return n;
}

static long resident_kb(void)
{
    FILE *f = fopen("/proc/self/statm", "re");
    char text[128], *second;
    long pages = -1;

    if (f && fgets(text, sizeof(text), f) && (second = strchr(text, ' ')) != NULL)
        pages = strtol(second, NULL, 10);
    if (f)
        (void)fclose(f);
    return pages < 0 ? -1 : pages * (sysconf(_SC_PAGESIZE) / 1024);
}

/* Frames one after another, with a restart now and then; what is held at the end is what was held early on. */
int rig_soak(unsigned slots)
{
    struct run run = {0};
    unsigned fds = 0, failed = 0;
    long kb = 0;

    if (begin(&run) < 0)
        return 2;
    for (unsigned i = 0; i < slots; i++) {
        if (attempt(&run, 0) < 0) { /* capture, too, takes a frame again */
            run.again++;
            printf("    frame %u: %s\n", i, run.said);
            failed += attempt(&run, 0) < 0;
        }
        if (i % 100 == 99 &&
            ttf_camera_recover(run.camera, i % 200 == 99 ? TTF_CAMERA_RESTART : TTF_CAMERA_REOPEN,
                               NULL) < 0)
            failed++;
        if (i ==
            slots * 2 / 5) { /* after a reopening: what a library keeps from its first is no leak */
            fds = descriptors();
            kb = resident_kb();
        }
    }
    printf(
        "soak: %u slots, %u taken again, %u failed, descriptors %u -> %u, resident %ld -> %ld kB\n",
        slots, run.again, failed, fds, descriptors(), kb, resident_kb());
    failed += run.again > slots / 100;
    failed += descriptors() != fds || resident_kb() > kb + 64;
    end(&run);
    return failed > 0;
}
