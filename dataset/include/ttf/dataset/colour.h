/* SPDX-License-Identifier: Apache-2.0 */
/*
 * colour.h: between display-encoded sRGB and linear light.
 *
 * Tables are built without libm, so that the same bits come out on every
 * machine. Linear light is of sRGB/Rec.709 primaries unless said otherwise.
 */
#ifndef TTF_DATASET_COLOUR_H
#define TTF_DATASET_COLOUR_H

#include <stddef.h>
#include <stdint.h>

/* 8-bit sRGB code -> linear 16-bit code (65535 = 1.0). A bijection onto its image: decoding comes back to the bit. */
uint16_t ttf_srgb8_to_linear16(uint8_t code);
uint8_t ttf_linear16_to_srgb8(uint16_t linear);

/* The whole curve for other uses: linear 0..1 -> encoded 0..1 and back, exact to 1e-6. */
float ttf_srgb_encode(float linear);
float ttf_srgb_decode(float encoded);

/* Rec.709 luminance of linear R, G, B. */
static inline float ttf_luminance(float r, float g, float b)
{
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

/*
 * How a stream's codes mean something: value = (code - pedestal) / scale, value
 * 1 = a perfect diffuser. Imported 8-bit sRGB: pedestal 0, scale 65535.
 * Captured: TTF_PEDESTAL and TTF_SCALE, one stop of headroom.
 */
struct ttf_encoding {
    double pedestal;
    double scale;
};

#define TTF_PEDESTAL 2047
#define TTF_SCALE    31744

/* Display code (8-bit sRGB, values clipped to 0..1) of a 16-bit code under an encoding. */
uint8_t ttf_display8(const struct ttf_encoding *encoding, uint16_t code);

/* Fills a table of all 65,536 display codes: what loops over pixels use. */
void ttf_display8_table(const struct ttf_encoding *encoding, uint8_t ret[65536]);

#endif
