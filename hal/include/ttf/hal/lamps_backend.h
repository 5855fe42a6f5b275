/* SPDX-License-Identifier: Apache-2.0 */
/* lamps_backend.h: what the author of a lamps back-end implements. All ops are mandatory. */
#ifndef TTF_HAL_LAMPS_BACKEND_H
#define TTF_HAL_LAMPS_BACKEND_H

#include "ttf/hal/lamps.h"

struct ttf_lamps_ops {
    const char *name; /* "sim", "lampd", "none" */
    int (*acquire)(struct ttf_lamps *lamps, int64_t alive_until_ns, struct ttf_err *err);
    int (*alive)(struct ttf_lamps *lamps, int64_t alive_until_ns, struct ttf_err *err);
    int (*set)(struct ttf_lamps *lamps, unsigned i, unsigned permille, struct ttf_err *err);
    int (*state)(struct ttf_lamps *lamps, unsigned i, struct ttf_lamp_state *ret);
    int (*clear)(struct ttf_lamps *lamps, unsigned i, struct ttf_err *err);
    void (*release)(struct ttf_lamps *lamps);
    void (*destroy)(struct ttf_lamps *lamps);
};

/* The level nearest to `permille` that a lamp of this kind can do (see ttf_lamps_set). */
unsigned ttf_lamp_round(const struct ttf_lamp_info *info, unsigned permille);

/* Embedded first in the back-end's own struct. */
struct ttf_lamps {
    const struct ttf_lamps_ops *ops;
    unsigned n;
    struct ttf_lamp_info info[TTF_LAMPS_MAX];
};

#endif
