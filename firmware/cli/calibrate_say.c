/* SPDX-License-Identifier: Apache-2.0 */
/* calibrate_say.c: `ttfbox calibrate report`, and what the other words say in the end. */
#include "calibrate_say.h"

#include <inttypes.h>
#include <math.h>

#include "commands.h"

#define STEADY 0.005 /* what differs by less is not seen in a film */
#define DRIFT  0.01  /* a minute */

/* Least and greatest gain of the flat: how even the light is. */
static void gain_range(const struct ttf_calibration *c, double *ret_lo, double *ret_hi)
{
    uint16_t lo = UINT16_MAX, hi = 0;

    for (size_t i = 0; i < (size_t)c->width * c->height; i++) {
        lo = c->flat_gain[i] < lo ? c->flat_gain[i] : lo;
        hi = c->flat_gain[i] > hi ? c->flat_gain[i] : hi;
    }
    *ret_lo = lo / 16384.0;
    *ret_hi = hi / 16384.0;
}

static void say_dark(struct cli *cli, const struct ttf_calibration *c)
{
    struct ttf_json *j = &cli->out;
    double mean = 0;

    for (size_t i = 0; i < (size_t)c->width * c->height; i++)
        mean += c->dark_offset_16[i] / 16.0;
    mean /= (double)c->width * c->height;
    cli_say(cli, "dark              %u frames of %.3f ms, %.3f codes above black, %u hot pixels",
            c->dark_frames, (double)c->dark_settings.exposure_ns / 1e6, mean, c->n_hot);
    ttf_json_kint(j, "dark_frames", c->dark_frames);
    ttf_json_kint(j, "dark_exposure_ns", c->dark_settings.exposure_ns);
    ttf_json_kdouble(j, "dark_mean_codes", mean);
    ttf_json_kint(j, "hot_pixels", c->n_hot);
}

static void say_flat(struct cli *cli, const struct ttf_calibration *c)
{
    struct ttf_json *j = &cli->out;
    double lo, hi;

    gain_range(c, &lo, &hi);
    cli_say(cli,
            "flat              %u frames of %.3f ms, target %.3f, gain %.3f to %.3f, white at %.0f "
            "codes",
            c->flat_frames, (double)c->flat_settings.exposure_ns / 1e6, c->flat_reflectance, lo, hi,
            c->flat_level);
    ttf_json_kint(j, "flat_frames", c->flat_frames);
    ttf_json_kint(j, "flat_exposure_ns", c->flat_settings.exposure_ns);
    ttf_json_kdouble(j, "flat_reflectance", c->flat_reflectance);
    ttf_json_kdouble(j, "flat_gain_min", lo);
    ttf_json_kdouble(j, "flat_gain_max", hi);
    ttf_json_kdouble(j, "flat_level", c->flat_level);
}

static void say_chart(struct cli *cli, const struct ttf_calibration *c)
{
    const struct ttf_chart_fit *fit = &c->chart;
    const double *m = c->colour_matrix;
    struct ttf_json *j = &cli->out;

    ttf_json_kbool(j, "has_chart", c->has_chart);
    if (!c->has_chart) {
        cli_say(cli, "chart             none: the camera's colours are taken for sRGB's");
        return;
    }
    cli_say(cli,
            "chart             %u frames, light %.3f of the flat's, CIEDE2000 %.2f in the mean "
            "(%.2f without), %.2f at most (%s)",
            fit->frames, fit->light, fit->delta_e_mean, fit->delta_e_before_mean, fit->delta_e_max,
            ttf_chart_patch_name(fit->worst));
    for (int row = 0; row < 3; row++)
        cli_say(cli, "%s%8.4f %8.4f %8.4f", row ? "                  " : "matrix            ",
                m[3 * row], m[3 * row + 1], m[3 * row + 2]);
    ttf_json_kint(j, "chart_frames", fit->frames);
    ttf_json_kdouble(j, "chart_light", fit->light);
    ttf_json_kdouble(j, "chart_delta_e_before_mean", fit->delta_e_before_mean);
    ttf_json_kdouble(j, "chart_delta_e_mean", fit->delta_e_mean);
    ttf_json_kdouble(j, "chart_delta_e_max", fit->delta_e_max);
    ttf_json_kstring(j, "chart_worst", ttf_chart_patch_name(fit->worst));
    ttf_json_key(j, "colour_matrix");
    ttf_json_array(j);
    for (int i = 0; i < 9; i++)
        ttf_json_double(j, m[i]);
    ttf_json_array_end(j);
}

void calibrate_say_flicker(struct cli *cli, const struct ttf_calibration *c)
{
    const struct ttf_flicker *f = &c->flicker;
    struct ttf_json *j = &cli->out;

    ttf_json_kbool(j, "has_flicker", c->has_flicker);
    if (!c->has_flicker)
        return;
    cli_say(
        cli,
        "flicker           %u frames of %.3f ms at %.0f %% of the range: frames differ by %.2f %% "
        "(%.2f at most), bands in them by %.2f %%, drift %+.2f %% a minute",
        f->frames, (double)f->settings.exposure_ns / 1e6, 100 * f->mean_level, 100 * f->frame_rms,
        100 * f->frame_peak, 100 * f->band_rms, 100 * f->drift_per_min);
    ttf_json_kint(j, "flicker_frames", f->frames);
    ttf_json_kint(j, "flicker_exposure_ns", f->settings.exposure_ns);
    ttf_json_kdouble(j, "flicker_mean_level", f->mean_level);
    ttf_json_kdouble(j, "flicker_frame_rms", f->frame_rms);
    ttf_json_kdouble(j, "flicker_frame_peak", f->frame_peak);
    ttf_json_kdouble(j, "flicker_band_rms", f->band_rms);
    ttf_json_kdouble(j, "flicker_band_peak", f->band_peak);
    ttf_json_kdouble(j, "flicker_drift_per_min", f->drift_per_min);
}

