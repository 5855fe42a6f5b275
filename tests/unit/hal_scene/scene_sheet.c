/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a procedural scene to look at: scene_sheet NAME SEED WIDTH HEIGHT PHASE... > picture.ppm
 * Pictures of all phases one below the other, sRGB. Not a test.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "ttf/hal/sim.h"

static uint8_t to_srgb(float x)
{
    const double c = x < 0.0f ? 0.0 : x > 1.0f ? 1.0 : (double)x;
    const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1.0 / 2.4) - 0.055;

    return (uint8_t)(s * 255.0 + 0.5);
}

int main(int argc, char **argv)
{
    struct ttf_scene scene;
    struct ttf_err err = {0};
    char text[512];
    uint32_t w, h;
    float *rgb;

    if (argc < 6) {
        fprintf(stderr, "usage: scene_sheet NAME SEED WIDTH HEIGHT PHASE...\n");
        return 2;
    }
    w = (uint32_t)strtoul(argv[3], NULL, 10);
    h = (uint32_t)strtoul(argv[4], NULL, 10);
    if (ttf_scene_procedural(argv[1], strtoull(argv[2], NULL, 10), INT64_C(1000000000), &scene,
                             &err) < 0) {
        fprintf(stderr, "%s\n", ttf_err_text(&err, text, sizeof(text)));
        return 2;
    }
    rgb = malloc((size_t)w * h * 3 * sizeof(*rgb));
    printf("P6\n%u %u\n255\n", w, h * (uint32_t)(argc - 5));
    for (int i = 5; rgb && i < argc; i++) {
        const int64_t t = (int64_t)(strtod(argv[i], NULL) * 1e9);

        if (scene.ops->render(scene.priv, t, w, h, rgb, &err) < 0)
            return 1;
        for (size_t k = 0; k < (size_t)w * h * 3; k++)
            putchar(to_srgb(rgb[k]));
    }
    free(rgb);
    scene.ops->destroy(scene.priv);
    return 0;
}
