/* SPDX-License-Identifier: Apache-2.0 */
/* wire.h: one requested line, by either version of libgpiod: wire_v1.c or wire_v2.c. */
#ifndef TTF_HAL_GPIOD_WIRE_H
#define TTF_HAL_GPIOD_WIRE_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/lines.h"

struct wire;

/* An output is requested with its value, inactive, in the same call; an input with both its edges. */
TTF_MUST_USE int wire_request(const struct ttf_line_spec *spec, struct wire **ret,
                              struct ttf_err *err);
TTF_MUST_USE int wire_set(struct wire *wire, bool active);
TTF_MUST_USE int wire_get(struct wire *wire); /* 1, 0, a negative errno */
int wire_fd(const struct wire *wire);         /* of an input: readable when an edge waits */
/* 1 and the level after the edge, 0: none waits, a negative errno. */
TTF_MUST_USE int wire_event(struct wire *wire, bool *ret_active);
void wire_release(struct wire *wire); /* NULL allowed */
/* As ttf_lines_gpiod_holder. */
TTF_MUST_USE int wire_holder(const struct ttf_line_spec *spec, char ret_holder[64],
                             struct ttf_err *err);
const char *wire_version(void);

/* "3" -> 3; -1: it is a name. */
int wire_number(const char *line);

#endif
