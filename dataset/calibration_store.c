/* SPDX-License-Identifier: Apache-2.0 */
/* A calibration's folder, written: the pictures first, calibration.json last. CALIBRATION.md has the format. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/tiff.h"

#define PATH_SIZE 4096

static const char *const cfa_names[TTF_CFA_COUNT] = {"", "RGGB", "GRBG", "GBRG", "BGGR"};

const char *calibration_cfa_name(enum ttf_cfa cfa)
{
    return (unsigned)cfa < TTF_CFA_COUNT ? cfa_names[cfa] : "";
}

int calibration_cfa_find(const char *name)
{
    for (int i = 0; i < TTF_CFA_COUNT; i++) {
        if (strcmp(name, cfa_names[i]) == 0)
            return i;
    }
    return -ENOENT;
}

/* Produces rows of the picture: what lies in the file of row y. */
typedef void row_fn(const struct ttf_calibration *calibration, uint32_t y, void *row);

static void dark_row(const struct ttf_calibration *calibration, uint32_t y, void *row)
{
    const int32_t *from = calibration->dark_offset_16 + (size_t)y * calibration->width;
    float *to = row;

    for (uint32_t x = 0; x < calibration->width; x++)
        to[x] = (float)from[x] / 16.0f; /* exact: 21 bits at most */
}

static void flat_row(const struct ttf_calibration *calibration, uint32_t y, void *row)
{
    memcpy(row, calibration->flat_gain + (size_t)y * calibration->width,
           (size_t)calibration->width * 2);
}

static int write_rows(const struct ttf_calibration *calibration, struct ttf_io *io, int file,
                      const struct ttf_tiff_spec *spec, row_fn *produce, struct ttf_err *err)
{
    struct ttf_tiff_writer *writer = NULL;
    void *row = calloc(calibration->width, sizeof(float));
    int r;

    if (!row)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a row");
    r = ttf_tiff_writer_open(io, file, spec, &writer, err);
    for (uint32_t y = 0; r == 0 && y < calibration->height; y++) {
        produce(calibration, y, row);
        r = ttf_tiff_writer_rows(writer, row, 0, 1, err);
    }
    if (r == 0)
        r = ttf_tiff_writer_close(writer, err);
    else
        ttf_tiff_writer_abandon(writer);
    free(row);
    return r;
}

/* Under a temporary name, synced, renamed. */
static int save_picture(const struct ttf_calibration *calibration, struct ttf_io *io,
                        const char *folder, const char *name, enum ttf_sample format,
                        row_fn *produce, struct ttf_err *err)
{
    struct ttf_tiff_spec spec = {.width = calibration->width,
                                 .height = calibration->height,
                                 .samples = 1,
                                 .format = format,
                                 .compression = TTF_TIFF_NONE,
                                 .icc = TTF_ICC_NONE,
                                 .times = {.start_utc_ns = TTF_NS_UNKNOWN}};
    char path[PATH_SIZE], temporary[PATH_SIZE];
    int file, r, closed;

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    snprintf(temporary, sizeof(temporary), "%s/.%s.tmp", folder, name);
    r = io->ops->unlink(io, temporary); /* of a save that was cut short */
    if (r < 0 && r != -ENOENT)
        return ttf_err_set(err, r, temporary, "cannot remove: %s", strerrordesc_np(-r));
    file = io->ops->open(io, temporary, TTF_IO_CREATE_NEW);
    if (file < 0)
        return ttf_err_set(err, file, temporary, "cannot create: %s", strerrordesc_np(-file));
    r = write_rows(calibration, io, file, &spec, produce, err);
    if (r == 0) {
        r = io->ops->sync(io, file, false);
        if (r < 0)
            ttf_err_set(err, r, temporary, "cannot sync: %s", strerrordesc_np(-r));
    }
    closed = io->ops->close(io, file);
    if (r == 0 && closed < 0)
        r = ttf_err_set(err, closed, temporary, "cannot close: %s", strerrordesc_np(-closed));
    if (r == 0) {
        r = io->ops->rename(io, temporary, path);
        if (r < 0)
            ttf_err_set(err, r, path, "cannot rename: %s", strerrordesc_np(-r));
    }
    if (r < 0)
        (void)!io->ops->unlink(io, temporary); /* a full disk needs its room */
    return r;
}

