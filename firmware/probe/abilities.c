/* SPDX-License-Identifier: Apache-2.0 */
#include "abilities.h"

#include <stdio.h>

#include "ttf/base/time.h"

static void say_pixels(const struct ttf_frame_format *f, char *ret, size_t size)
{
    static const char *const KINDS[TTF_PACKING_COUNT] = {
        [TTF_PACKING_GREY8] = "grey",   [TTF_PACKING_GREY16] = "grey",
        [TTF_PACKING_RGB8] = "RGB",     [TTF_PACKING_YUYV8] = "YUYV (half the colour)",
        [TTF_PACKING_RAW16] = "linear", [TTF_PACKING_NV12] = "NV12 (a quarter of the colour)",
        [TTF_PACKING_RAW8] = "linear",  [TTF_PACKING_RAW10P] = "linear",
        [TTF_PACKING_RAW12P] = "linear"};
    static const char *const MOSAICS[TTF_CFA_COUNT] = {
        [TTF_CFA_RGGB] = "mosaic RGGB",
        [TTF_CFA_GRBG] = "mosaic GRBG",
        [TTF_CFA_GBRG] = "mosaic GBRG",
        [TTF_CFA_BGGR] = "mosaic BGGR",
    };
    bool packed = f->packing == TTF_PACKING_RAW10P || f->packing == TTF_PACKING_RAW12P;
    const char *kind = f->cfa != TTF_CFA_NONE ? MOSAICS[f->cfa] : KINDS[f->packing];

    (void)snprintf(ret, size, "%s of %u bits%s", kind ? kind : "unknown pixels", f->bits,
                   packed ? ", packed" : "");
}

static void say_exposure(const struct ttf_camera_caps *caps, char *ret, size_t size)
{
    double most_ms = (double)caps->exposure_max_ns / 1e6;

    if (caps->exposure_max_ns == 0)
        (void)snprintf(ret, size,
                       "exposure: no control; it is the camera's own, and how long a frame was "
                       "exposed is not known");
    else
        (void)snprintf(ret, size, "exposure %.3f ms to %.*f ms",
                       (double)caps->exposure_min_ns / 1e6, most_ms < 100 ? 3 : 0, most_ms);
}

static void say_gain(const struct ttf_camera_caps *caps, char *ret, size_t size)
{
    if (caps->gain_max_milli == 0)
        (void)snprintf(ret, size, "gain: no control");
    else
        (void)snprintf(ret, size, "gain %.2f to %.2f", caps->gain_min_milli / 1e3,
                       caps->gain_max_milli / 1e3);
}

static void say_time(const struct ttf_camera_caps *caps, char *ret, size_t size)
{
    char rate[48] = "";

    if (caps->frame_period_ns > 0)
        (void)snprintf(rate, sizeof rate, "%.2f frames a second, ",
                       (double)TTF_NS_PER_S / (double)caps->frame_period_ns);
    (void)snprintf(ret, size,
                   "time: %s%s: the middle of an exposure within %.1f ms of its slot; settings "
                   "take %u frames",
                   rate, caps->steerable ? "steerable" : "free-running",
                   (double)caps->timing_bound_ns / 1e6, caps->lead_frames);
}

void probe_abilities(const struct ttf_camera_caps *caps, const struct ttf_frame_format *format,
                     struct probe_abilities *ret)
{
    say_pixels(format, ret->pixels, sizeof ret->pixels);
    say_exposure(caps, ret->line[0], sizeof ret->line[0]);
    say_gain(caps, ret->line[1], sizeof ret->line[1]);
    (void)snprintf(ret->line[2], sizeof ret->line[2], "white balance: %s",
                   caps->has_white_balance
                       ? "the camera's, at what a plan says"
                       : "not a plan's; if the camera has one, it stands still");
    if (caps->lens_held)
        (void)snprintf(
            ret->line[3], sizeof ret->line[3],
            "lens: not a plan's; held where it stands, at %lld in the driver's own count",
            (long long)caps->lens_code);
    else
        (void)snprintf(ret->line[3], sizeof ret->line[3], "lens: %s",
                       caps->has_lens ? "its position is held and recorded"
                                      : "not a plan's: fixed, or focused by hand");
    say_time(caps, ret->line[4], sizeof ret->line[4]);
}
