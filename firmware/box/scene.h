/* SPDX-License-Identifier: Apache-2.0 */
/*
 * scene.h: pictures from files as what a simulated camera looks at. hal knows no
 * file format: it takes reflectance through struct ttf_scene_ops.
 *
 * Of n frames over a span, frame i stands for the times nearest to
 * i * span / (n - 1) (of a dataset: nearest to its own time, the whole stretched
 * to the span); before the first and after the last, those stay. A frame fills
 * the sample's square whatever its proportions. Two frames are kept decoded.
 */
#ifndef FIRMWARE_SCENE_H
#define FIRMWARE_SCENE_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/sim.h"

/* All pictures (PNG, JPEG, TIFF) of a folder, in natural order of their names. -ENODATA: none. */
TTF_MUST_USE int scene_of_images(struct ttf_io *io, const char *folder, int64_t span_ns,
                                 struct ttf_scene *ret, struct ttf_err *err);

/* The primary stream of a dataset. */
TTF_MUST_USE int scene_of_dataset(struct ttf_io *io, const char *path, int64_t span_ns,
                                  struct ttf_scene *ret, struct ttf_err *err);

#endif
