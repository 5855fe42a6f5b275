/* SPDX-License-Identifier: Apache-2.0 */
/* camera.h: the simulated camera's parts: control (camera.c) and frames (camera_frame.c). Private to hal/sim. */
#ifndef TTF_HAL_SIM_CAMERA_H
#define TTF_HAL_SIM_CAMERA_H

#include <pthread.h>

#include "box_private.h"
#include "camera_timing.h"
#include "ttf/hal/camera_backend.h"

/* One exposure of the set under way, and what will become of its frame. */
struct sim_exposure {
    int64_t read_ns; /* see camera_timing.h: B */
    struct ttf_exposure granted;
    bool missing, corrupt;
    int64_t short_permille; /* 1000: whole */
    int64_t late_ns;
};

struct sim_buffer {
    struct ttf_frame frame;
    uint16_t *data;
    bool held;
};

struct sim_camera {
    struct ttf_camera base;
    struct sim_box *box;
    struct camera_timing timing;
    int64_t phase_ns; /* a readout of the free-running stream, the last one known */
    uint32_t sequence;
    int64_t sequence_ns;   /* readout of the frame that had it */
    bool lost;             /* a frame has gone missing since the last that came */
    bool hung;             /* a hang has begun */
    unsigned hang;         /* its fault */
    int64_t hang_began_ns; /* elapsed */
    int64_t hang_until_ns; /* boot clock */
    int64_t hang_cured_ns[TTF_SIM_FAULTS_MAX]; /* elapsed: hangs that began until then are over */
    unsigned n, next;                          /* of the set */
    struct sim_exposure set[TTF_CAMERA_SET_MAX];
    float *rows;            /* light by row: each lamp's, then the ambient */
    struct ttf_gate *freed; /* opened by release */
    pthread_mutex_t lock;   /* of the buffers' `held` */
    struct sim_buffer *buffer;
};

int sim_camera_next(struct ttf_camera *base, int64_t deadline_ns, struct ttf_frame **ret_frame,
                    struct ttf_err *err);

/* World locked: finds the frame's fate. Once per exposure, as one-time faults are spent by it. */
void sim_camera_foresee(struct sim_camera *camera, struct sim_exposure *e);

/* World locked: the hang is over. */
void sim_camera_unhang(struct sim_camera *camera);

/* The error of a box without power: -ENODEV. */
int sim_camera_no_power(struct ttf_err *err);

#endif
