/* SPDX-License-Identifier: Apache-2.0 */
/*
 * calibration.h: what is known of a camera under its lamps, as data; fitting it
 * from frames and storing it. Pure: acquiring the frames is capture's.
 *
 * A calibration folder (calibration/ID/ in a dataset, or by itself):
 * calibration.json, and dark.tif, flat.tif where they exist. The format is in
 * CALIBRATION.md.
 */
#ifndef TTF_DATASET_CALIBRATION_H
#define TTF_DATASET_CALIBRATION_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/base/frame.h"
#include "ttf/dataset/chart.h"
#include "ttf/dataset/io.h"

/*
 * A sum of equal raw frames: averages accumulate as they come.
 *
 * Of raw and GREY16 frames codes are summed. GREY8, RGB8, YUYV8 and NV12 frames are
 * finished pictures, encoded for display (sRGB): they are decoded first, and
 * linear-light codes 0..65535 are summed, whatever levels the format names.
 */
struct ttf_raw_sum {
    struct ttf_frame_format format; /* of each frame that went in */
    struct ttf_exposure settings;   /* of the first */
    uint32_t *sum;                  /* width x height x samples, tightly packed */
    size_t room;                    /* samples that sum has memory for */
    unsigned n;                     /* frames in it */
    unsigned samples;               /* per pixel: 1, or 3 of RGB8 and YUYV8 */
};

/* What the codes in a sum range over: the format's levels, or 0 and 65535 of decoded ones. */
void ttf_raw_sum_levels(const struct ttf_frame_format *format, uint16_t *ret_black,
                        uint16_t *ret_white);

/* Bytes that a sample of a sum takes. */
#define TTF_RAW_SUM_BYTES sizeof(uint32_t)

/* Samples per pixel, and of a frame of that format into *ret: what a sum needs room for. Negative as init. */
TTF_MUST_USE int ttf_raw_sum_samples(const struct ttf_frame_format *format, size_t *ret);

/* Room for frames of that format, n = 0. -EINVAL for a format that cannot be, -ENOTSUP for an unknown packing, -ENOMEM. */
TTF_MUST_USE int ttf_raw_sum_init(struct ttf_raw_sum *sum, const struct ttf_frame_format *format);
/* Empties it for frames of a format, perhaps another, within its memory: -ENOSPC beyond that; as init. */
TTF_MUST_USE int ttf_raw_sum_refit(struct ttf_raw_sum *sum, const struct ttf_frame_format *format);
void ttf_raw_sum_reset(struct ttf_raw_sum *sum); /* n = 0 again, memory kept */
/* -EINVAL if the frame's format or bytes do not fit; -EOVERFLOW beyond 65,535 frames. */
TTF_MUST_USE int ttf_raw_sum_add(struct ttf_raw_sum *sum, const struct ttf_frame *frame);
void ttf_raw_sum_free(struct ttf_raw_sum *sum);

struct ttf_hot_pixel {
    uint16_t x, y;
};

/* A chart as the camera sees it: the corners of its patches' field, x and y in the frame's pixels (0, 0: the first pixel's outer corner). */
struct ttf_chart_view {
    double corners
        [4]
        [2]; /* of the first patch's own corner, then clockwise: top left, top right, bottom right, bottom left */
};

/* How well a matrix was fitted. */
struct ttf_chart_fit {
    unsigned frames; /* averaged */
    struct ttf_chart_view view;
    double light;               /* on the chart, 1: as on the flat */
    double delta_e_before_mean; /* CIEDE2000 over the patches, without a matrix */
    double delta_e_mean, delta_e_max;
    unsigned worst; /* the patch of delta_e_max, from 0 */
};

/* How steady the light is (flicker.h), relative to the mean level: 0.01 is 1 %. */
struct ttf_flicker {
    unsigned frames;
    struct ttf_exposure settings;
    double mean_level;    /* share of the range */
    double frame_rms;     /* of frames' levels, drift taken out */
    double frame_peak;    /* greatest of those, up or down */
    double band_rms;      /* of bands of rows within their frame, noise taken out */
    double band_peak;     /* greatest, noise and all */
    double drift_per_min; /* slope over the frames, a minute */
};

/* How large a pixel is, by a flat grid of dots in the sample's place. */
struct ttf_geometry {
    unsigned frames, dots;
    double pitch_mm;                        /* from dot to dot */
    double mm_per_px;                       /* in the frame's middle, of a raw pixel */
    double mm_per_px_least, mm_per_px_most; /* of the middle and the four corners */
    double rotation_deg;                    /* of the grid in the frame, clockwise; -45 to 45 */
    double distortion; /* radial, at the corners: below 0 a barrel, above a pincushion */
    double residual_px, residual_max_px; /* what a plane and such a lens leave: rms, and most */
};

/* A calibration. Fields are read freely; made by the functions below. Owns its arrays. */
struct ttf_calibration {
    char id[64]; /* [a-z0-9-]; from the content's hash when fitted */
    char camera[32];
    bool simulated;
    uint32_t width, height; /* of the raw frame, 0 = nothing per pixel */
    enum ttf_cfa cfa;
    uint16_t black_level, white_level;

