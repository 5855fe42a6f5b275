/* SPDX-License-Identifier: Apache-2.0 */
/*
 * picture.h: pictures from outside as finite floats of the output's size, which is
 * how every map sees them.
 */
#ifndef TTF_SYNTH_CONTROL_PICTURE_H
#define TTF_SYNTH_CONTROL_PICTURE_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pixbuf.h"

/* Sides of 1 to 32768 pixels, as quilting has them; else -EINVAL. */
TTF_MUST_USE int ttf_control_size_check(uint32_t width, uint32_t height, struct ttf_err *err);

/*
 * The picture as F32 of width x height: its first three samples (colour), or one: its
 * grey (Rec. 709 weights of what is stored). Alpha is left out. `name` is for errors:
 * which picture. -EINVAL: no pixels, F16, not finite, a grey one where colour is
 * needed; -ENOMEM. To free: ttf_pixbuf_free.
 */
TTF_MUST_USE int ttf_control_grey(const struct ttf_pixbuf *picture, const char *name,
                                  uint32_t width, uint32_t height, struct ttf_pixbuf *ret,
                                  struct ttf_err *err);
TTF_MUST_USE int ttf_control_colour(const struct ttf_pixbuf *picture, const char *name,
                                    uint32_t width, uint32_t height, struct ttf_pixbuf *ret,
                                    struct ttf_err *err);

#endif
