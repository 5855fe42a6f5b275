/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rank_rotate.h: the rotation of coefficients in GCC vector types, compiled once per
 * instruction set; all is static. Lanes are the output's numbers, so that each is
 * summed in the order of the scalar reference.
 */
#ifndef TTF_SYNTH_SEARCH_RANK_ROTATE_H
#define TTF_SYNTH_SEARCH_RANK_ROTATE_H

#include <stddef.h>
#include <string.h>

typedef float ttf_rotate_v8 __attribute__((vector_size(32)));

/* Eight numbers of four pixels. */
static inline void rotate_8(const float *w, size_t dims, size_t room, const float *in,
                            size_t in_stride, float *out)
{
    ttf_rotate_v8 a = {0}, b = {0}, c = {0}, d = {0};

    for (size_t i = 0; i < dims; i++) {
        ttf_rotate_v8 row;

        memcpy(&row, w + i * room, sizeof(row));
        a += row * in[i];
        b += row * in[in_stride + i];
        c += row * in[2 * in_stride + i];
        d += row * in[3 * in_stride + i];
    }
    memcpy(out, &a, sizeof(a));
    memcpy(out + room, &b, sizeof(b));
    memcpy(out + 2 * room, &c, sizeof(c));
    memcpy(out + 3 * room, &d, sizeof(d));
}

__attribute__((unused)) static void rotate4(const float *w, size_t dims, size_t room,
                                            const float *in, size_t in_stride, float *out)
{
    for (size_t r = 0; r < room; r += 8)
        rotate_8(w + r, dims, room, in, in_stride, out + r);
}

#endif
