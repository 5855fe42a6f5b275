/* SPDX-License-Identifier: Apache-2.0 */
/*
 * fake_v4l2.h: a video device that exists only in a test, behind the back-end's table of system calls. It runs freely on
 * a virtual clock, does what it is told to do wrong, and writes into each frame what it was exposed with.
 */
#ifndef TTF_TESTS_HAL_FAKE_V4L2_H
#define TTF_TESTS_HAL_FAKE_V4L2_H

#include <stdbool.h>
#include <stdint.h>

#include <linux/videodev2.h>

#include "sys.h"

#define FAKE_CONTROLS 24
#define FAKE_BUFFERS  16

struct fake_format {
    uint32_t fourcc, flags;
};

struct fake_control {
    uint32_t id, type; /* V4L2_CTRL_TYPE_* */
    const char *name;
    int64_t min, max, step, def, value;
    bool stuck; /* takes any value and stays as it is */
};

struct fake_buffer {
    void *at;
    bool queued, filled;
    struct v4l2_buffer out;
};

struct fake_v4l2 {
    /* What it is; may be changed at any time. */
    struct ttf_clock *clock;
    char path[64]; /* empty: unplugged */
    const char *driver, *card, *bus, *serial;
    uint32_t device_caps;
    struct fake_format formats[16];
    uint32_t granted_fourcc; /* instead of what is asked for; 0: that */
    uint32_t width, height;  /* the only size it has */
    uint32_t row_padding;    /* bytes at the end of each row */
    uint32_t ycbcr_enc, quantization, colorspace, xfer_func, field;
    bool no_sizes, no_rate;
    int64_t line_ns;        /* what a line of vertical blanking adds to a frame; 0: nothing */
    bool steers;            /* takes another rate while it streams */
    int64_t period_step_ns; /* of the durations it knows; 0: any */
    bool keeps_range;       /* quantization is what somebody last asked for by name */
    struct fake_control controls[FAKE_CONTROLS];
    int64_t period_ns, readout_ns;
    unsigned delay; /* frames from a change of controls to the first that shows it */
    unsigned buffers_max;
    uint32_t stamp_flags;
    int64_t monotonic_lag_ns; /* of the clock that stamps, behind the boot clock */

    /* What goes wrong. */
    unsigned long failing; /* a request ... */
    int failure;           /* ... that gives this, ... */
    int failures;          /* ... so many times; -1: always; ... */
    int served;            /* ... after so many that are served */
    int open_failure;
    uint64_t dropped; /* bit n: frame n after fate_from is dropped, in error, or short */
    uint64_t in_error, cut;
    uint64_t fate_from; /* sequence */
    bool dead;          /* the stream gives nothing but EIO until it is switched off */
    bool silent;        /* no frame comes, nothing is said */
    bool frozen_sequence;

    /* What it did. */
    unsigned opened, closed, mapped, unmapped, s_fmt, reqbufs;
    unsigned rates; /* that were set */
    int priority;
    uint32_t asked_width, asked_height;

    /* Its own. */
    int fd;
    bool streaming;
    int64_t began_ns;
    uint64_t made; /* frames since the stream began */
    unsigned n;
    struct fake_buffer buffer[FAKE_BUFFERS];
    unsigned fifo[FAKE_BUFFERS], n_fifo;
    uint32_t fourcc;
    int32_t exposure_then[64], gain_then[64]; /* as set when frame n (mod 64) began */
};

extern const struct v4l2_sys fake_v4l2_sys;

/* Raw Bayer of 10 bits, 64 x 48, 20 ms a frame, exposure and gain; a device named so and on that bus. */
void fake_v4l2_init(struct fake_v4l2 *fake, struct ttf_clock *clock);
void fake_v4l2_free(struct fake_v4l2 *fake);

/* NULL: it has none. */
struct fake_control *fake_control(struct fake_v4l2 *fake, uint32_t id);
void fake_control_remove(struct fake_v4l2 *fake, uint32_t id);

/* Pulls the plug, and puts it in again under a name; controls are then as new. */
void fake_unplug(struct fake_v4l2 *fake);
void fake_plug(struct fake_v4l2 *fake, const char *path);

/* The sequence that the next frame will have. */
uint64_t fake_next_sequence(struct fake_v4l2 *fake);

/* What frame->data says it was exposed with: the codes of exposure and gain. */
void fake_exposed_with(const void *data, int *ret_exposure, int *ret_gain);

/* A clock on the inner one, whose monotonic twin lags by *lag_ns. Owns inner. */
struct ttf_clock *fake_clock_create(struct ttf_clock *inner, const int64_t *lag_ns);

#endif
