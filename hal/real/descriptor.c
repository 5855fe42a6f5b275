/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/descriptor.h"

#include <errno.h>
#include <poll.h>
#include <time.h>

/* A wait is cut up so that one through which the machine slept is not late by its sleep. */
#define WAIT_MAX_NS (500 * TTF_NS_PER_MS)

int ttf_descriptor_wait(struct ttf_clock *clock, int fd, int64_t deadline_ns)
{
    struct pollfd waiting = {.fd = fd, .events = POLLIN};

    for (;;) {
        int64_t left = deadline_ns - ttf_clock_now_ns(clock);
        struct timespec wait;
        int n;

        left = left < 0 ? 0 : left > WAIT_MAX_NS ? WAIT_MAX_NS : left;
        wait = (struct timespec){.tv_nsec = (long)left};
        n = ppoll(&waiting, 1, &wait, NULL);
        if (n > 0)
            return waiting.revents & (POLLERR | POLLHUP | POLLNVAL) ? -EIO : 0;
        if (n < 0 && errno != EINTR)
            return -errno;
        if (ttf_clock_now_ns(clock) >= deadline_ns)
            return -ETIMEDOUT;
    }
}
