/* SPDX-License-Identifier: Apache-2.0 */
/* wires.c: see wires.h. */
#include "wires.h"

#include <string.h>

#include "ttf/hal/gpiod.h"
#include "ttf/hal/pwm.h"

static unsigned pick(const struct ttf_board_guardian *g, bool pwm,
                     struct ttf_line_spec ret[TTF_LINES_MAX])
{
    unsigned n = 0;

    for (unsigned i = 0; i < g->n_wires; i++)
        if ((g->wires[i].period_ns > 0) == pwm)
            ret[n++] = g->wires[i];
    return n;
}

static int open_plain(const struct ttf_board *board, const struct ttf_line_spec *specs, unsigned n,
                      struct ttf_lines **ret, struct ttf_err *err)
{
    if (strcmp(board->device[TTF_DEVICE_LAMPS]->name, "file") == 0)
        return ttf_lines_file_create(board->guardian.file, specs, n, ret, err);
    return ttf_lines_gpiod_create(specs, n, ret, err);
}

int lampd_wires_open(const struct ttf_board *board, const char *sys, struct ttf_lines **ret,
                     struct ttf_err *err)
{
    const struct ttf_board_guardian *g = &board->guardian;
    struct ttf_line_spec plain[TTF_LINES_MAX], dimmed[TTF_LINES_MAX];
    unsigned n_plain = pick(g, false, plain), n_dimmed = pick(g, true, dimmed);
    struct ttf_lines *a = NULL, *b = NULL;
    int r = n_plain > 0 ? open_plain(board, plain, n_plain, &a, err) : 0;

    if (n_dimmed > 0) { /* also where the others failed: what can be dark is */
        int pwm = ttf_lines_pwm_create(sys, dimmed, n_dimmed, &b, r == 0 ? err : NULL);

        r = r < 0 ? r : pwm;
    }
    if (r == 0 && a && b)
        r = ttf_lines_joined_create(g->wires, g->n_wires, (struct ttf_lines *[]){a, b}, 2, ret,
                                    err);
    else if (r == 0)
        *ret = a ? a : b;
    if (r < 0) {
        ttf_lines_destroy(a);
        ttf_lines_destroy(b);
    }
    return r;
}
