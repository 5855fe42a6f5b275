/* SPDX-License-Identifier: Apache-2.0 */
/* A calibration's folder, read; nothing in it is trusted. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/tiff.h"

#define PATH_SIZE  4096
#define JSON_BYTES ((size_t)64 << 20)

/* Reading one file: the first field that does not fit is named, and sticks. */
struct loader {
    const char *where;
    struct ttf_err *err;
    int r;
};

static void complain(struct loader *loader, const char *field, const char *what)
{
    if (loader->r == 0)
        loader->r = ttf_err_set(loader->err, -EINVAL, loader->where, "field '%s' %s", field, what);
}

static int64_t get_int(struct loader *loader, const json_t *object, const char *field, int64_t min,
                       int64_t max)
{
    const json_t *value = json_object_get(object, field);
    int64_t i = json_integer_value(value);

    if (!json_is_integer(value))
        complain(loader, field, "is missing or no whole number");
    else if (i < min || i > max)
        complain(loader, field, "is out of range");
    return i;
}

static double get_double(struct loader *loader, const json_t *value, const char *field, double min,
                         double max)
{
    double d = json_number_value(value);

    if (!json_is_number(value))
        complain(loader, field, "is missing or no number");
    else if (!(d >= min && d <= max))
        complain(loader, field, "is out of range");
    return d;
}

static void get_text(struct loader *loader, const json_t *object, const char *field, char *ret,
                     size_t size)
{
    const char *text = json_string_value(json_object_get(object, field));

    if (!text || strlen(text) >= size)
        complain(loader, field, "is missing, no text or too long");
    else
        snprintf(ret, size, "%s", text);
}

static void get_settings(struct loader *loader, const json_t *object, struct ttf_exposure *ret)
{
    ret->exposure_ns = get_int(loader, object, "exposure_ns", 0, INT64_MAX);
    ret->gain_milli = (uint32_t)get_int(loader, object, "gain_milli", 0, UINT32_MAX);
    ret->wb_r_milli = (uint32_t)get_int(loader, object, "wb_r_milli", 0, UINT32_MAX);
    ret->wb_b_milli = (uint32_t)get_int(loader, object, "wb_b_milli", 0, UINT32_MAX);
    ret->lens_mdpt = (uint32_t)get_int(loader, object, "lens_mdpt", 0, UINT32_MAX);
}

static void get_hot(struct loader *loader, const json_t *array, struct ttf_calibration *ret)
{
    size_t n = json_array_size(array);

    if (n == 0)
        return;
    if (n % 2 != 0 || n / 2 > (size_t)ret->width * ret->height) {
        complain(loader, "hot", "holds no pairs of x and y");
        return;
    }
    ret->hot = calloc(n / 2, sizeof(*ret->hot));
    if (!ret->hot) {
        loader->r = ttf_err_set(loader->err, -ENOMEM, loader->where, "no memory");
        return;
    }
    for (size_t i = 0; i < n; i++)
        if (!json_is_integer(json_array_get(array, i)))
            complain(loader, "hot", "holds no pairs of x and y");
    for (size_t i = 0; i < n / 2; i++) {
        json_int_t x = json_integer_value(json_array_get(array, 2 * i));
        json_int_t y = json_integer_value(json_array_get(array, 2 * i + 1));

        if (x < 0 || y < 0 || x >= ret->width || y >= ret->height)
            complain(loader, "hot", "holds a pixel outside the frame");
        ret->hot[i] = (struct ttf_hot_pixel){(uint16_t)x, (uint16_t)y};
    }
    ret->n_hot = (unsigned)(n / 2);
    calibration_sort_hot(ret);
}

static double get_figure(struct loader *loader, const json_t *object, const char *field, double min)
{
    return get_double(loader, json_object_get(object, field), field, min, 1e6);
}

