/* SPDX-License-Identifier: Apache-2.0 */
/*
 * strays.h: files here that the box's seal does not list: pictures whose line the box lost after it had served them, events of a box that has
 * none any more. Beside a seal they would be damage. One thread.
 */
#ifndef PULL_STRAYS_H
#define PULL_STRAYS_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

/* Renames each to NAME.tmp, which belongs to no dataset, on the disk too. sums: of a seal, its lines checked. *ret_n: so many were. */
TTF_MUST_USE int strays_put_aside(struct ttf_io *io, const char *folder, const char *sums,
                                  int64_t *ret_n, struct ttf_err *err);

#endif
