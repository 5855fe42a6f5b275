/* SPDX-License-Identifier: Apache-2.0 */
/* plain_stream.h: the one stream of a dataset that a test makes: 4 x 3 pixels, RGB of 16 bits. */
#ifndef TTF_TESTS_PLAIN_STREAM_H
#define TTF_TESTS_PLAIN_STREAM_H

#include <string.h>

#include "ttf/dataset/manifest.h"

static inline void plain_stream(struct ttf_manifest *manifest, const char *colour_space)
{
    struct ttf_stream *s = &manifest->streams[0];

    manifest->n_streams = 1;
    *s = (struct ttf_stream){.id = "main",
                             .quantity = "reflectance",
                             .unit = "1",
                             .width = 4,
                             .height = 3,
                             .samples = 3,
                             .format = TTF_SAMPLE_U16,
                             .encoding = {.pedestal = TTF_PEDESTAL, .scale = TTF_SCALE},
                             .primary = true};
    memcpy(s->colour_space, colour_space, strlen(colour_space) + 1);
}

#endif