void calibrate_say_geometry(struct cli *cli, const struct ttf_calibration *c)
{
    const struct ttf_geometry *g = &c->geometry;
    struct ttf_json *j = &cli->out;

    ttf_json_kbool(j, "has_geometry", c->has_geometry);
    if (!c->has_geometry)
        return;
    cli_say(
        cli,
        "geometry          %.5g mm per pixel in the middle, %.5g to %.5g over the frame; %u dots "
        "%g mm apart, %.2f pixels off a plane (%.2f at most)",
        g->mm_per_px, g->mm_per_px_least, g->mm_per_px_most, g->dots, g->pitch_mm, g->residual_px,
        g->residual_max_px);
    cli_say(cli, "                  grid turned by %+.2f degrees, lens %+.2f %% at the corners%s",
            g->rotation_deg, 100 * g->distortion,
            fabs(g->distortion) < 0.001 ? ""
            : g->distortion < 0         ? " (barrel)"
                                        : " (pincushion)");
    ttf_json_kint(j, "geometry_frames", g->frames);
    ttf_json_kint(j, "geometry_dots", g->dots);
    ttf_json_kdouble(j, "geometry_pitch_mm", g->pitch_mm);
    ttf_json_kdouble(j, "mm_per_px", g->mm_per_px);
    ttf_json_kdouble(j, "mm_per_px_least", g->mm_per_px_least);
    ttf_json_kdouble(j, "mm_per_px_most", g->mm_per_px_most);
    ttf_json_kdouble(j, "rotation_deg", g->rotation_deg);
    ttf_json_kdouble(j, "distortion", g->distortion);
    ttf_json_kdouble(j, "geometry_residual_px", g->residual_px);
    ttf_json_kdouble(j, "geometry_residual_max_px", g->residual_max_px);
}

void calibrate_advise(struct cli *cli, const struct ttf_flicker *f, double mains_hz)
{
    const double half_ns = mains_hz > 0 ? 1e9 / (2 * mains_hz) : 0;
    const double halves = half_ns > 0 ? (double)f->settings.exposure_ns / half_ns : 0;
    const bool whole = halves > 0.5 && fabs(halves - round(halves)) < 0.01 * halves;
    const bool steady = f->frame_rms <= STEADY && f->band_rms <= STEADY;

    ttf_json_kbool(&cli->out, "steady", steady && fabs(f->drift_per_min) <= DRIFT);
    if (!steady && !whole)
        cli_say(cli, "The light flickers. An exposure of whole half-periods of the mains evens its "
                     "ripple out: 'mains: 50Hz' "
                     "(or 60Hz) in the plan, and an exposure of 10 ms (8.33 ms) or a multiple.");
    else if (!steady)
        cli_say(cli,
                "The light flickers although the exposure is %.0f half-periods of %g Hz: the mains "
                "has another "
                "frequency, or the lamps' own supply ripples (dimming by PWM, a bad driver).",
                round(halves), mains_hz);
    if (steady && fabs(f->drift_per_min) > DRIFT) /* flicker alone looks like some */
        cli_say(cli, "The light drifts: let the lamps settle longer ('settle' in the plan).");
    if (steady && fabs(f->drift_per_min) <= DRIFT)
        cli_say(cli, "The light is steady.");
}

void calibrate_say(struct cli *cli, const struct ttf_calibration *c, const char *folder)
{
    struct ttf_json *j = &cli->out;

    cli_say(cli, "calibration       %s in %s%s", c->id, folder, c->simulated ? ", SIMULATED" : "");
    cli_say(cli, "camera            %s, %u x %u, black %u, white %u", c->camera, c->width,
            c->height, c->black_level, c->white_level);
    ttf_json_kstring(j, "id", c->id);
    ttf_json_kstring(j, "folder", folder);
    ttf_json_kbool(j, "simulated", c->simulated);
    ttf_json_kstring(j, "camera", c->camera);
    ttf_json_kint(j, "width", c->width);
    ttf_json_kint(j, "height", c->height);
    ttf_json_kbool(j, "has_dark", c->has_dark);
    ttf_json_kbool(j, "has_flat", c->has_flat);
    if (c->has_dark)
        say_dark(cli, c);
    else
        cli_say(cli, "dark              none");
    if (c->has_flat)
        say_flat(cli, c);
    else
        cli_say(cli, "flat              none");
    if (c->has_flat)
        say_chart(cli, c);
    calibrate_say_geometry(cli, c);
    calibrate_say_flicker(cli, c);
}

int cmd_calibrate_report(struct cli *cli)
{
    struct ttf_calibration c;
    int r;

    ttf_calibration_init(&c);
    r = ttf_calibration_load(cli->io, cli->opt.args[0], &c, &cli->err);
    if (r == 0)
        calibrate_say(cli, &c, cli->opt.args[0]);
    ttf_calibration_free(&c);
    return r;
}
