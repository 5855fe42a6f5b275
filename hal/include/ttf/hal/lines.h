/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lines.h: the wires of a box: outputs that are driven, inputs that are felt. A bank is a set of them,
 * requested at once.
 *
 * Life: the bank's maker (gpiod.h, pwm.h, and, for tests and boards without wires, ttf_lines_file_create) requests all
 * lines together with their outputs dark; no line is ever given a direction before its value. Dark is level 0
 * whatever the wire's polarity.
 *
 * Threads: one thread at a time. After its maker returned, a bank allocates nothing.
 */
#ifndef TTF_HAL_LINES_H
#define TTF_HAL_LINES_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_LINES_MAX 16

struct ttf_lines;

struct ttf_line_spec {
    char label[32]; /* the box's word for it, in messages and as the consumer: "left", "door" */
    bool input;     /* else an output */
    char chip
        [64]; /* "gpiochip0", a chip's label, or empty: the one chip that has a line of this name */
    char line[64]; /* the line's name, or its number on the chip */
    bool active_low;
    bool pull_up; /* of an input: asked for where the chip can */
    int64_t
        period_ns; /* of a PWM channel (pwm.h): the length of its cycle; 0: a line that is on or off */
};

/* An input changed. */
struct ttf_line_event {
    unsigned i;
    bool active;
};

unsigned ttf_lines_count(const struct ttf_lines *lines);

/* Belongs to lines; i < count, else NULL. */
const struct ttf_line_spec *ttf_lines_spec(const struct ttf_lines *lines, unsigned i);

/*
 * Drives output i: a line that is on or off is on from 500 permille, a PWM channel takes any. -EINVAL for an input or
 * beyond 1000; -ENODEV if the chip is gone, -EIO and the like if it refuses.
 */
TTF_MUST_USE int ttf_lines_set(struct ttf_lines *lines, unsigned i, unsigned permille);

/* 1 active, 0 not; of an output what it is driven to. -EINVAL, -ENODEV, -EIO. */
TTF_MUST_USE int ttf_lines_get(struct ttf_lines *lines, unsigned i);

/* A descriptor that is readable while an event waits; -1: look every 50 ms instead. Belongs to lines. */
int ttf_lines_fd(const struct ttf_lines *lines);

/* The oldest event not yet taken: 1 and *ret; 0: none; -ENODEV. Never blocks. */
TTF_MUST_USE int ttf_lines_event(struct ttf_lines *lines, struct ttf_line_event *ret);

/* After -ENODEV: requests all lines anew, outputs dark. 0 if they are there again. */
TTF_MUST_USE int ttf_lines_reopen(struct ttf_lines *lines, struct ttf_err *err);

/* Outputs dark, then frees. NULL allowed. */
void ttf_lines_destroy(struct ttf_lines *lines);

/* 0, or -EINVAL naming the line: too many, without a label or a line, a label twice. */
TTF_MUST_USE int ttf_lines_check(const struct ttf_line_spec *specs, unsigned n,
                                 struct ttf_err *err);

/*
 * A bank whose wires are bytes of a file, '0' or '1' for each line, made if it is not there: for tests, where
 * what is outside looks at and moves the wires, and which stay as they are when the process dies, as a latched
 * chip's do. -EIO and the like.
 */
TTF_MUST_USE int ttf_lines_file_create(const char *path, const struct ttf_line_spec *specs,
                                       unsigned n, struct ttf_lines **ret, struct ttf_err *err);

/*
 * One bank of several: line i is that of the same label in one of the banks, which belong to it from then on (on
 * failure they stay the caller's). If the chip of one is gone, its lines say so, and events of the whole. -EINVAL, -ENOMEM.
 */
TTF_MUST_USE int ttf_lines_joined_create(const struct ttf_line_spec *specs, unsigned n,
                                         struct ttf_lines *const *banks, unsigned n_banks,
                                         struct ttf_lines **ret, struct ttf_err *err);

/* --- for authors of back-ends: all ops mandatory, struct embedded first --- */
struct ttf_lines_ops {
    const char *name;
    int (*set)(struct ttf_lines *lines, unsigned i, unsigned permille);
    int (*get)(struct ttf_lines *lines, unsigned i);
    int (*fd)(const struct ttf_lines *lines);
    int (*event)(struct ttf_lines *lines, struct ttf_line_event *ret);
    int (*reopen)(struct ttf_lines *lines, struct ttf_err *err);
    void (*destroy)(struct ttf_lines *lines);
};

struct ttf_lines {
    const struct ttf_lines_ops *ops;
    unsigned n;
    struct ttf_line_spec spec[TTF_LINES_MAX];
};

#endif
