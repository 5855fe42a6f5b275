/* SPDX-License-Identifier: Apache-2.0 */
/*
 * steer.h: how long each of the coming frames is to be, so that the middle of one of them falls on an instant.
 * Pure: numbers in, numbers out. Private to hal/libcamera.
 *
 * Requests are numbered as they are queued. The duration asked with request n is that of the interval from frame n + delay
 * to the one after it, as far as anybody knows; what really came corrects it with each frame.
 */
#ifndef TTF_HAL_LIBCAMERA_STEER_H
#define TTF_HAL_LIBCAMERA_STEER_H

#include <stdbool.h>
#include <stdint.h>

#define LC_STEER_REMEMBERED 64

struct lc_steer {
    int64_t least_ns, most_ns; /* durations that may be asked */
    int64_t base_ns;           /* of a frame when nothing is steered; least <= base <= most */
    unsigned delay;            /* frames; + requests under way < LC_STEER_REMEMBERED */
    bool on;
    int64_t target_ns; /* the middle wanted */
    bool known;        /* a frame has come since steering began */
    uint64_t last;     /* its request's number */
    int64_t last_middle_ns;
    uint64_t queued;                       /* number of the next request */
    int64_t asked_ns[LC_STEER_REMEMBERED]; /* by number, the last ones */
};

/* All asked so far counts as base_ns. */
void lc_steer_init(struct lc_steer *s, int64_t least_ns, int64_t most_ns, int64_t base_ns,
                   unsigned delay);

/* A target from now on; middles of frames of before are not known any more. */
void lc_steer_begin(struct lc_steer *s, int64_t target_ns);

/* No target: frames of base_ns. */
void lc_steer_end(struct lc_steer *s);

/* The frame of request `number` came; its middle. */
void lc_steer_arrived(struct lc_steer *s, uint64_t number, int64_t middle_ns);

/* The duration to ask with the next request; counts it as queued. floor_ns: no frame may be shorter (its exposure is not). */
int64_t lc_steer_next(struct lc_steer *s, int64_t floor_ns);

#endif
