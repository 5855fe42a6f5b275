/* SPDX-License-Identifier: Apache-2.0 */
#include "exported.h"

const struct ttf_encoding plain_light = {.pedestal = 0, .scale = 65535};

void fill_noise(uint16_t *frames, uint32_t width, uint32_t height, unsigned n)
{
    size_t codes = (size_t)width * height * 3;

    for (unsigned t = 0; t < n; t++) {
        struct ttf_pixbuf noise = make_picture(width, height, 3, TTF_SAMPLE_U8, t + 1);

        for (size_t i = 0; i < codes; i++)
            frames[t * codes + i] = ttf_srgb8_to_linear16(((uint8_t *)noise.data)[i]);
        ttf_pixbuf_free(&noise);
    }
}

struct ttf_export_result export_ok(struct ttf_sequence *s, const struct ttf_export_config *config)
{
    struct ttf_export_result result = {0};
    struct ttf_err err = {0};

    if (ttf_export(s, ttf_io_posix(), config, &result, &err))
        fail_msg("%s: %s; %s", err.where, err.what, err.hint);
    return result;
}
