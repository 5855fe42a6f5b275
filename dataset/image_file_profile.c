/* SPDX-License-Identifier: Apache-2.0 */
/* image_file_profile.c: whether a picture's ICC profile says anything but sRGB. */
#include <lcms2.h>
#include <stdlib.h>

#include "image_file_codecs.h"

#define DIFFERENCE_MAX 3 /* 8-bit codes: makers of "sRGB" profiles differ by so much */

/* Colours all over the cube, as RGB or as grey. */
static int worst_difference(cmsHTRANSFORM transform, bool grey)
{
    int worst = 0;

    for (int r = 0; r <= 255; r += 51) {
        for (int g = 0; g <= 255; g += 51) {
            for (int b = 0; b <= 255; b += 51) {
                uint8_t in[3] = {(uint8_t)r, (uint8_t)(grey ? r : g), (uint8_t)(grey ? r : b)};
                uint8_t out[3] = {0};

                cmsDoTransform(transform, in, out, 1);
                for (int c = 0; c < 3; c++)
                    worst = abs(out[c] - in[c]) > worst ? abs(out[c] - in[c]) : worst;
            }
        }
    }
    return worst;
}

bool image_profile_is_srgb(const void *profile, size_t bytes, bool grey)
{
    cmsContext context = cmsCreateContext(NULL, NULL);
    cmsHPROFILE given = NULL, srgb = NULL;
    cmsHTRANSFORM transform = NULL;
    bool same = false;

    if (!context || bytes > UINT32_MAX)
        goto out;
    given = cmsOpenProfileFromMemTHR(context, profile, (cmsUInt32Number)bytes);
    srgb = cmsCreate_sRGBProfileTHR(context);
    if (!given || !srgb)
        goto out;
    transform = cmsCreateTransformTHR(context, given, grey ? TYPE_GRAY_8 : TYPE_RGB_8, srgb,
                                      TYPE_RGB_8, INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOCACHE);
    if (transform)
        same = worst_difference(transform, grey) <= DIFFERENCE_MAX;
out:
    if (transform)
        cmsDeleteTransform(transform);
    if (srgb)
        cmsCloseProfile(srgb);
    if (given)
        cmsCloseProfile(given);
    if (context)
        cmsDeleteContext(context);
    return same;
}
