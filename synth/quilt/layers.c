/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/layers.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int ttf_layers_begin(struct ttf_layers *layers, size_t pixels)
{
    layers->layered = calloc(pixels, 1);
    return layers->layered ? 0 : -ENOMEM;
}

void ttf_layers_free(struct ttf_layers *layers)
{
    free(layers->list);
    free(layers->layered);
    memset(layers, 0, sizeof(*layers));
}

static int push(struct ttf_layers *layers, uint32_t pixel, uint32_t source, uint32_t block,
                uint32_t weight)
{
    if (layers->n == layers->room) {
        size_t room = layers->room ? 2 * layers->room : 1024;
        struct ttf_quilt_layer *list = realloc(layers->list, room * sizeof(*list));

        if (!list)
            return -ENOMEM;
        layers->list = list;
        layers->room = room;
    }
    layers->list[layers->n++] = (struct ttf_quilt_layer){pixel, source, weight, block};
    return 0;
}

int ttf_layers_add(struct ttf_layers *layers, uint32_t pixel, uint32_t before,
                   uint32_t before_block, uint32_t source, uint32_t block, uint32_t weight)
{
    int r;

    if (weight == 0 || (weight == 65536 && !layers->layered[pixel]))
        return 0;
    if (!layers->layered[pixel]) {
        layers->layered[pixel] = 1;
        r = push(layers, pixel, before, before_block, 65536);
        if (r < 0)
            return r;
    }
    return push(layers, pixel, source, block, weight);
}

uint32_t ttf_layers_weight(uint32_t index, uint32_t cut, uint32_t width, uint32_t feather)
{
    /* In half pixels: the ramp reaches `half` to either side of the cut. */
    int64_t half = feather;
    int64_t distance = 2 * (int64_t)index + 1 - 2 * (int64_t)cut;

    if (half > 2 * (int64_t)cut)
        half = 2 * (int64_t)cut;
    if (half > 2 * ((int64_t)width - cut))
        half = 2 * ((int64_t)width - cut);
    if (distance >= half)
        return 65536;
    if (distance <= -half)
        return 0;
    return (uint32_t)(32768 + distance * 32768 / half);
}
