/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prepare/derived.h"
#include "prepare/nudges.h"
#include "ttf/base/checked.h"
#include "ttf/synth/prepare.h"

#define LEFT_ALONE_PX 0.1
#define FRACTION      256 /* of a pixel: what weights are rounded to */

/* Where a frame is read: whole pixels, and 256ths beyond them. */
struct move {
    int32_t x, y;
    uint16_t u, v;
};

struct stabilise {
    struct derived derived; /* first: downcast by address */
    uint32_t crop_x, crop_y;
    struct move *move; /* n */
};

static bool is_moved(struct shift shift)
{
    return hypot(shift.x, shift.y) >= LEFT_ALONE_PX;
}

static struct move move_of(struct shift shift)
{
    long x = lround(shift.x * FRACTION), y = lround(shift.y * FRACTION);
    long fx = ((x % FRACTION) + FRACTION) % FRACTION, fy = ((y % FRACTION) + FRACTION) % FRACTION;

    return (struct move){(int32_t)((x - fx) / FRACTION), (int32_t)((y - fy) / FRACTION),
                         (uint16_t)fx, (uint16_t)fy};
}

/* Pixels beyond the border that a move along one axis reaches, to whichever side. */
static uint32_t reach(int32_t whole, uint16_t fraction)
{
    int32_t most = fraction > 0 && whole >= 0 ? whole + 1 : whole;

    return (uint32_t)(most < 0 ? -most : most);
}

/* Four neighbours by weights that add up to 65536: the sum fits 32 bits, and equal ones come out as they are. */
static void blend_row(const uint16_t *above, const uint16_t *below, const struct move *move,
                      size_t samples, uint16_t *dst)
{
    uint32_t u = move->u, v = move->v;
    uint32_t w[4] = {(FRACTION - u) * (FRACTION - v), u * (FRACTION - v), (FRACTION - u) * v,
                     u * v};
    /* a neighbour that does not count may lie beyond the row */
    size_t next = u > 0 ? 3 : 0;

    for (size_t i = 0; i < samples; i++)
        dst[i] = (uint16_t)((above[i] * w[0] + above[i + next] * w[1] + below[i] * w[2] +
                             below[i + next] * w[3] + 32768u) >>
                            16);
}

static int stabilise_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0,
                               uint32_t rows, uint16_t *dst, struct ttf_err *err)
{
    const struct stabilise *stabilise = (const struct stabilise *)sequence;
    struct ttf_sequence *input = stabilise->derived.input;
    size_t from = (size_t)input->width * 3, to = (size_t)sequence->width * 3;
    const struct move *move;
    uint32_t first, extra;
    uint16_t *codes;
    int code = derived_check_rows(sequence, t, y0, rows, err);

    if (code || rows == 0)
        return code;
    move = &stabilise->move[t];
    extra = move->v > 0;
    first = (uint32_t)((int64_t)y0 + stabilise->crop_y + move->y);
    if (from == to && move->u == 0 && move->v == 0)
        return ttf_sequence_read_rows(input, t, first, rows, dst, err);
    codes = malloc(from * ((size_t)rows + extra) * sizeof(*codes));
    if (!codes)
        return ttf_err_set(err, -ENOMEM, "stabilise", "no memory for %u rows of %u pixels", rows,
                           input->width);
    code = ttf_sequence_read_rows(input, t, first, rows + extra, codes, err);
    for (uint32_t y = 0; y < rows && !code; y++) {
        const uint16_t *row = codes + y * from + (size_t)((int64_t)stabilise->crop_x + move->x) * 3;

        blend_row(row, row + extra * from, move, to, dst + y * to);
    }
    free(codes);
    return code;
}

static void stabilise_destroy(struct ttf_sequence *sequence)
{
    struct stabilise *stabilise = (struct stabilise *)sequence;

    free(stabilise->move);
    free(stabilise);
}

static const struct ttf_sequence_ops stabilise_ops = {
    .read_rows = stabilise_read_rows,
    .destroy = stabilise_destroy,
};

/* Frame t's content lies at p + shift: it is read there. */
static void set_moves(struct stabilise *stabilise, const struct shift *shifts,
                      struct ttf_stabilise_figures *ret)
{
    struct ttf_sequence *base = &stabilise->derived.base;

    for (uint32_t t = 0; t < base->n; t++) {
        struct move *move = &stabilise->move[t];
        double length = hypot(shifts[t].x, shifts[t].y);
        uint32_t x, y;

        ret->largest_shift_px = fmax(ret->largest_shift_px, length);
        if (!is_moved(shifts[t]))
            continue;
        *move = move_of(shifts[t]);
        x = reach(move->x, move->u);
        y = reach(move->y, move->v);
        ret->crop_x = x > ret->crop_x ? x : ret->crop_x;
        ret->crop_y = y > ret->crop_y ? y : ret->crop_y;
        ret->moved++;
    }
    stabilise->crop_x = ret->crop_x;
    stabilise->crop_y = ret->crop_y;
    base->width -= 2 * ret->crop_x;
    base->height -= 2 * ret->crop_y;
}

static int check_limit(const struct ttf_sequence *input, double *limit_px, struct ttf_err *err)
{
    uint32_t side = input->width < input->height ? input->width : input->height;

    if (side < REGISTRATION_LEAST_SIDE)
        return ttf_err_set(err, -EINVAL, "stabilise",
                           "pictures of %u x %u are too small to be held against each other",
                           input->width, input->height);
    if (*limit_px == 0.0)
        *limit_px = side / 16.0;
    if (!(*limit_px > 0.0) || *limit_px > side / 4.0) {
        ttf_err_set(err, -EINVAL, "limit",
                    "a shift's limit must be above 0 and within %u pixels here, not %g", side / 4,
                    *limit_px);
        ttf_err_hint(err, "0 means a 16th of the smaller side");
        return -EINVAL;
    }
    return 0;
}

int ttf_stabilise_create(struct ttf_sequence *input, double limit_px, struct ttf_sequence **ret,
                         struct ttf_stabilise_figures *ret_figures, struct ttf_err *err)
{
    struct ttf_stabilise_figures figures = {0};
    struct stabilise *stabilise;
    struct shift *shifts;
    int code = check_limit(input, &limit_px, err);

    if (code)
        return code;
    stabilise = calloc(1, sizeof(*stabilise));
    shifts = calloc(input->n, sizeof(*shifts));
    if (stabilise)
        stabilise->move = calloc(input->n, sizeof(*stabilise->move));
    if (!stabilise || !shifts || !stabilise->move) {
        code = ttf_err_set(err, -ENOMEM, "stabilise", "no memory for the shifts of %u frames",
                           input->n);
        goto out;
    }
    code = ttf_nudges_find(input, limit_px, shifts, &figures.unlike, err);
    if (code)
        goto out;
    stabilise->derived = derived_from(input, &stabilise_ops);
    set_moves(stabilise, shifts, &figures);
    *ret = &stabilise->derived.base;
    if (ret_figures)
        *ret_figures = figures;
    stabilise = NULL;
out:
    free(shifts);
    if (stabilise)
        stabilise_destroy(&stabilise->derived.base);
    return code;
}
