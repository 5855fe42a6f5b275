/* SPDX-License-Identifier: Apache-2.0 */
/* find.h: which of the machine's video devices is the camera meant. Private to hal/v4l2. */
#ifndef TTF_HAL_V4L2_FIND_H
#define TTF_HAL_V4L2_FIND_H

#include "sys.h"

/* A device as it names itself. */
struct v4l2_identity {
    char device[64], driver[16], name[32], bus[32];
    char serial[64];    /* of the device behind it; empty: it tells none */
    unsigned namesakes; /* other cameras of its name that were there when it was found */
};

/*
 * Opens the first device that captures into memory and fits config; known: the very one that it was before, wherever
 * it appears now (NULL: any): on its bus; else, where the bus it was on has no such camera any more and the board does
 * not ask for that bus, the one with its serial number; else, if neither tells one, the only one of its name, if it was
 * the only one before. A descriptor, with *ret. -ENODEV (err says what there is), -EACCES, -ENOTSUP, -EBUSY.
 */
TTF_MUST_USE int v4l2_find(const struct v4l2_sys *sys, void *ctx,
                           const struct ttf_v4l2_config *config, const struct v4l2_identity *known,
                           struct v4l2_identity *ret, struct ttf_err *err);

#endif
