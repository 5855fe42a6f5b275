/* SPDX-License-Identifier: Apache-2.0 */
/* image_file_profile.c: whether a picture's ICC profile says anything but sRGB. */
#include <lcms2.h>
#include <stdlib.h>

#include "image_file_codecs.h"
#include "ttf/dataset/colour.h"

#define DIFFERENCE_MAX 3 /* 8-bit codes: makers of "sRGB" profiles differ by so much */

/* The display's code of what is stored as this one. */
static int shown(uint8_t code, bool linear)
{
    return linear ? (int)(ttf_srgb_encode((float)code / 255.0f) * 255.0f + 0.5f) : code;
}

/* Colours all over the cube, as RGB or as grey. */
static int worst_difference(cmsHTRANSFORM transform, bool grey, bool linear)
{
    int worst = 0;

    for (int r = 0; r <= 255; r += 51) {
        for (int g = 0; g <= 255; g += 51) {
            for (int b = 0; b <= 255; b += 51) {
                uint8_t in[3] = {(uint8_t)r, (uint8_t)(grey ? r : g), (uint8_t)(grey ? r : b)};
                uint8_t out[3] = {0};

                cmsDoTransform(transform, in, out, 1);
                for (int c = 0; c < 3; c++) {
                    int difference = abs(out[c] - shown(in[c], linear));

                    worst = difference > worst ? difference : worst;
                }
            }
        }
    }
    return worst;
}

static bool is_srgb(const void *profile, size_t bytes, bool grey, bool linear)
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
        same = worst_difference(transform, grey, linear) <= DIFFERENCE_MAX;
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

bool image_profile_is_srgb(const void *profile, size_t bytes, bool grey)
{
    return is_srgb(profile, bytes, grey, false);
}

bool image_profile_is_linear_srgb(const void *profile, size_t bytes, bool grey)
{
    return is_srgb(profile, bytes, grey, true);
}
