/* SPDX-License-Identifier: Apache-2.0 */
/*
 * wire.h: what passes between a program and the process that has libcamera (host.c): the table of boundary.h, a packet a call and one
 * an answer, and a packet a frame on a socket of its own. Both ends are of one build, so plain structs go. Private to hal/libcamera.
 */
#ifndef TTF_HAL_LIBCAMERA_WIRE_H
#define TTF_HAL_LIBCAMERA_WIRE_H

#include <stdio.h>

#include "boundary.h"

/* The host's ends. */
#define LC_CALLS_FD  3
#define LC_FRAMES_FD 4

enum lc_word {
    LC_SAY_BEGIN = 1,
    LC_SAY_COMPLAINT,
    LC_SAY_LIST,
    LC_SAY_HOLD,
    LC_SAY_LET_GO,
    LC_SAY_OFFER,
    LC_SAY_CONFIGURE,
    LC_SAY_LIMITS,
    LC_SAY_ALLOCATE,
    LC_SAY_BUFFER, /* answered with the buffer's descriptor */
    LC_SAY_START,
    LC_SAY_STOP,
    LC_SAY_QUEUE
};

struct lc_call {
    enum lc_word word;
    uint32_t number; /* i, n or a buffer */
    enum lc_role role;
    union {
        char id[128];
        struct lc_ask ask;
        struct lc_settings settings;
    } with;
};

/* The first one comes unasked: 0 and libcamera's version, or -ENOTSUP and why the module is none. */
struct lc_answer {
    int r;
    uint32_t n;
    uint64_t length;
    union {
        char text[160];
        struct lc_identity identity;
        struct lc_offer offer;
        struct lc_granted granted;
        struct lc_limits limits;
    } with;
};

/* 0, or -ENODEV: the camera is gone, and no more frames come. */
struct lc_frame {
    int r;
    struct lc_done done;
};

/*
 * What both ends must have in common, as text: a program that goes on while another version is installed under it must
 * not talk to that one's host.
 */
static inline void lc_wire_name(char ret[96])
{
    (void)snprintf(ret, 96, TTFBOX_VERSION "/%u/%zu/%zu/%zu", LC_ABI, sizeof(struct lc_call),
                   sizeof(struct lc_answer), sizeof(struct lc_frame));
}

#endif
