/* SPDX-License-Identifier: Apache-2.0 */
/* rig_uvc_picture.c: light to YUYV and back. */
#include <math.h>
#include <string.h>

#include "rig_uvc.h"

#define WHITE_EXPOSURE 1000 /* 0.1 ms */
#define GAIN_UNITY     64
#define BLACK          16
#define SPAN           219
#define MEAN           0.75 /* of the gradient */

static double coded(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static double decoded(double code)
{
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

static uint8_t within(double code, int least, int most)
{
    return (uint8_t)(code < least ? least : code > most ? most : lround(code));
}

void rig_uvc_picture(const struct rig_uvc_light *light, unsigned width, unsigned height,
                     uint8_t *ret)
{
    double level = (double)light->exposure * light->gain / (WHITE_EXPOSURE * GAIN_UNITY);
    double warm = (light->kelvin - 4600) / 100.0;
    uint8_t u = within(128 - warm, BLACK, 240), v = within(128 + warm, BLACK, 240);
    unsigned row = width * 2;

    for (unsigned x = 0; x < width; x++) {
        double here = level * (0.5 + 0.5 * x / (width - 1));

        ret[2 * x] = within(BLACK + SPAN * coded(here) + light->brightness, 0, 255);
        ret[2 * x + 1] = x % 2 ? v : u;
    }
    for (unsigned y = 1; y < height; y++)
        memcpy(ret + (size_t)y * row, ret, row);
}

double rig_uvc_mean(const uint8_t *yuyv, unsigned width, unsigned height, unsigned stride)
{
    double light[256], sum = 0;

    for (unsigned i = 0; i < 256; i++)
        light[i] = decoded(((double)i - BLACK) / SPAN);
    for (unsigned y = 0; y < height; y++)
        for (unsigned x = 0; x < width; x++)
            sum += light[yuyv[(size_t)y * stride + 2 * x]];
    return sum / ((double)width * height) / MEAN;
}
