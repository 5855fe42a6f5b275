/* SPDX-License-Identifier: Apache-2.0 */
#include "develop_rows.h"

void develop_correct(const uint32_t *restrict sum, const int32_t *restrict dark_16,
                     const uint16_t *restrict gain, size_t n, float mean, float black, float level,
                     float *restrict ret)
{
    if (dark_16) {
        for (size_t i = 0; i < n; i++)
            ret[i] = (float)sum[i] * mean - black - (float)dark_16[i] * 0.0625f;
    } else {
        for (size_t i = 0; i < n; i++)
            ret[i] = (float)sum[i] * mean - black;
    }
    if (gain) {
        level *= 1.0f / 16384.0f; /* a power of two: exact */
        for (size_t i = 0; i < n; i++)
            ret[i] = ret[i] * ((float)gain[i] * level);
    } else {
        for (size_t i = 0; i < n; i++)
            ret[i] = ret[i] * level;
    }
}

void develop_demosaic(const struct develop_window *window, bool own_first, size_t n,
                      float *restrict own, float *restrict green, float *restrict other)
{
    const float *restrict up2 = window->row[0], *restrict up = window->row[1];
    const float *restrict at = window->row[2];
    const float *restrict down = window->row[3], *restrict down2 = window->row[4];
    uint32_t own_parity = own_first ? 0 : 1;

    /* All four estimates everywhere and then a choice: cheaper than two loops with gaps. */
    for (ptrdiff_t x = 0; x < (ptrdiff_t)n; x++) {
        float centre = at[x];
        float sides = at[x - 1] + at[x + 1], far_sides = at[x - 2] + at[x + 2];
        float ends = up[x] + down[x], far_ends = up2[x] + down2[x];
        float corners = (up[x - 1] + up[x + 1]) + (down[x - 1] + down[x + 1]);

        /* green at red or blue */
        float g = (4.0f * centre + 2.0f * (sides + ends) - (far_sides + far_ends)) * 0.125f;
        /* at green: the colour of its sides, and of its ends */
        float s = (5.0f * centre + 4.0f * sides - corners - far_sides + 0.5f * far_ends) * 0.125f;
        float e = (5.0f * centre + 4.0f * ends - corners - far_ends + 0.5f * far_sides) * 0.125f;
        /* red at blue, blue at red */
        float d = (6.0f * centre + 2.0f * corners - 1.5f * (far_sides + far_ends)) * 0.125f;
        bool is_own = (((uint32_t)x ^ own_parity) & 1u) == 0;

        own[x] = is_own ? centre : s;
        green[x] = is_own ? g : centre;
        other[x] = is_own ? d : e;
    }
}

void develop_matrix(const float matrix[9], float *restrict r, float *restrict g, float *restrict b,
                    size_t n)
{
    float m0 = matrix[0], m1 = matrix[1], m2 = matrix[2];
    float m3 = matrix[3], m4 = matrix[4], m5 = matrix[5];
    float m6 = matrix[6], m7 = matrix[7], m8 = matrix[8];

    for (size_t i = 0; i < n; i++) {
        float red = r[i], green = g[i], blue = b[i];

        r[i] = m0 * red + m1 * green + m2 * blue;
        g[i] = m3 * red + m4 * green + m5 * blue;
        b[i] = m6 * red + m7 * green + m8 * blue;
    }
}

/* Clipped before the conversion, which is undefined beyond the range; a NaN gives 0. */
static inline uint16_t code_of(float value, float scale, float pedestal)
{
    float code = value * scale + pedestal + 0.5f;

    code = code > 0.0f ? code : 0.0f;
    code = code < 65535.0f ? code : 65535.0f;
    return (uint16_t)(int32_t)code;
}

void develop_encode(const float *restrict r, const float *restrict g, const float *restrict b,
                    size_t n, float scale, float pedestal, uint16_t *restrict ret)
{
    for (size_t i = 0; i < n; i++) {
        ret[3 * i] = code_of(r[i], scale, pedestal);
        ret[3 * i + 1] = code_of(g[i], scale, pedestal);
        ret[3 * i + 2] = code_of(b[i], scale, pedestal);
    }
}
