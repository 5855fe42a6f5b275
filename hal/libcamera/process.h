/* SPDX-License-Identifier: Apache-2.0 */
/* process.h: the process that has libcamera, started and ended, and one call to it. Private to hal/libcamera. */
#ifndef TTF_HAL_LIBCAMERA_PROCESS_H
#define TTF_HAL_LIBCAMERA_PROCESS_H

#include <pthread.h>
#include <stdatomic.h>
#include <sys/types.h>

#include "wire.h"

struct lc_process {
    pid_t pid;            /* 0: none runs */
    int calls, frames;    /* sockets; the latter does not block */
    pthread_mutex_t lock; /* one call at a time */
    atomic_bool dead;     /* it ended, or did not answer in time: until lc_process_end */
};

/* hello: what it says first, within hello_ms; each answer then within call_ms (remote.h). -errno: there is none. */
int lc_process_start(struct lc_process *p, const char *host, const char *module, int hello_ms,
                     int call_ms, struct lc_answer *ret_hello);
/* Ends it at once and frees what is of it; nothing to do if none runs. No other thread calls or listens. */
void lc_process_end(struct lc_process *p);
/*
 * The answer's own number; -ENODEV: it is dead. ret_fd: where a descriptor goes that came with the answer (-1: none), or NULL. Any thread.
 */
int lc_process_call(struct lc_process *p, const struct lc_call *call, struct lc_answer *ret,
                    int *ret_fd);

#endif
