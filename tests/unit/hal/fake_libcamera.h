/* SPDX-License-Identifier: Apache-2.0 */
/*
 * fake_libcamera.h: a libcamera that exists only in a test, behind the back-end's table, with one camera. Its sensor runs freely
 * on a virtual clock; requests take effect some frames late; it does what it is told to do wrong.
 */
#ifndef TTF_TESTS_HAL_FAKE_LIBCAMERA_H
#define TTF_TESTS_HAL_FAKE_LIBCAMERA_H

#include "system.h"

#define FAKE_REQUESTS 16
#define FAKE_PENDING  16

/* How it grants raw streams. */
enum fake_pipeline {
    FAKE_PLAIN = 0, /* what is asked */
    FAKE_VC4,       /* Raspberry Pis up to the 4 */
    FAKE_PISP       /* Raspberry Pi 5 */
};

struct fake_queued {
    unsigned buffer;
    struct lc_settings settings;
};

struct fake_exposed {
    int64_t complete_ns;
    struct lc_done done;
};

struct fake_libcamera {
    /* What it is; may be changed at any time. */
    struct ttf_clock *clock;
    const char *id, *model; /* id NULL: there is none, or it is unplugged */
    struct lc_offer raw[8], processed[8];
    struct lc_limits limits;
    uint32_t width, height, row_padding;
    uint32_t granted_fourcc; /* instead of what is asked; 0: that */
    uint64_t granted_modifier;
    enum fake_pipeline pipeline;
    bool turned; /* the picture by 180 degrees, and the mosaic with it; of a Pi's pipelines */
    enum lc_colour colour; /* instead of what is asked; 0: that */
    unsigned buffers_max;
    int64_t least_ns; /* the shortest frame of its mode */
    int64_t line_ns;  /* exposures are cut down to whole ones */
    int64_t readout_ns;
    unsigned delay;           /* frames from a request's own to the first that obeys it */
    uint32_t untold;          /* bit c: frames do not tell this control */
    bool stamp_none;          /* no SensorTimestamp, no driver's stamp */
    bool stamp_monotonic;     /* SensorTimestamp is the driver's stamp, on the monotonic clock */
    bool stamp_readout;       /* stamps are of the readout's beginning */
    int64_t monotonic_lag_ns; /* behind the boot clock */
    double digital_gain;      /* told; 0: not */
    int64_t
        longest_exposure_ns; /* what it makes of longer ones, without saying so beforehand; 0: no bound */

    /* What goes wrong. */
    bool automatic;      /* exposure wanders whatever is asked */
    int64_t uneven_ns;   /* each third frame is longer by this */
    bool deaf_durations; /* frame durations are taken and not followed */
    int begin_failure, hold_failure, configure_failure, start_failure, queue_failure;
    bool silent;  /* no frame comes, nothing is said */
    bool cancels; /* requests come back unexposed */
    uint64_t dropped, in_error, cut,
        mute; /* bit n: frame n after fate_from is lost, bad, short, tells nothing */
    uint64_t fate_from;
    uint64_t forgets; /* bit n: the settings of request n after fate_request are not taken */
    uint64_t fate_request;

    /* What it did. */
    unsigned begun, ended, held, let_go, starts, stops;
    uint64_t requests;       /* queued in all */
    struct lc_settings last; /* of the last request, or start */
    struct lc_ask asked;
    unsigned configured; /* how often */

    int64_t began_ns[64]; /* when frame n (mod 64) was begun to be exposed */

    /* Its own. */
    bool streaming;
    int64_t next_ns; /* when the next frame begins */
    uint64_t frame;
    unsigned n;
    uint16_t *memory[FAKE_REQUESTS];
    size_t bytes;
    struct fake_queued queue[FAKE_REQUESTS];
    unsigned n_queue;
    struct lc_settings pending[FAKE_PENDING]; /* by frame, that it will obey */
    uint64_t pending_of[FAKE_PENDING];
    struct lc_settings obeyed;
    struct fake_exposed exposed[FAKE_REQUESTS];
    unsigned n_exposed;
};

/* The system that stands on it. */
struct lc_system fake_libcamera_system(struct fake_libcamera *fake);

/* A raw sensor of 12 bits, 64 x 48, 20 ms a frame at least, exposure, gain, lens and frame durations; a processed stream beside it. */
void fake_libcamera_init(struct fake_libcamera *fake, struct ttf_clock *clock);
/* A 12-bit sensor of an official camera module behind a Raspberry Pi's pipeline, as it is mounted: turned. */
void fake_libcamera_be_pi(struct fake_libcamera *fake, enum fake_pipeline pipeline);

/* What such a pipeline makes of a format that is asked: fourcc and modifier of *ret. */
void fake_pi_grant(const struct fake_libcamera *fake, const struct lc_ask *ask,
                   struct lc_granted *ret);

void fake_libcamera_free(struct fake_libcamera *fake);

/* What it has no more. */
void fake_libcamera_take_away(struct fake_libcamera *fake, enum lc_control control);

/* The sequence that the next frame will have. */
uint64_t fake_libcamera_next(struct fake_libcamera *fake);

#endif
