/* SPDX-License-Identifier: Apache-2.0 */
/* fit.c: how large a panel's pictures may be, from a few of them made for trial. */
#include <errno.h>

#include "panel.h"

#define PIXELS_MAX UINT64_C(48000000) /* of all frames: 192 MB of a graphics card's memory */
#define SIDE_LEAST 16u
#define TRIALS     6    /* frames of a trial, evenly spread */
#define RESERVE    1.08 /* other frames compress less well */
#define ROUNDS_MAX 10
#define CLOSE      0.93 /* of the room: near enough */

/* A factor that is no cube's root: without libm, the same bits everywhere. */
static double root(double x)
{
    double r = x > 1.0 ? x : 1.0;

    for (int i = 0; i < 60; i++)
        r = 0.5 * (r + x / r);
    return r;
}

static uint32_t scaled(uint32_t side, double factor)
{
    double s = (double)side * factor + 0.5;

    return s < 1.0 ? 1 : (uint32_t)s;
}

bool view_panel_shrink(struct view_panel *panel, double factor)
{
    uint32_t width = scaled(panel->width, factor), height = scaled(panel->height, factor);

    if ((width < SIDE_LEAST && height < SIDE_LEAST) ||
        (width == panel->width && height == panel->height))
        return false;
    panel->width = width;
    panel->height = height;
    return true;
}

/* What pictures of the present size would take as base64, from some of them. */
static int estimate(struct view_panel *panel, double *ret, struct ttf_err *err)
{
    uint32_t trials = panel->n < TRIALS ? panel->n : TRIALS;
    int64_t sum = 0;

    for (uint32_t done = 0; done < trials;) {
        uint32_t frames[TRIALS];
        unsigned n = 0;
        int code;

        for (; n < panel->n_slots && done + n < trials; n++)
            frames[n] =
                panel->frame[trials > 1 ? (uint64_t)(done + n) * (panel->n - 1) / (trials - 1) : 0];
        code = view_panel_pictures(panel, frames, n, err);
        if (code)
            return code;
        for (unsigned i = 0; i < n; i++)
            sum += (int64_t)panel->slot[i].picture.bytes + 64;
        done += n;
    }
    *ret = (double)sum / trials * panel->n * 4.0 / 3.0 * (panel->n > trials ? RESERVE : 1.0);
    return 0;
}

static void resize(struct view_panel *panel, double factor)
{
    panel->width = scaled(panel->texture->sequence->width, factor);
    panel->height = scaled(panel->texture->sequence->height, factor);
}

/*
 * The largest share of the full size that fits, between one that does and one that does not. What is
 * shrunk compresses otherwise than before, so each guess from the last one's bytes is only a guess.
 */
static int search(struct view_panel *panel, double factor, double bytes, struct ttf_err *err)
{
    double fits = 0, over = factor, taken;

    for (int round = 0; round < ROUNDS_MAX; round++) {
        int code;

        resize(panel, factor);
        code = estimate(panel, &taken, err);
        if (code)
            return code;
        if (taken <= bytes) {
            fits = factor;
            if (taken >= CLOSE * bytes || fits >= over)
                return 0;
        } else {
            over = factor;
        }
        factor *= root(bytes / taken * 0.98);
        if (factor <= fits || factor >= over)
            factor = 0.5 * (fits + over);
    }
    if (fits == 0 || (panel->width < SIDE_LEAST && panel->height < SIDE_LEAST)) {
        ttf_err_set(err, -EFBIG, NULL, "%u frames do not fit into the file at any size", panel->n);
        ttf_err_hint(err, "take fewer frames");
        return -EFBIG;
    }
    resize(panel, fits);
    return 0;
}

int view_panel_fit(struct view_panel *panel, const struct ttf_view_config *config, int64_t bytes,
                   struct ttf_err *err)
{
    const struct ttf_sequence *s = panel->texture->sequence;
    uint32_t most = config->side_max ? config->side_max : TTF_VIEW_SIDE_MAX;
    uint32_t side = s->width > s->height ? s->width : s->height;
    double pixels = (double)s->width * s->height * panel->n, taken;
    double factor = side > most ? (double)most / side : 1.0;
    int code;

    if (pixels * factor * factor > (double)PIXELS_MAX)
        factor = root((double)PIXELS_MAX / pixels);
    resize(panel, factor);
    panel->exact = true;
    code = estimate(panel, &taken, err);
    if (code || taken <= (double)bytes)
        return code;
    panel->exact = false;
    return search(panel, factor, (double)bytes, err);
}
