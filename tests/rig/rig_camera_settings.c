/* SPDX-License-Identifier: Apache-2.0 */
/* rig_camera_settings.c: settings asked of the webcam of rig_uvc, and what is seen of them in its pictures. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rig_camera.h"
#include "rig_uvc.h"
#include "ttf/base/time.h"

void rig_uvc_config(struct ttf_v4l2_config *config)
{
    (void)snprintf(config->name, sizeof(config->name), "RIG webcam");
    config->frame_period_ns = 100 * TTF_NS_PER_MS;
    config->gain_unity = 64;
    config->focus_per_dioptre = 50;
    config->flicker = TTF_V4L2_FLICKER_50HZ;
    config->white_balance_kelvin = 5200;
}

static int one(struct ttf_camera *camera, struct ttf_clock *clock, int64_t us, unsigned gain)
{
    struct ttf_exposure asked = {.exposure_ns = us * TTF_NS_PER_US, .gain_milli = gain};
    struct ttf_camera_set set = {.settings = &asked, .n = 1};
    struct ttf_frame *frame = NULL;
    struct ttf_err err = {0};
    char text[512];
    int r = ttf_camera_submit(camera, &set, &err);

    if (r == 0)
        r = ttf_camera_next(camera, ttf_clock_now_ns(clock) + 10 * TTF_NS_PER_S, &frame, &err);
    if (r < 0 || !frame) {
        printf("asked %lld %u failed %s\n", (long long)us, gain,
               ttf_err_text(&err, text, sizeof(text)));
        return r < 0 ? r : -EIO;
    }
    printf("asked %lld %u granted %lld %u lens %u flags %u mean %.5f\n", (long long)us, gain,
           (long long)(frame->settings.exposure_ns / TTF_NS_PER_US), frame->settings.gain_milli,
           frame->settings.lens_mdpt, frame->flags,
           rig_uvc_mean(frame->data, frame->format.width, frame->format.height,
                        (unsigned)frame->format.stride));
    ttf_camera_release(camera, frame);
    return 0;
}

static int each(struct ttf_camera *camera, struct ttf_clock *clock, const char *list)
{
    int failed = 0;

    for (;;) {
        char *rest;
        long long us = strtoll(list, &rest, 10);
        unsigned gain;

        if (rest == list || *rest != ':')
            return failed;
        list = rest + 1;
        gain = (unsigned)strtoul(list, &rest, 10);
        if (rest == list)
            return failed;
        failed += one(camera, clock, us, gain) < 0;
        list = *rest == ',' ? rest + 1 : rest;
    }
}

int rig_settings(const char *list)
{
    struct ttf_camera_mode native = {0};
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_camera *camera = NULL;
    struct ttf_err err = {0};
    char text[512];
    int r = clock ? rig_camera("YUYV", clock, &camera, &err) : -ENOMEM, failed = 1;

    if (r == 0)
        r = ttf_camera_configure(camera, &native, NULL, &err);
    if (r == 0)
        r = ttf_camera_start(camera, &err);
    if (r < 0)
        printf("refused: %s\n", ttf_err_text(&err, text, sizeof(text)));
    else
        failed = each(camera, clock, list);
    ttf_camera_destroy(camera);
    ttf_clock_destroy(clock);
    return failed > 0;
}
