/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/icc.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <lcms2.h>
#include <lcms2_plugin.h>

/* In the header of a profile (ICC.1:2010, table 17). */
#define DATE_OFFSET 24
#define DATE_BYTES  12

/* Twelve bytes: year, month, day, hour, minute, second. Fixed: a file's bits tell its picture, not its day. */
static const uint8_t fixed_date[DATE_BYTES] = {0x07, 0xea, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0};

/*
 * Each context here is of one call and one thread. Without these, a profile gets a mutex, and
 * lcms2 writes into it also where it got no memory for one.
 */
static void *create_no_mutex(cmsContext context)
{
    return context;
}

static void destroy_no_mutex(cmsContext context, void *mutex)
{
}

static cmsBool lock_no_mutex(cmsContext context, void *mutex)
{
    return TRUE;
}

static void unlock_no_mutex(cmsContext context, void *mutex)
{
}

/* NULL: no memory. */
static cmsContext create_context(void)
{
    cmsPluginMutex plugin = {
        .base = {.Magic = cmsPluginMagicNumber, .ExpectedVersion = 2060, .Type = cmsPluginMutexSig},
        .CreateMutexPtr = create_no_mutex,
        .DestroyMutexPtr = destroy_no_mutex,
        .LockMutexPtr = lock_no_mutex,
        .UnlockMutexPtr = unlock_no_mutex};

    return cmsCreateContext(&plugin, NULL);
}

static cmsToneCurve *tone_curve(cmsContext context, enum ttf_icc icc)
{
    /* sRGB as ICC type 4: ((x + 0.055) / 1.055)^2.4 from 0.04045 on, else x / 12.92. */
    static const cmsFloat64Number srgb[5] = {2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045};

    if (icc == TTF_ICC_LINEAR)
        return cmsBuildGamma(context, 1.0);
    return cmsBuildParametricToneCurve(context, 4, srgb);
}

static cmsHPROFILE build(cmsContext context, enum ttf_icc icc, uint32_t samples)
{
    static const cmsCIExyY d65 = {0.3127, 0.3290, 1.0};
    static const cmsCIExyYTRIPLE rec709 = {
        {0.6400, 0.3300, 1.0}, {0.3000, 0.6000, 1.0}, {0.1500, 0.0600, 1.0}};
    cmsToneCurve *curve = tone_curve(context, icc);
    cmsToneCurve *curves[3] = {curve, curve, curve};
    cmsHPROFILE profile;

    if (!curve)
        return NULL;
    if (samples < 3)
        profile = cmsCreateGrayProfileTHR(context, &d65, curve);
    else
        profile = cmsCreateRGBProfileTHR(context, &d65, &rec709, curves);
    cmsFreeToneCurve(curve);
    return profile;
}

static bool describe(cmsContext context, cmsHPROFILE profile, const char *text)
{
    cmsMLU *mlu = cmsMLUalloc(context, 1);
    bool done = mlu && cmsMLUsetASCII(mlu, "en", "US", text) &&
                cmsWriteTag(profile, cmsSigProfileDescriptionTag, mlu);

    cmsMLUfree(mlu);
    return done;
}

static const char *profile_title(enum ttf_icc icc, uint32_t samples)
{
    if (icc == TTF_ICC_LINEAR)
        return samples < 3 ? "Linear grey" : "Linear sRGB";
    return samples < 3 ? "sRGB grey" : "sRGB";
}

int ttf_icc_create(enum ttf_icc icc, uint32_t samples, uint8_t **ret, size_t *ret_bytes,
                   struct ttf_err *err)
{
    cmsContext context;
    cmsHPROFILE profile = NULL;
    cmsUInt32Number n = 0;
    uint8_t *bytes = NULL;
    int r = -ENOMEM;

    if (icc == TTF_ICC_NONE) {
        *ret = NULL;
        *ret_bytes = 0;
        return 0;
    }
    context = create_context();
    if (!context)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a colour profile");
    profile = build(context, icc, samples);
    if (!profile || !describe(context, profile, profile_title(icc, samples)))
        goto out;
    if (!cmsSaveProfileToMem(profile, NULL, &n) || n < DATE_OFFSET + DATE_BYTES)
        goto out;
    bytes = malloc(n);
    if (!bytes || !cmsSaveProfileToMem(profile, bytes, &n))
        goto out;
    memcpy(bytes + DATE_OFFSET, fixed_date, DATE_BYTES);
    *ret = bytes;
    *ret_bytes = n;
    bytes = NULL;
    r = 0;
out:
    free(bytes);
    if (profile)
        cmsCloseProfile(profile);
    cmsDeleteContext(context);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory for a colour profile");
    return 0;
}

static int curve_is_linear(cmsHPROFILE profile, cmsTagSignature tag)
{
    const cmsToneCurve *curve = cmsReadTag(profile, tag);

    if (!curve)
        return -ENODATA;
    return cmsIsToneCurveLinear(curve) ? 1 : 0;
}

int ttf_icc_is_linear(const void *profile, size_t bytes)
{
    cmsContext context;
    cmsHPROFILE handle = NULL;
    int r = -EINVAL;

    if (!profile || bytes < 128 || bytes > UINT32_MAX)
        return -EINVAL;
    context = create_context();
    if (!context)
        return -ENOMEM;
    handle = cmsOpenProfileFromMemTHR(context, profile, (cmsUInt32Number)bytes);
    if (!handle)
        goto out;
    if (cmsGetColorSpace(handle) == cmsSigGrayData) {
        r = curve_is_linear(handle, cmsSigGrayTRCTag);
    } else {
        r = curve_is_linear(handle, cmsSigRedTRCTag);
        if (r == 1)
            r = curve_is_linear(handle, cmsSigGreenTRCTag);
        if (r == 1)
            r = curve_is_linear(handle, cmsSigBlueTRCTag);
    }
out:
    if (handle)
        cmsCloseProfile(handle);
    cmsDeleteContext(context);
    return r;
}