static void json_settings(struct ttf_json *json, const struct ttf_exposure *settings)
{
    ttf_json_kint(json, "exposure_ns", settings->exposure_ns);
    ttf_json_kint(json, "gain_milli", settings->gain_milli);
    ttf_json_kint(json, "wb_r_milli", settings->wb_r_milli);
    ttf_json_kint(json, "wb_b_milli", settings->wb_b_milli);
    ttf_json_kint(json, "lens_mdpt", settings->lens_mdpt);
}

static void json_chart(struct ttf_json *json, const struct ttf_chart_fit *fit)
{
    ttf_json_key(json, "chart");
    ttf_json_object(json);
    ttf_json_kint(json, "frames", fit->frames);
    ttf_json_key(json, "corners");
    ttf_json_array(json);
    for (int i = 0; i < 4; i++) {
        ttf_json_double(json, fit->view.corners[i][0]);
        ttf_json_double(json, fit->view.corners[i][1]);
    }
    ttf_json_array_end(json);
    ttf_json_kdouble(json, "light", fit->light);
    ttf_json_kdouble(json, "delta_e_before_mean", fit->delta_e_before_mean);
    ttf_json_kdouble(json, "delta_e_mean", fit->delta_e_mean);
    ttf_json_kdouble(json, "delta_e_max", fit->delta_e_max);
    ttf_json_kint(json, "worst", fit->worst + 1);
    ttf_json_object_end(json);
}

static void json_flicker(struct ttf_json *json, const struct ttf_flicker *flicker)
{
    ttf_json_key(json, "flicker");
    ttf_json_object(json);
    ttf_json_kint(json, "frames", flicker->frames);
    json_settings(json, &flicker->settings);
    ttf_json_kdouble(json, "mean_level", flicker->mean_level);
    ttf_json_kdouble(json, "frame_rms", flicker->frame_rms);
    ttf_json_kdouble(json, "frame_peak", flicker->frame_peak);
    ttf_json_kdouble(json, "band_rms", flicker->band_rms);
    ttf_json_kdouble(json, "band_peak", flicker->band_peak);
    ttf_json_kdouble(json, "drift_per_min", flicker->drift_per_min);
    ttf_json_object_end(json);
}

static void json_geometry(struct ttf_json *json, const struct ttf_geometry *geometry)
{
    ttf_json_key(json, "geometry");
    ttf_json_object(json);
    ttf_json_kint(json, "frames", geometry->frames);
    ttf_json_kint(json, "dots", geometry->dots);
    ttf_json_kdouble(json, "pitch_mm", geometry->pitch_mm);
    ttf_json_kdouble(json, "mm_per_px", geometry->mm_per_px);
    ttf_json_kdouble(json, "mm_per_px_least", geometry->mm_per_px_least);
    ttf_json_kdouble(json, "mm_per_px_most", geometry->mm_per_px_most);
    ttf_json_kdouble(json, "rotation_deg", geometry->rotation_deg);
    ttf_json_kdouble(json, "distortion", geometry->distortion);
    ttf_json_kdouble(json, "residual_px", geometry->residual_px);
    ttf_json_kdouble(json, "residual_max_px", geometry->residual_max_px);
    ttf_json_object_end(json);
}

static void json_parts(struct ttf_json *json, const struct ttf_calibration *calibration)
{
    if (calibration->has_dark) {
        ttf_json_key(json, "dark");
        ttf_json_object(json);
        ttf_json_kstring(json, "file", "dark.tif");
        ttf_json_kint(json, "frames", calibration->dark_frames);
        json_settings(json, &calibration->dark_settings);
        if (calibration->dark_temp_mdegc != INT32_MIN)
            ttf_json_kint(json, "temp_mdegc", calibration->dark_temp_mdegc);
        ttf_json_object_end(json);
    }
    if (calibration->has_flat) {
        ttf_json_key(json, "flat");
        ttf_json_object(json);
        ttf_json_kstring(json, "file", "flat.tif");
        ttf_json_kint(json, "frames", calibration->flat_frames);
        json_settings(json, &calibration->flat_settings);
        ttf_json_kdouble(json, "reflectance", calibration->flat_reflectance);
        ttf_json_kdouble(json, "level", calibration->flat_level);
        ttf_json_object_end(json);
    }
    ttf_json_key(json, "hot");
    ttf_json_array(json);
    for (unsigned i = 0; i < calibration->n_hot; i++) {
        ttf_json_int(json, calibration->hot[i].x);
        ttf_json_int(json, calibration->hot[i].y);
    }
    ttf_json_array_end(json);
    ttf_json_key(json, "colour_matrix");
    ttf_json_array(json);
    for (int i = 0; i < 9; i++)
        ttf_json_double(json, calibration->colour_matrix[i]);
    ttf_json_array_end(json);
    if (calibration->has_chart)
        json_chart(json, &calibration->chart);
    if (calibration->has_flicker)
        json_flicker(json, &calibration->flicker);
    if (calibration->has_geometry)
        json_geometry(json, &calibration->geometry);
}

