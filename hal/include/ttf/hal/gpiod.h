/* SPDX-License-Identifier: Apache-2.0 */
/* gpiod.h: lines of the kernel's GPIO chips, through libgpiod 1.6 or 2.x, whichever it was built with. */
#ifndef TTF_HAL_GPIOD_H
#define TTF_HAL_GPIOD_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/lines.h"

/*
 * Requests all lines; outputs in one step with their value, dark. A line by its name, or by its number on a named
 * chip. On failure none stays requested: -EINVAL, -ENOENT (no such chip or line), -EBUSY naming who holds it,
 * -EACCES, -ENOMEM.
 */
TTF_MUST_USE int ttf_lines_gpiod_create(const struct ttf_line_spec *specs, unsigned n,
                                        struct ttf_lines **ret, struct ttf_err *err);

/*
 * Who holds the line that spec names; it is looked up, not requested. 1 and its name, "" if it has none; 0: nobody.
 * -ENOENT (no such chip or line), -EACCES, -ENOMEM.
 */
TTF_MUST_USE int ttf_lines_gpiod_holder(const struct ttf_line_spec *spec, char ret_holder[64],
                                        struct ttf_err *err);

/* "1.6.3": of the library that is linked. Constant. */
const char *ttf_lines_gpiod_version(void);

#endif
