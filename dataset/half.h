/* SPDX-License-Identifier: Apache-2.0 */
/* half.h: IEEE 754 binary16, as f16 streams store it. For the room's files only. */
#ifndef TTF_DATASET_HALF_H
#define TTF_DATASET_HALF_H

#include <stdint.h>
#include <string.h>

static inline float ttf_half_to_float(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
    uint32_t exponent = half >> 10 & 31u, fraction = half & 1023u, bits;
    float value;

    if (exponent == 0) { /* zero or subnormal: fraction x 2^-24 */
        value = (float)fraction * (1.0f / 16777216.0f);
        return sign ? -value : value;
    }
    bits = sign | (exponent == 31 ? 255u : exponent + 112u) << 23 | fraction << 13;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

/* Shifts right, rounded to the nearest, of two equally near to the even one. */
static inline uint32_t ttf_half_shift(uint32_t value, unsigned by)
{
    uint32_t half = 1u << (by - 1), rest = value & (2 * half - 1);
    uint32_t whole = value >> by;

    return whole + (rest > half || (rest == half && (whole & 1u)));
}

/* To the nearest; beyond 65,504 infinity; not a number stays none. */
static inline uint16_t ttf_half_of_float(float value)
{
    uint32_t bits, fraction;
    uint16_t sign;
    int exponent;

    memcpy(&bits, &value, sizeof(bits));
    sign = (uint16_t)(bits >> 16 & 0x8000u);
    exponent = (int)(bits >> 23 & 255u) - 112; /* as a half counts it */
    fraction = bits & 0x7fffffu;
    if (exponent == 143)
        return (uint16_t)(sign | 0x7c00u | (fraction ? 0x200u : 0u));
    if (exponent >= 31)
        return (uint16_t)(sign | 0x7c00u);
    if (exponent > 0) /* a carry of the rounding raises the exponent, as it must */
        return (uint16_t)(sign | ttf_half_shift((uint32_t)exponent << 23 | fraction, 13));
    if (exponent < -10)
        return sign;
    return (uint16_t)(sign | ttf_half_shift(fraction | 0x800000u, (unsigned)(14 - exponent)));
}

#endif