static int save_json(const struct ttf_calibration *calibration, struct ttf_io *io,
                     const char *folder, struct ttf_err *err)
{
    char path[PATH_SIZE];
    struct ttf_json json;
    const char *text = NULL;
    size_t bytes = 0;
    int r;

    snprintf(path, sizeof(path), "%s/calibration.json", folder);
    ttf_json_init(&json, true);
    ttf_json_object(&json);
    ttf_json_key(&json, "format");
    ttf_json_object(&json);
    ttf_json_kstring(&json, "name", CALIBRATION_FORMAT);
    ttf_json_kint(&json, "major", CALIBRATION_MAJOR);
    ttf_json_kint(&json, "minor", CALIBRATION_MINOR);
    ttf_json_object_end(&json);
    ttf_json_kstring(&json, "id", calibration->id);
    ttf_json_kstring(&json, "camera", calibration->camera);
    ttf_json_kbool(&json, "simulated", calibration->simulated);
    ttf_json_kint(&json, "width", calibration->width);
    ttf_json_kint(&json, "height", calibration->height);
    if (calibration->cfa != TTF_CFA_NONE)
        ttf_json_kstring(&json, "cfa", calibration_cfa_name(calibration->cfa));
    ttf_json_kint(&json, "black_level", calibration->black_level);
    ttf_json_kint(&json, "white_level", calibration->white_level);
    json_parts(&json, calibration);
    ttf_json_object_end(&json);
    r = ttf_json_finish(&json, &text, &bytes);
    if (r < 0)
        ttf_err_set(err, r, path, "cannot write a calibration as JSON: %s", strerrordesc_np(-r));
    else
        r = ttf_io_write_file(io, path, text, bytes, err);
    ttf_json_free(&json);
    return r;
}

/* What no calibration.json speaks of yet; the folder goes too, unless something else is in it. */
static void remove_pictures(struct ttf_io *io, const char *folder)
{
    static const char *const NAMES[] = {"dark.tif", "flat.tif"};
    char path[PATH_SIZE];

    for (unsigned i = 0; i < sizeof(NAMES) / sizeof(*NAMES); i++) {
        snprintf(path, sizeof(path), "%s/%s", folder, NAMES[i]);
        (void)!io->ops->unlink(io, path);
    }
    (void)!io->ops->unlink(io, folder);
}

int ttf_calibration_save(const struct ttf_calibration *calibration, struct ttf_io *io,
                         const char *folder, struct ttf_err *err)
{
    char path[PATH_SIZE];
    struct ttf_io_stat st;
    bool first;
    int r;

    if (strlen(folder) > PATH_SIZE - 64)
        return ttf_err_set(err, -ENAMETOOLONG, NULL, "the folder's name is too long");
    snprintf(path, sizeof(path), "%s/calibration.json", folder);
    first = io->ops->stat(io, path, &st) == -ENOENT;
    r = ttf_io_mkdirs(io, folder, err);
    if (r == 0 && calibration->has_dark)
        r = save_picture(calibration, io, folder, "dark.tif", TTF_SAMPLE_F32, dark_row, err);
    if (r == 0 && calibration->has_flat)
        r = save_picture(calibration, io, folder, "flat.tif", TTF_SAMPLE_U16, flat_row, err);
    if (r == 0)
        r = save_json(calibration, io, folder, err);
    if (r < 0 && first && io->ops->stat(io, path, &st) == -ENOENT)
        remove_pictures(io, folder);
    return r;
}
