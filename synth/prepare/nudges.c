/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From the middle frame outwards. A frame is held against an anchor, first the middle
 * one, for as long as it is like it; then its neighbour, as moved, becomes the anchor.
 * Held against their neighbours alone, frames would add up a small error at each step,
 * and what grows would walk off with the picture.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "prepare/nudges.h"

#define LIKE_ENOUGH 0.7 /* correlation below which a nearer anchor is taken */
#define ALIKE_AT_ALL \
    0.5            /* below it a shift is chance: found on pictures whose content itself moves */
#define WIDER 1.25 /* looked for beyond the limit, to tell that it was passed */

struct walk {
    struct ttf_sequence *input;
    double limit_px;
    struct shift *shifts;
    uint32_t unlike;
    struct gradients anchor, last; /* last: no planes if it is the anchor */
    struct shift anchor_shift, last_shift;
};

/* *ret: against the middle frame. */
static double hold(const struct walk *walk, const struct gradients *frame, double radius_px,
                   struct shift *ret)
{
    struct shift to = walk->anchor_shift, centre = {-to.x, -to.y};
    struct shift likely = {walk->last_shift.x - to.x, walk->last_shift.y - to.y};
    double alike = ttf_registration_find(&walk->anchor, frame, centre, radius_px, likely, ret);

    ret->x += to.x;
    ret->y += to.y;
    return alike;
}

static void last_becomes_anchor(struct walk *walk)
{
    if (!walk->last.planes)
        return;
    ttf_gradients_free(&walk->anchor);
    walk->anchor = walk->last;
    walk->anchor_shift = walk->last_shift;
    walk->last = (struct gradients){0};
}

/*
 * A frame that is like its neighbour nowhere within the limit either lies further away,
 * where it is like it, or shows something else: then nothing says that it was moved.
 */
static double find(struct walk *walk, const struct gradients *frame, struct shift *ret)
{
    double radius = walk->limit_px * WIDER + 1.0;
    double side = fmin(walk->input->width, walk->input->height);
    double alike = hold(walk, frame, radius, ret);

    if (alike < LIKE_ENOUGH && walk->last.planes) {
        last_becomes_anchor(walk);
        alike = hold(walk, frame, radius, ret);
    }
    if (alike > 0.0 && alike < ALIKE_AT_ALL)
        alike = hold(walk, frame, fmax(radius, side / 3.0), ret);
    if (alike < ALIKE_AT_ALL)
        *ret = walk->last_shift;
    return alike;
}

static int beyond(const struct walk *walk, uint32_t t, struct shift shift, struct ttf_err *err)
{
    ttf_err_set(err, -ERANGE, "stabilise",
                "frame %u lies %.1f, %.1f pixels from the middle frame, more than the limit of %g",
                t, shift.x, shift.y, walk->limit_px);
    ttf_err_hint(err, "raise the limit, or leave out the frames before or after it");
    return -ERANGE;
}

static int walk_to(struct walk *walk, uint32_t t, struct ttf_err *err)
{
    struct gradients frame;
    struct shift shift;
    double alike;
    int code = ttf_gradients_load(walk->input, t, &frame, err);

    if (code)
        return code;
    alike = find(walk, &frame, &shift);
    if (hypot(shift.x, shift.y) > walk->limit_px) {
        ttf_gradients_free(&frame);
        return beyond(walk, t, shift, err);
    }
    walk->shifts[t] = shift;
    walk->unlike += alike < ALIKE_AT_ALL;
    walk->last_shift = shift;
    if (alike > 0.0) {
        ttf_gradients_free(&walk->last);
        walk->last = frame;
    } else { /* a picture of nothing is no anchor */
        ttf_gradients_free(&frame);
    }
    return 0;
}

static int walk_from_middle(struct walk *walk, int direction, struct ttf_err *err)
{
    uint32_t middle = walk->input->n / 2;
    int code = ttf_gradients_load(walk->input, middle, &walk->anchor, err);

    walk->anchor_shift = walk->last_shift = (struct shift){0};
    for (uint32_t i = 1; !code; i++) {
        if (direction > 0 ? i >= walk->input->n - middle : i > middle)
            break;
        code = walk_to(walk, direction > 0 ? middle + i : middle - i, err);
    }
    ttf_gradients_free(&walk->anchor);
    ttf_gradients_free(&walk->last);
    return code;
}

int ttf_nudges_find(struct ttf_sequence *input, double limit_px, struct shift *ret,
                    uint32_t *ret_unlike, struct ttf_err *err)
{
    struct walk walk = {.input = input, .limit_px = limit_px, .shifts = ret};
    int code;

    ret[input->n / 2] = (struct shift){0};
    code = walk_from_middle(&walk, 1, err);
    if (!code)
        code = walk_from_middle(&walk, -1, err);
    if (!code)
        *ret_unlike = walk.unlike;
    return code;
}
