/* SPDX-License-Identifier: Apache-2.0 */
/* made.h: pictures of known content, and what every test of maps asks. */
#ifndef TTF_TESTS_SYNTH_CONTROL_MADE_H
#define TTF_TESTS_SYNTH_CONTROL_MADE_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/pixbuf.h"
#include "ttf/synth/rate_map.h"

/* F32 grey, value(x, y) at pixel centres in units of the width. */
typedef double made_fn(double x, double y);
struct ttf_pixbuf made_grey(uint32_t width, uint32_t height, made_fn *value);

/* F32 x 3 of one colour. */
struct ttf_pixbuf made_plain(uint32_t width, uint32_t height, double r, double g, double b);

float made_at(const struct ttf_rate_map *map, uint32_t x, uint32_t y);

/* It failed so, said where and why, and left the map alone. */
void made_refused(int got, int code, const char *where, const struct ttf_err *err,
                  const struct ttf_rate_map *untouched);

#endif
