/* SPDX-License-Identifier: Apache-2.0 */
/* The texture in the object's shadow, and the object over it (Enrique et al. 2005, figure 10). */
#include "ttf/synth/shadow.h"

#include <math.h>

#define TILE_ROWS 32

struct compose {
    const struct ttf_shadow *shadow;
    struct ttf_encoding encoding;
    uint16_t *codes;
};

static uint16_t rounded(double code)
{
    if (!(code > 0.0))
        return 0;
    return code < 65535.0 ? (uint16_t)lround(code) : 65535;
}

/* Light is what is above the pedestal: that is shaded and blended. */
static void compose_pixel(const struct compose *compose, size_t i)
{
    double alpha = (double)compose->shadow->alpha[i];
    double seen = (1.0 - alpha) * (double)compose->shadow->shade[i];
    const float *object = compose->shadow->object + 3 * i;
    uint16_t *code = compose->codes + 3 * i;

    for (int c = 0; c < 3; c++) {
        double light = (double)code[c] - compose->encoding.pedestal;

        code[c] = rounded(compose->encoding.pedestal + seen * light +
                          alpha * (double)object[c] * compose->encoding.scale);
    }
}

static void compose_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct compose *compose = ctx;
    uint32_t width = compose->shadow->width, height = compose->shadow->height;
    uint32_t y0 = tile * TILE_ROWS, y1 = height - y0 > TILE_ROWS ? y0 + TILE_ROWS : height;

    (void)worker;
    for (size_t i = (size_t)y0 * width; i < (size_t)y1 * width; i++)
        compose_pixel(compose, i);
}

void ttf_shadow_compose(const struct ttf_shadow *shadow, const struct ttf_encoding *encoding,
                        struct ttf_pool *pool, uint16_t *codes)
{
    struct compose compose = {.shadow = shadow, .encoding = *encoding};

    compose.codes = codes;
    ttf_pool_run(pool, (shadow->height + TILE_ROWS - 1) / TILE_ROWS, compose_tile, &compose);
}
