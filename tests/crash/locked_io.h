/* SPDX-License-Identifier: Apache-2.0 */
/*
 * locked_io.h: an I/O table that one thread at a time may use, made thread-safe, as ttf/dataset/io.h wants it.
 *
 * Who is told of a folder's entries may come back with operations.
 */
#ifndef TTF_TESTS_CRASH_LOCKED_IO_H
#define TTF_TESTS_CRASH_LOCKED_IO_H

#include <pthread.h>

#include "ttf/dataset/io.h"

struct locked_io {
    struct ttf_io io; /* first */
    struct ttf_io *base;
    pthread_mutex_t mutex;
};

/* base is borrowed. To be given to locked_io_free. */
void locked_io_init(struct locked_io *locked, struct ttf_io *base);
void locked_io_free(struct locked_io *locked);

#endif