    /* dark: codes in 1/16 above black_level, per pixel, at dark_settings; subtracted as it is */
    bool has_dark;
    int32_t *dark_offset_16; /* width x height */
    unsigned dark_frames;
    struct ttf_exposure dark_settings;
    int32_t dark_temp_mdegc; /* INT32_MIN: not known */
    /* Pixels not to be believed: hot in the dark, or dead under the flat. */
    unsigned n_hot;
    struct ttf_hot_pixel *hot; /* sorted by y, x */

    /* flat: gain per pixel in 1/16384 that makes a perfect diffuser code `flat_level` above black */
    bool has_flat;
    uint16_t *flat_gain; /* width x height */
    unsigned flat_frames;
    struct ttf_exposure flat_settings;
    double flat_reflectance; /* of the target, 0..1 */
    double
        flat_level; /* codes above black that a perfect diffuser gives at flat_settings, gain applied */

    /* camera RGB (white balanced by the flat) to linear sRGB, row-major; identity by default */
    double colour_matrix[9];
    /* what the matrix was fitted from; a remark, not part of the id */
    bool has_chart;
    struct ttf_chart_fit chart;
    /* how steady its light was found; a remark, too */
    bool has_flicker;
    struct ttf_flicker flicker;
    /* how large a pixel is; a remark, too */
    bool has_geometry;
    struct ttf_geometry geometry;
};

/* What a calibration may hold, in the order in which it is made. */
enum ttf_calibration_part {
    TTF_CALIBRATION_DARK = 0,
    TTF_CALIBRATION_FLAT,
    TTF_CALIBRATION_CHART,
    TTF_CALIBRATION_GEOMETRY,
    TTF_CALIBRATION_FLICKER
};

/* "dark", ..., "flicker": as a user writes them, and as calibration.json names them; and back, -ENOENT. */
const char *ttf_calibration_part_name(enum ttf_calibration_part part);
TTF_MUST_USE int ttf_calibration_part_find(const char *name);
bool ttf_calibration_has(const struct ttf_calibration *calibration, enum ttf_calibration_part part);

/*
 * May this part be added to what is there, to be saved with it? Asked before frames are taken for it. -EINVAL and what to do first: a dark
 * behind a flat (whose gains were made without it), a chart before a flat, grid or flicker where there is neither dark nor flat.
 */
TTF_MUST_USE int ttf_calibration_may_take(const struct ttf_calibration *calibration,
                                          enum ttf_calibration_part part, struct ttf_err *err);

/* Nothing known: identity. */
void ttf_calibration_init(struct ttf_calibration *calibration);
void ttf_calibration_free(struct ttf_calibration *calibration);

/*
 * Fits the dark part from frames taken with all lamps off (plain average; hot
 * pixels are those over the median by 10 robust standard deviations and 8
 * codes). -EINVAL with a reason a user understands if the frames are not dark, or there is a flat.
 */
TTF_MUST_USE int ttf_calibration_fit_dark(struct ttf_calibration *calibration,
                                          const struct ttf_raw_sum *dark, struct ttf_err *err);

/*
 * Fits the flat part from frames of an even target of known reflectance
 * (plain average, dark applied first). Refused with a reason when saturated, too
 * dark, or more uneven than 8 to 1.
 */
TTF_MUST_USE int ttf_calibration_fit_flat(struct ttf_calibration *calibration,
                                          const struct ttf_raw_sum *flat, double reflectance,
                                          struct ttf_err *err);

/*
 * Fits the colour matrix from frames of a chart under the light and in the place of the flat, which must be there: dark, flat
 * and exposure applied, the middle of each patch averaged, the chart's brightness taken from its grey scale, then each row
 * by weighted least squares (weights 1 / (Y + 0.02), so that dark patches count as the eye counts them), its three numbers
 * adding up to 1: what is grey stays grey. Refused with a reason when the camera has no colours, corners do not go round a chart,
 * patches are saturated, too small or uneven, or when they are not the colours of this chart (mean CIEDE2000 above 8).
 */
TTF_MUST_USE int ttf_calibration_fit_chart(struct ttf_calibration *calibration,
                                           const struct ttf_raw_sum *frames,
                                           const struct ttf_chart_view *view,
                                           const struct ttf_chart *chart, struct ttf_err *err);

/*
 * Measures how large a pixel is from frames of a flat grid of dark round dots on light ground, pitch_mm apart in rows and columns,
 * of which at least 5 x 5 are seen, over 0.4 of the frame each way: middles of the dots, a homography and one
 * radial term of the lens. Finished pictures will do where the calibration has neither dark nor flat. Refused with a reason
 * when there is no such grid, or the dots are off it by more than a twentieth of the pitch (rms). -EINVAL, -ENOMEM.
 */
TTF_MUST_USE int ttf_calibration_fit_geometry(struct ttf_calibration *calibration,
                                              const struct ttf_raw_sum *frames, double pitch_mm,
                                              struct ttf_err *err);

/* Gives it its id from its content; call after fitting. */
TTF_MUST_USE int ttf_calibration_name(struct ttf_calibration *calibration, struct ttf_err *err);

TTF_MUST_USE int ttf_calibration_save(const struct ttf_calibration *calibration, struct ttf_io *io,
                                      const char *folder, struct ttf_err *err);
TTF_MUST_USE int ttf_calibration_load(struct ttf_io *io, const char *folder,
                                      struct ttf_calibration *ret, struct ttf_err *err);

#endif
