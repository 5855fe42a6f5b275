/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A gate on the machine's clock: an eventfd that says "open", and a timerfd on
 * CLOCK_BOOTTIME for the deadline. Condition variables know no boot clock: a
 * deadline turned into the monotonic clock's would come late by every suspend in
 * between.
 */
#include "gate.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "utc.h"

struct real_gate {
    struct ttf_gate base;
    int event; /* counts openings that nobody has passed yet */
    int timer;
};

struct ttf_gate *real_gate_create(struct ttf_clock *clock)
{
    struct real_gate *gate = calloc(1, sizeof(*gate));

    if (!gate)
        return NULL;
    gate->base.clock = clock;
    gate->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (gate->event < 0)
        goto err_gate;
    gate->timer = timerfd_create(CLOCK_BOOTTIME, TFD_CLOEXEC | TFD_NONBLOCK);
    if (gate->timer < 0)
        goto err_event;
    return &gate->base;

err_event:
    close(gate->event);
err_gate:
    free(gate);
    return NULL;
}

void real_gate_destroy(struct ttf_gate *gate)
{
    struct real_gate *g = (struct real_gate *)gate;

    close(g->timer);
    close(g->event);
    free(g);
}

void real_gate_open(struct ttf_gate *gate)
{
    struct real_gate *g = (struct real_gate *)gate;
    uint64_t one = 1;

    /* Cannot fail short of 2^64 - 2 openings; EINTR does not occur on a non-blocking eventfd. */
    while (write(g->event, &one, sizeof(one)) < 0 && errno == EINTR)
        ;
}

/* Any number of openings count as one. */
static bool pass(struct real_gate *g)
{
    uint64_t openings;

    return read(g->event, &openings, sizeof(openings)) == (ssize_t)sizeof(openings);
}

int real_gate_wait(struct ttf_gate *gate, int64_t deadline_ns)
{
    struct real_gate *g = (struct real_gate *)gate;
    struct pollfd fds[2] = {{.fd = g->event, .events = POLLIN}, {.fd = g->timer, .events = POLLIN}};
    struct itimerspec at = {0};
    nfds_t n = deadline_ns == TTF_NS_NEVER ? 1 : 2;

    if (pass(g))
        return 0;
    if (n == 2) {
        if (real_boot_ns() >= deadline_ns)
            return -ETIMEDOUT;
        at.it_value.tv_sec = (time_t)(deadline_ns / TTF_NS_PER_S);
        at.it_value.tv_nsec = (long)(deadline_ns % TTF_NS_PER_S);
        if (timerfd_settime(g->timer, TFD_TIMER_ABSTIME, &at, NULL) < 0)
            return -errno;
    }
    for (;;) {
        if (poll(fds, n, -1) < 0 && errno != EINTR)
            return -errno;
        if (pass(g))
            return 0;
        if (n == 2 && real_boot_ns() >= deadline_ns)
            return -ETIMEDOUT;
    }
}
