/* SPDX-License-Identifier: Apache-2.0 */
/* guided_calibration.h: acquiring the frames that a calibration is fitted from. */
#ifndef TTF_CAPTURE_GUIDED_CALIBRATION_H
#define TTF_CAPTURE_GUIDED_CALIBRATION_H

#include "ttf/base/err.h"
#include "ttf/capture/plan.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/box.h"

struct ttf_guided_config {
    struct ttf_box *box;
    const struct ttf_plan_shot *shot; /* exposure and lamp levels to calibrate for */
    double mains_hz;
    int64_t settle_ns;  /* of the lamps; 0: their warm_up */
    unsigned frames;    /* averaged, 1..1000 */
    double reflectance; /* flat: of the target */
    const volatile int
        *stop; /* not 0: no further wait, no further set of frames: -ECANCELED; NULL: none */
    int64_t
        patience_ns; /* for the frames, once the lamps have settled: -EIO after it; 0: as long as it takes */
    /* Where the calibration will be saved: without room for it there no lamp is lit and no frame taken, -ENOSPC. NULL: nowhere. */
    struct ttf_io *io;
    const char *folder;
};

/* For want of a plan's: the box's first camera under all its lamps, fully lit; the rest of the shot stays as it is. */
void ttf_guided_plain_shot(const struct ttf_box *box, struct ttf_plan_shot *shot);

/*
 * Frames as a calibration takes them, and nothing more: averaged into *ret, which is zeroed before and to be freed, also on failure. lit: under the
 * shot's lamps, settled; else all are off. What lamps and door do meanwhile is not looked at: a person may be at work inside.
 */
TTF_MUST_USE int ttf_guided_frames(const struct ttf_guided_config *config, bool lit,
                                   struct ttf_raw_sum *ret, struct ttf_err *err);

/*
 * Parts of a calibration. -EIO: the door was open while frames were taken, or, where lamps are to be lit, one was off, had not settled or
 * could not be known. -EINVAL: what the calibration has is of another camera.
 */

/* All lamps off, `frames` frames at the shot's exposure, fitted into *calibration. */
TTF_MUST_USE int ttf_guided_dark(const struct ttf_guided_config *config,
                                 struct ttf_calibration *calibration, struct ttf_err *err);

/* The shot's lamps on and settled, an even target in view. */
TTF_MUST_USE int ttf_guided_flat(const struct ttf_guided_config *config,
                                 struct ttf_calibration *calibration, struct ttf_err *err);

/* The same light on a chart in the sample's place: the colour matrix of a calibration that has its flat. */
TTF_MUST_USE int ttf_guided_chart(const struct ttf_guided_config *config,
                                  const struct ttf_chart_view *view, const struct ttf_chart *chart,
                                  struct ttf_calibration *calibration, struct ttf_err *err);

/* The same light on a flat grid of dots in the sample's place, pitch_mm apart: how large a pixel is. */
TTF_MUST_USE int ttf_guided_geometry(const struct ttf_guided_config *config, double pitch_mm,
                                     struct ttf_calibration *calibration, struct ttf_err *err);

/* The same light on a still subject: `frames` frames, one by one, and how much they differ. */
TTF_MUST_USE int ttf_guided_flicker(const struct ttf_guided_config *config,
                                    struct ttf_calibration *calibration, struct ttf_err *err);

#endif
