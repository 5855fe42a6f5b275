/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's own clocks behind clock.h. */
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "gate.h"
#include "utc.h"

struct real_clock {
    struct ttf_clock base;
    pthread_mutex_t lock; /* of utc */
    struct real_utc utc;
    struct ttf_host_time *host_time; /* NULL: none */
    char boot_id[37];
};

static int64_t clock_now_ns(struct ttf_clock *base)
{
    (void)base;
    return real_boot_ns();
}

static void clock_utc(struct ttf_clock *base, struct ttf_utc *ret)
{
    struct real_clock *clock = (struct real_clock *)base;

    pthread_mutex_lock(&clock->lock);
    real_utc_look(&clock->utc, ret);
    pthread_mutex_unlock(&clock->lock);
    if (clock->host_time)
        ttf_host_time_apply(clock->host_time, ret);
}

static void clock_trust_host(struct ttf_clock *base, struct ttf_host_time *host_time)
{
    ((struct real_clock *)base)->host_time = host_time;
}

static int64_t clock_monotonic_offset_ns(struct ttf_clock *base, int64_t *ret_uncertainty_ns)
{
    (void)base;
    return real_monotonic_offset_ns(ret_uncertainty_ns);
}

static const char *clock_boot_id(struct ttf_clock *base)
{
    return ((struct real_clock *)base)->boot_id;
}

/* Real time passes whoever waits. */
static void clock_join(struct ttf_clock *base)
{
    (void)base;
}

static void clock_leave(struct ttf_clock *base)
{
    (void)base;
}

static int clock_wait_until(struct ttf_clock *base, int64_t deadline_ns)
{
    struct timespec at;

    (void)base;
    if (deadline_ns <= 0)
        return 0;
    at.tv_sec = (time_t)(deadline_ns / TTF_NS_PER_S);
    at.tv_nsec = (long)(deadline_ns % TTF_NS_PER_S);
    while (clock_nanosleep(CLOCK_BOOTTIME, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
    return 0;
}

static void clock_charge(struct ttf_clock *base, enum ttf_work work, unsigned times)
{
    (void)base;
    (void)work;
    (void)times;
}

static void clock_destroy(struct ttf_clock *base)
{
    struct real_clock *clock = (struct real_clock *)base;

    pthread_mutex_destroy(&clock->lock);
    free(clock);
}

static const struct ttf_clock_ops real_clock_ops = {
    .name = "real",
    .is_virtual = false,
    .now_ns = clock_now_ns,
    .utc = clock_utc,
    .trust_host = clock_trust_host,
    .monotonic_offset_ns = clock_monotonic_offset_ns,
    .boot_id = clock_boot_id,
    .join = clock_join,
    .leave = clock_leave,
    .wait_until = clock_wait_until,
    .charge = clock_charge,
    .gate_create = real_gate_create,
    .gate_destroy = real_gate_destroy,
    .gate_open = real_gate_open,
    .gate_wait = real_gate_wait,
    .destroy = clock_destroy,
};

static int read_boot_id(char ret[37])
{
    FILE *f = fopen("/proc/sys/kernel/random/boot_id", "re");
    size_t n;

    if (!f)
        return -errno;
    n = fread(ret, 1, 36, f);
    fclose(f);
    ret[n] = '\0';
    return n == 36 ? 0 : -EIO;
}

struct ttf_clock *ttf_clock_real_create(void)
{
    struct real_clock *clock = calloc(1, sizeof(*clock));
    int r;

    if (!clock) {
        errno = ENOMEM;
        return NULL;
    }
    clock->base.ops = &real_clock_ops;
    r = read_boot_id(clock->boot_id);
    if (r < 0)
        goto err_clock;
    r = -pthread_mutex_init(&clock->lock, NULL);
    if (r < 0)
        goto err_clock;
    real_utc_init(&clock->utc, "/sys");
    return &clock->base;

err_clock:
    free(clock);
    errno = -r;
    return NULL;
}
