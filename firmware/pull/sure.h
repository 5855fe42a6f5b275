/* SPDX-License-Identifier: Apache-2.0 */
/* sure.h: texts that have no hash. A bit that turned over on the way would stay: nobody could tell later. One thread. */
#ifndef PULL_SURE_H
#define PULL_SURE_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "wire.h"

/* What is here, which needs no second word. bytes NULL: nothing is. */
struct sure_known {
    const char *bytes;
    size_t n;
};

/*
 * As pull_wire_get_text; what is not what is known comes twice, the same. -ECONNRESET: it did not, since it changes, or the wire does.
 */
TTF_MUST_USE int sure_text(struct wire *wire, const char *path, int64_t first, int64_t last,
                           size_t max, const struct sure_known *known, char **ret_text,
                           size_t *ret_bytes, struct ttf_err *err);

#endif