static void get_chart(struct loader *loader, const json_t *chart, struct ttf_calibration *ret)
{
    const json_t *corners = json_object_get(chart, "corners");
    struct ttf_chart_fit *fit = &ret->chart;

    ret->has_chart = true;
    fit->frames = (unsigned)get_int(loader, chart, "frames", 1, 65535);
    if (json_array_size(corners) != 8)
        complain(loader, "corners", "has not eight numbers");
    for (size_t i = 0; i < 8 && loader->r == 0; i++)
        fit->view.corners[i / 2][i % 2] =
            get_double(loader, json_array_get(corners, i), "corners", 0, 65535);
    fit->light = get_figure(loader, chart, "light", 0);
    fit->delta_e_before_mean = get_figure(loader, chart, "delta_e_before_mean", 0);
    fit->delta_e_mean = get_figure(loader, chart, "delta_e_mean", 0);
    fit->delta_e_max = get_figure(loader, chart, "delta_e_max", 0);
    fit->worst = (unsigned)get_int(loader, chart, "worst", 1, TTF_CHART_PATCHES) - 1;
}

static void get_flicker(struct loader *loader, const json_t *flicker, struct ttf_calibration *ret)
{
    ret->has_flicker = true;
    ret->flicker.frames = (unsigned)get_int(loader, flicker, "frames", 1, 65535);
    get_settings(loader, flicker, &ret->flicker.settings);
    ret->flicker.mean_level = get_figure(loader, flicker, "mean_level", 0);
    ret->flicker.frame_rms = get_figure(loader, flicker, "frame_rms", 0);
    ret->flicker.frame_peak = get_figure(loader, flicker, "frame_peak", 0);
    ret->flicker.band_rms = get_figure(loader, flicker, "band_rms", 0);
    ret->flicker.band_peak = get_figure(loader, flicker, "band_peak", 0);
    ret->flicker.drift_per_min = get_figure(loader, flicker, "drift_per_min", -1e6);
}

static void get_geometry(struct loader *loader, const json_t *from, struct ttf_geometry *ret)
{
    ret->frames = (unsigned)get_int(loader, from, "frames", 1, 65535);
    ret->dots = (unsigned)get_int(loader, from, "dots", 1, UINT16_MAX);
    ret->pitch_mm = get_figure(loader, from, "pitch_mm", 0);
    ret->mm_per_px = get_double(loader, json_object_get(from, "mm_per_px"), "mm_per_px", 1e-6, 1e3);
    ret->mm_per_px_least = get_figure(loader, from, "mm_per_px_least", 0);
    ret->mm_per_px_most = get_figure(loader, from, "mm_per_px_most", 0);
    ret->rotation_deg = get_figure(loader, from, "rotation_deg", -180);
    ret->distortion = get_figure(loader, from, "distortion", -1);
    ret->residual_px = get_figure(loader, from, "residual_px", 0);
    ret->residual_max_px = get_figure(loader, from, "residual_max_px", 0);
}

static void get_parts(struct loader *loader, const json_t *root, struct ttf_calibration *ret)
{
    const json_t *dark = json_object_get(root, "dark"), *flat = json_object_get(root, "flat");
    const json_t *matrix = json_object_get(root, "colour_matrix");
    const json_t *chart = json_object_get(root, "chart");

    if (dark) {
        ret->has_dark = true;
        ret->dark_frames = (unsigned)get_int(loader, dark, "frames", 1, 65535);
        get_settings(loader, dark, &ret->dark_settings);
        if (json_object_get(dark, "temp_mdegc"))
            ret->dark_temp_mdegc =
                (int32_t)get_int(loader, dark, "temp_mdegc", INT32_MIN, INT32_MAX);
    }
    if (flat) {
        ret->has_flat = true;
        ret->flat_frames = (unsigned)get_int(loader, flat, "frames", 1, 65535);
        get_settings(loader, flat, &ret->flat_settings);
        ret->flat_reflectance =
            get_double(loader, json_object_get(flat, "reflectance"), "reflectance", 1e-6, 1.0);
        ret->flat_level = get_double(loader, json_object_get(flat, "level"), "level", 1e-3, 1e9);
    }
    if (matrix && json_array_size(matrix) != 9)
        complain(loader, "colour_matrix", "has not nine numbers");
    for (size_t i = 0; matrix && i < 9 && loader->r == 0; i++)
        ret->colour_matrix[i] =
            get_double(loader, json_array_get(matrix, i), "colour_matrix", -1e3, 1e3);
    if (chart)
        get_chart(loader, chart, ret);
    if (json_object_get(root, "flicker"))
        get_flicker(loader, json_object_get(root, "flicker"), ret);
    ret->has_geometry = json_object_get(root, "geometry") != NULL;
    if (ret->has_geometry)
        get_geometry(loader, json_object_get(root, "geometry"), &ret->geometry);
    get_hot(loader, json_object_get(root, "hot"), ret);
}

