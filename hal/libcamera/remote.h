/* SPDX-License-Identifier: Apache-2.0 */
/* remote.h: boundary.h's table on a libcamera that is in a process of its own (host.c). Private to hal/libcamera. */
#ifndef TTF_HAL_LIBCAMERA_REMOTE_H
#define TTF_HAL_LIBCAMERA_REMOTE_H

#include "system.h"

/*
 * Starts the process: host, the program, with module, what it is to load (which may take 20 s). patience_ms: what an answer may take, and
 * another process to start; one that has not come by then ends the process, as does libcamera where it knows no better. Then each call gives -ENODEV until end and begin, which starts another.
 * ret->destroy frees it. -ENOTSUP: one of the two cannot be loaded (err says why); -errno of sockets and spawning.
 */
TTF_MUST_USE int lc_remote_create(const char *host, const char *module, int patience_ms,
                                  struct lc_system *ret, struct ttf_err *err);

#endif
