/* SPDX-License-Identifier: Apache-2.0 */
/* abilities.h: what a camera can and cannot do, in words for whoever built the box. */
#ifndef FIRMWARE_PROBE_ABILITIES_H
#define FIRMWARE_PROBE_ABILITIES_H

#include "ttf/base/frame.h"
#include "ttf/hal/camera.h"

#define PROBE_ABILITIES 5

struct probe_abilities {
    char pixels[64]; /* "mosaic RGGB of 12 bits, packed" */
    /* Exposure, gain, white balance, lens, time: of each what there is, or that there is none. */
    char line[PROBE_ABILITIES][160];
};

void probe_abilities(const struct ttf_camera_caps *caps, const struct ttf_frame_format *format,
                     struct probe_abilities *ret);

#endif
