/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box.h: the devices of one box, together.
 *
 * A plain struct: whoever made the devices (a back-end's constructor, chosen by
 * `firmware` from the board's description) fills it; capture borrows it.
 * Members that a board lacks are NULL; clock and cameras never are.
 */
#ifndef TTF_HAL_BOX_H
#define TTF_HAL_BOX_H

#include <stdbool.h>

#include "ttf/hal/camera.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/lamps.h"
#include "ttf/hal/panel.h"
#include "ttf/hal/sensors.h"
#include "ttf/hal/watchdog.h"

#define TTF_BOX_CAMERAS_MAX 4

struct ttf_box_camera {
    char name[32]; /* the key in the board's `cameras:` map */
    struct ttf_camera *camera;
};

struct ttf_box {
    char board[64];  /* the board's name */
    char serial[64]; /* of this box */
    /* What it was made of, in words: where two boots differ in this, so may what they capture. Empty: not said. */
    char description[256];
    bool simulated; /* everything it yields says so */
    struct ttf_clock *clock;
    unsigned n_cameras; /* 1..TTF_BOX_CAMERAS_MAX */
    struct ttf_box_camera cameras[TTF_BOX_CAMERAS_MAX];
    struct ttf_lamps *lamps;
    struct ttf_sensors *sensors;
    struct ttf_panel *panel;
    struct ttf_watchdog *watchdog;
    /*
     * 0 while the box has power. A simulated power cut makes this return 1; the
     * session must then end at once, without another write. NULL: always 0.
     */
    int (*power_lost)(void *box_private);
    void *box_private;
    /* Frees all the devices. Set by whoever made them; called by ttf_box_destroy. */
    void (*destroy)(struct ttf_box *box);
};

/* Destroys the devices through box->destroy and zeroes the struct. NULL allowed. */
void ttf_box_destroy(struct ttf_box *box);

#endif