static void get_format(struct loader *loader, const json_t *root)
{
    const json_t *format = json_object_get(root, "format");
    const char *name = json_string_value(json_object_get(format, "name"));

    if (!name || strcmp(name, CALIBRATION_FORMAT) != 0) {
        complain(loader, "format", "does not say that this is a calibration");
        return;
    }
    if (get_int(loader, format, "major", 0, INT64_MAX) != CALIBRATION_MAJOR && loader->r == 0)
        loader->r = ttf_err_set(loader->err, -ENOTSUP, loader->where,
                                "calibrations of this major version are not read, only of %d",
                                CALIBRATION_MAJOR);
}

static void get_all(struct loader *loader, const json_t *root, struct ttf_calibration *ret)
{
    const char *cfa = json_string_value(json_object_get(root, "cfa"));
    int found = calibration_cfa_find(cfa ? cfa : "");

    get_format(loader, root);
    get_text(loader, root, "id", ret->id, sizeof(ret->id));
    get_text(loader, root, "camera", ret->camera, sizeof(ret->camera));
    ret->simulated = json_is_true(json_object_get(root, "simulated"));
    ret->width = (uint32_t)get_int(loader, root, "width", 0, 65535);
    ret->height = (uint32_t)get_int(loader, root, "height", 0, 65535);
    if (found < 0)
        complain(loader, "cfa", "is no mosaic we know");
    else
        ret->cfa = (enum ttf_cfa)found;
    ret->black_level = (uint16_t)get_int(loader, root, "black_level", 0, 65535);
    ret->white_level = (uint16_t)get_int(loader, root, "white_level", 0, 65535);
    if (loader->r == 0)
        get_parts(loader, root, ret);
    if (loader->r == 0 && (ret->has_dark || ret->has_flat) &&
        (ret->width == 0 || ret->height == 0 || ret->white_level <= ret->black_level))
        complain(loader, "width", "or height or levels cannot be");
}

static int load_json(struct ttf_io *io, const char *folder, struct ttf_calibration *ret,
                     struct ttf_err *err)
{
    char path[PATH_SIZE];
    struct loader loader = {.where = path, .err = err};
    json_error_t where;
    json_t *root;
    char *text = NULL;
    size_t bytes = 0;
    int r;

    snprintf(path, sizeof(path), "%s/calibration.json", folder);
    r = ttf_io_slurp(io, path, JSON_BYTES, &text, &bytes, err);
    if (r < 0)
        return r;
    r = ttf_json_parse(text, bytes, &root, &where);
    free(text);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, path, "no memory");
    if (r < 0)
        return ttf_err_set(err, r, path, "line %d is no JSON: %s", where.line, where.text);
    if (!json_is_object(root)) {
        json_decref(root);
        return ttf_err_set(err, -EINVAL, path, "is no calibration: there is no object in it");
    }
    get_all(&loader, root, ret);
    json_decref(root);
    return loader.r;
}

