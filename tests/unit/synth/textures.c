/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>

#include "textures.h"

const struct ttf_encoding texture_encoding = {0.0, 65535.0};

uint32_t texture_hash(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t x = a * 0x9e3779b1u ^ b * 0x85ebca77u ^ c * 0xc2b2ae3du;

    x ^= x >> 15;
    x *= 0x2c1b3c6du;
    x ^= x >> 12;
    x *= 0x297a2d39u;
    return x ^ x >> 15;
}

/* Random values on a lattice of step `cell`, interpolated: 0..255. */
static int smooth(uint32_t x, uint32_t y, uint32_t cell, uint32_t key)
{
    uint32_t i = x / cell, j = y / cell, u = x % cell, v = y % cell;
    uint32_t a = texture_hash(i, j, key) & 255, b = texture_hash(i + 1, j, key) & 255;
    uint32_t c = texture_hash(i, j + 1, key) & 255, d = texture_hash(i + 1, j + 1, key) & 255;

    return (int)(((a * (cell - u) + b * u) * (cell - v) + (c * (cell - u) + d * u) * v) /
                 (cell * cell));
}

static int spots(uint32_t x, uint32_t y, uint32_t t, uint32_t n, uint32_t c)
{
    int ground = 60 + smooth(x, y, 5, c) / 4;
    int pace = smooth(x, y, 9, 7);
    int grown = pace * 2 * (int)t / (int)n - 60;
    int noise = (int)(texture_hash(x + 1000 * t, y, c + 50) % 5) - 2;

    return ground + (grown > 0 ? (c == 1 ? grown : grown / 2) : 0) + noise;
}

static int value(enum texture texture, uint32_t x, uint32_t y, uint32_t t, uint32_t n, uint32_t c)
{
    int v = 0;

    switch (texture) {
    case TEXTURE_SPOTS:
        v = spots(x, y, t, n, c);
        break;
    case TEXTURE_NOISE:
        v = (int)(texture_hash(x + 4096 * y, t, c) & 255);
        break;
    case TEXTURE_CONSTANT:
        v = 90 + 20 * (int)c;
        break;
    case TEXTURE_OBJECT:
        v = x >= 13 && x < 22 && y >= 10 && y < 24 ? spots(x, y, t, n, c) : 255;
        break;
    case TEXTURE_STRIPES:
        v = 20 * (int)(x % 8) + 5 * (int)t + 10 * (int)c;
        break;
    }
    return v < 0 ? 0 : v > 255 ? 255 : v;
}

struct texture_sequence texture_make(enum texture texture, uint32_t width, uint32_t height,
                                     uint32_t n)
{
    struct texture_sequence made = {0};
    uint16_t *at = malloc((size_t)n * height * width * 3 * sizeof(*at));

    assert_non_null(at);
    made.codes = at;
    for (uint32_t t = 0; t < n; t++) {
        for (uint32_t i = 0; i < width * height * 3; i++)
            *at++ = ttf_srgb8_to_linear16(
                (uint8_t)value(texture, i / 3 % width, i / 3 / width, t, n, i % 3));
    }
    /* NOLINTNEXTLINE(clang-analyzer-unix.Malloc): texture_free frees it; a failed assertion ends the test */
    assert_int_equal(ttf_sequence_of_memory(made.codes, width, height, n, &texture_encoding,
                                            &made.sequence, NULL),
                     0);
    return made;
}

void texture_free(struct texture_sequence *texture)
{
    ttf_sequence_destroy(texture->sequence);
    free(texture->codes);
}
