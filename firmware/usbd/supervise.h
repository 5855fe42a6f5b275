/* SPDX-License-Identifier: Apache-2.0 */
/*
 * supervise.h: a process that holds a descriptor and keeps another one running that uses it. It does nothing else, so that nothing can
 * make it end: as long as it lives the gadget stays bound, and the network beside it up.
 */
#ifndef USBD_SUPERVISE_H
#define USBD_SUPERVISE_H

#include <signal.h>

#include "ttf/hal/clock.h"

/*
 * Runs argv (NULL-ended; argv[0] is a path) with fd open in it, again and again, 100 ms after it has ended (when it ended by
 * itself, within 10 s, again and again: twice as long each time, up to 10 s), until stop is not 0, then ends it with SIGTERM. SIGCHLD and SIGTERM must interrupt waiting. Its exit code 2 (wrong options) ends it too: 2; else 0.
 */
int supervise(const char *const *argv, int fd, struct ttf_clock *clock,
              const volatile sig_atomic_t *stop);

#endif