/* The picture beside the JSON, of the JSON's size. */
static int load_picture(struct ttf_io *io, const char *folder, const char *name,
                        const struct ttf_calibration *calibration, enum ttf_sample format,
                        struct ttf_pixbuf *ret, struct ttf_err *err)
{
    char path[PATH_SIZE];
    int r;

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    r = ttf_tiff_read(io, path, 0, ret, err);
    if (r < 0)
        return r;
    if (ret->width == calibration->width && ret->height == calibration->height &&
        ret->samples == 1 && ret->format == format)
        return 0;
    ttf_pixbuf_free(ret);
    return ttf_err_set(err, -TTF_EDAMAGED, path,
                       "the picture is not of the size and samples that calibration.json needs");
}

static int load_dark(struct ttf_io *io, const char *folder, struct ttf_calibration *ret,
                     struct ttf_err *err)
{
    struct ttf_pixbuf picture = {0};
    int r = load_picture(io, folder, "dark.tif", ret, TTF_SAMPLE_F32, &picture, err);

    if (r < 0)
        return r;
    ret->dark_offset_16 = calloc((size_t)ret->width * ret->height, sizeof(int32_t));
    if (!ret->dark_offset_16) {
        ttf_pixbuf_free(&picture);
        return ttf_err_set(err, -ENOMEM, folder, "no memory for a calibration");
    }
    for (uint32_t y = 0; y < ret->height; y++) {
        const float *row = ttf_pixbuf_row(&picture, y);

        for (uint32_t x = 0; x < ret->width; x++) {
            float value = row[x] * 16.0f;

            if (!(value >= -1048576.0f && value <= 1048576.0f)) /* a NaN, too */
                r = -TTF_EDAMAGED;
            else
                ret->dark_offset_16[(size_t)y * ret->width + x] = (int32_t)value;
        }
    }
    ttf_pixbuf_free(&picture);
    if (r < 0)
        return ttf_err_set(err, r, folder, "dark.tif holds values that no camera gives");
    return 0;
}

static int load_flat(struct ttf_io *io, const char *folder, struct ttf_calibration *ret,
                     struct ttf_err *err)
{
    struct ttf_pixbuf picture = {0};
    int r = load_picture(io, folder, "flat.tif", ret, TTF_SAMPLE_U16, &picture, err);

    if (r < 0)
        return r;
    ret->flat_gain = picture.data; /* tightly packed, ours to free */
    return 0;
}

/* A fitted calibration's id tells its content. */
static int check_id(const struct ttf_calibration *calibration, const char *folder,
                    struct ttf_err *err)
{
    char id[64];

    if (strncmp(calibration->id, CALIBRATION_ID_PREFIX, strlen(CALIBRATION_ID_PREFIX)) != 0)
        return 0;
    calibration_id(calibration, id);
    if (strcmp(id, calibration->id) == 0)
        return 0;
    return ttf_err_set(err, -TTF_EDAMAGED, folder,
                       "the calibration's content is not what its id %s says (%s)", calibration->id,
                       id);
}

int ttf_calibration_load(struct ttf_io *io, const char *folder, struct ttf_calibration *ret,
                         struct ttf_err *err)
{
    struct ttf_calibration calibration;
    int r;

    if (strlen(folder) > PATH_SIZE - 64)
        return ttf_err_set(err, -ENAMETOOLONG, NULL, "the folder's name is too long");
    ttf_calibration_init(&calibration);
    r = load_json(io, folder, &calibration, err);
    if (r == 0 && calibration.has_dark)
        r = load_dark(io, folder, &calibration, err);
    if (r == 0 && calibration.has_flat)
        r = load_flat(io, folder, &calibration, err);
    if (r == 0)
        r = check_id(&calibration, folder, err);
    if (r < 0) {
        ttf_calibration_free(&calibration);
        return r;
    }
    *ret = calibration;
    return 0;
}
