/* SPDX-License-Identifier: Apache-2.0 */
/* descriptor.h: waiting for what a driver or library has to say through a file descriptor, in the clock's time. */
#ifndef TTF_HAL_DESCRIPTOR_H
#define TTF_HAL_DESCRIPTOR_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/hal/clock.h"

/*
 * Until fd can be read. 0; -EIO: it has an error or was hung up; -ETIMEDOUT: deadline_ns of the boot clock came first; -errno of
 * ppoll. A deadline through which the machine slept is seen half a second late at most. Any thread; of a real clock.
 */
TTF_MUST_USE int ttf_descriptor_wait(struct ttf_clock *clock, int fd, int64_t deadline_ns);

#endif
