/* SPDX-License-Identifier: Apache-2.0 */
/*
 * video_child.h: a program run beside us (ffmpeg), its input or output connected to
 * us. No shell. Its words on stderr are kept for errors; it never outlives its
 * struct. One thread at a time. Private to video.
 */
#ifndef TTF_DATASET_VIDEO_CHILD_H
#define TTF_DATASET_VIDEO_CHILD_H

#include <stddef.h>
#include <sys/types.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

struct video_child {
    char program[64];
    pid_t pid;       /* -1: not running */
    int in;          /* we write; -1: not connected */
    int out;         /* we read; -1: not connected */
    int messages;    /* its stderr; -1: closed */
    char said[1024]; /* the last of what it said */
    size_t n_said;
};

enum video_direction {
    VIDEO_READ,
    VIDEO_WRITE
};

/*
 * Starts argv[0] (looked for on PATH; argv ends in NULL) with its stdout (READ) or stdin
 * (WRITE) connected to us. -ENOENT with a hint if it is not there.
 */
TTF_MUST_USE int video_child_start(struct video_child *child, const char *const argv[],
                                   enum video_direction direction, struct ttf_err *err);

/* Reads up to n bytes, fewer only at the end of its output. Returns how many. */
TTF_MUST_USE ssize_t video_child_read(struct video_child *child, void *buf, size_t n,
                                      struct ttf_err *err);

/* Writes all; -EPROTO with its words if it has stopped listening. */
TTF_MUST_USE int video_child_write(struct video_child *child, const void *data, size_t n,
                                   struct ttf_err *err);

/* Closes our end and waits. 0 if it ended well, -EPROTO with its words if not. */
TTF_MUST_USE int video_child_finish(struct video_child *child, struct ttf_err *err);

/* Ends it without asking, waits, frees. Harmless after finish, and on a failed start. */
void video_child_stop(struct video_child *child);

#endif
