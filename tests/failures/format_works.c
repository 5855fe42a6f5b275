/* SPDX-License-Identifier: Apache-2.0 */
#include "format_works.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/calibration.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/export.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/tiff.h"

#define SIDE 24

static struct ttf_io *io;
static const char *folder;
static int handle;

/* What there is to begin with: in memory, and in files of these names. */
static struct ttf_raw_sum dark, flat;
static struct ttf_calibration calibration;
static struct ttf_pixbuf picture, floats;
static const struct ttf_dng_info dng_info = {
    .model = "A", .serial = "1", .software = "s", .times = {1000000000, 3600, 20000000}};
static const struct ttf_tiff_spec tiff_spec = {.compression = TTF_TIFF_DEFLATE,
                                               .icc = TTF_ICC_LINEAR,
                                               .times = {1000000000, 3600, 20000000},
                                               .software = "s",
                                               .description = "d"};

const char *format_in(const char *name)
{
    static char path[100];

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return path;
}

int format_write_tiff(struct ttf_err *err)
{
    return ttf_tiff_write(io, handle, &picture, &tiff_spec, err);
}

int format_write_png(struct ttf_err *err)
{
    return ttf_png_write(io, handle, &picture, TTF_TRANSFER_LINEAR, 6, "says", err);
}

int format_write_jpeg(struct ttf_err *err)
{
    struct ttf_pixbuf bytes = {0};
    int r = ttf_pixbuf_alloc(&bytes, SIDE, SIDE, 3, TTF_SAMPLE_U8);

    if (r)
        return ttf_err_set(err, r, "test", "no memory");
    r = ttf_jpeg_write(io, handle, &bytes, 90, err);
    ttf_pixbuf_free(&bytes);
    return r;
}

int format_write_dng(struct ttf_err *err)
{
    return ttf_dng_write(&flat, &dng_info, io, handle, err);
}

static struct ttf_develop_config developing(void)
{
    return (struct ttf_develop_config){
        .format = flat.format, .calibration = &calibration, .encoding = {TTF_PEDESTAL, TTF_SCALE}};
}

int format_develop_to_tiff(struct ttf_err *err)
{
    struct ttf_develop_config config = developing();
    struct ttf_develop *develop;
    int r = ttf_develop_create(&config, &develop, err);

    if (r)
        return r;
    r = ttf_develop_tiff(develop, &flat, NULL, NULL, io, handle, NULL, err);
    ttf_develop_destroy(develop);
    return r;
}

int format_develop_in_reserve(struct ttf_err *err)
{
    struct ttf_develop_config config = developing();
    struct ttf_pool *pool = ttf_pool_create(2);
    struct ttf_develop *develop = NULL;
    struct ttf_pixbuf to = {0};
    int r = pool ? ttf_develop_create(&config, &develop, err)
                 : ttf_err_set(err, -ENOMEM, "test", "no memory");

    if (r == 0)
        r = ttf_develop_reserve(develop, pool, true, err);
    if (r == 0 && ttf_pixbuf_alloc(&to, SIDE, SIDE, 3, TTF_SAMPLE_U16) != 0)
        r = ttf_err_set(err, -ENOMEM, "test", "no memory");
    if (r == 0)
        r = ttf_develop_run(develop, &flat, pool, &to, NULL, err);
    ttf_pixbuf_free(&to);
    ttf_develop_destroy(develop);
    ttf_pool_destroy(pool);
    return r;
}

static const struct ttf_pixbuf *expected;

/* What is read is what was written, or nothing. */
static int read_picture(const char *name, struct ttf_err *err)
{
    struct ttf_pixbuf got = {0};
    struct ttf_image_info info;
    int r = ttf_image_read(io, format_in(name), 0, &got, &info, err);

    if (r)
        return r;
    assert_int_equal(info.width, SIDE);
    assert_int_equal(info.transfer, TTF_TRANSFER_LINEAR);
    assert_int_equal(got.format, expected->format);
    for (uint32_t y = 0; y < SIDE; y++)
        assert_memory_equal(ttf_pixbuf_row(&got, y), ttf_pixbuf_row(expected, y), got.stride);
    ttf_pixbuf_free(&got);
    return 0;
}

int format_read_tiff(struct ttf_err *err)
{
    expected = &picture;
    return read_picture("picture.tif", err);
}

int format_read_floats(struct ttf_err *err)
{
    expected = &floats;
    return read_picture("floats.tif", err);
}

int format_read_png(struct ttf_err *err)
{
    expected = &picture;
    return read_picture("picture.png", err);
}

int format_read_jpeg(struct ttf_err *err)
{
    struct ttf_pixbuf got = {0};
    int r = ttf_image_read_linear(io, format_in("picture.jpg"), &got, NULL, err);

    ttf_pixbuf_free(&got);
    return r;
}

int format_probe(struct ttf_err *err)
{
    struct ttf_image_info info;
    int r = ttf_image_probe(io, format_in("picture.jpg"), &info, err);

    r = r ? r : ttf_image_probe(io, format_in("picture.png"), &info, err);
    r = r ? r : ttf_image_probe(io, format_in("picture.tif"), &info, err);
    if (r == 0)
        assert_int_equal(info.taken_utc_ns, 1000000000);
    return r;
}

int format_read_dng(struct ttf_err *err)
{
    struct ttf_raw_sum got;
    struct ttf_dng_info info;
    int r = ttf_dng_read(io, format_in("raw.dng"), &got, &info, err);

    if (r)
        return r;
    assert_string_equal(info.serial, "1");
    assert_int_equal(info.times.exposure_ns, 20000000);
    assert_memory_equal(got.sum, flat.sum, SIDE * SIDE * sizeof(*got.sum));
    ttf_raw_sum_free(&got);
    return 0;
}

int format_read_sequence(struct ttf_err *err)
{
    uint16_t rows[SIDE * SIDE * 3];
    struct ttf_sequence *s;
    int r = ttf_sequence_of_image(io, format_in("picture.png"), &s, err);

    if (r)
        return r;
    r = ttf_sequence_read_rows(s, 0, 0, SIDE, rows, err);
    ttf_sequence_destroy(s);
    return r;
}

int format_fit(struct ttf_err *err)
{
    struct ttf_calibration c;
    int r;

    ttf_calibration_init(&c);
    snprintf(c.camera, sizeof(c.camera), "top");
    r = ttf_calibration_fit_dark(&c, &dark, err);
    if (r == 0)
        r = ttf_calibration_fit_flat(&c, &flat, 0.9, err);
    if (r == 0)
        r = ttf_calibration_name(&c, err);
    if (r == 0)
        assert_string_equal(c.id, calibration.id);
    ttf_calibration_free(&c);
    return r;
}

int format_save(struct ttf_err *err)
{
    return ttf_calibration_save(&calibration, io, format_in("saved"), err);
}

int format_load(struct ttf_err *err)
{
    struct ttf_calibration c;
    int r = ttf_calibration_load(io, format_in("calibration"), &c, err);

    if (r)
        return r;
    assert_string_equal(c.id, calibration.id);
    ttf_calibration_free(&c);
    return 0;
}

int format_import_pictures(struct ttf_err *err)
{
    char png[100], tiff[100], out[100];
    const char *const inputs[] = {png, tiff};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = out,
                                       .interval_ns = TTF_NS_PER_S,
                                       .order = TTF_IMPORT_NATURAL};
    struct ttf_import_result result;

    snprintf(png, sizeof(png), "%s", format_in("picture.png"));
    snprintf(tiff, sizeof(tiff), "%s", format_in("picture.tif"));
    snprintf(out, sizeof(out), "%s", format_in("out"));
    return ttf_import(io, &config, &result, err);
}

static int export_as(enum ttf_export_kind kind, struct ttf_err *err)
{
    struct ttf_encoding encoding = {.scale = 65535};
    char out[100];
    struct ttf_export_config config = {
        .kind = kind, .output = out, .gaps = TTF_GAPS_INTERPOLATE, .width_max = 11};
    struct ttf_export_result result;
    struct ttf_sequence *s;
    int r = ttf_sequence_of_memory(picture.data, SIDE, SIDE / 3, 3, &encoding, &s, err);

    if (r)
        return r;
    snprintf(out, sizeof(out), "%s", format_in("out"));
    r = ttf_export(s, io, &config, &result, err);
    ttf_sequence_destroy(s);
    return r;
}

int format_export_png(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_PNG, err);
}

int format_export_tiff(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_TIFF, err);
}

int format_export_npy(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_NPY, err);
}

int format_export_y4m(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_Y4M, err);
}

int format_export_sheet(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_SHEET, err);
}

static void make_raw(struct ttf_raw_sum *sum, uint32_t code)
{
    const struct ttf_frame_format format = {.width = SIDE,
                                            .height = SIDE,
                                            .packing = TTF_PACKING_RAW16,
                                            .stride = 2 * SIDE,
                                            .cfa = TTF_CFA_RGGB,
                                            .bits = 12,
                                            .black_level = 64,
                                            .white_level = 4095};

    assert_int_equal(ttf_raw_sum_init(sum, &format), 0);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        sum->sum[i] = code + i % 5;
    sum->n = 1;
    sum->settings = (struct ttf_exposure){.exposure_ns = 20 * TTF_NS_PER_MS, .gain_milli = 1000};
}

int format_write_floats(struct ttf_err *err)
{
    return ttf_tiff_write(io, handle, &floats, &tiff_spec, err);
}

void format_works_begin(struct ttf_io *on, const char *in_folder)
{
    io = on;
    folder = in_folder;
    make_raw(&dark, 70);
    make_raw(&flat, 2000);
    assert_int_equal(ttf_pixbuf_alloc(&picture, SIDE, SIDE, 3, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_pixbuf_alloc(&floats, SIDE, SIDE, 3, TTF_SAMPLE_F32), 0);
    for (uint32_t i = 0; i < SIDE * SIDE * 3; i++) {
        ((uint16_t *)picture.data)[i] = (uint16_t)(i * 37 % 65536);
        ((float *)floats.data)[i] = (float)i / 1000;
    }
    ttf_calibration_init(&calibration);
    snprintf(calibration.camera, sizeof(calibration.camera), "top");
    assert_int_equal(ttf_calibration_fit_dark(&calibration, &dark, NULL), 0);
    assert_int_equal(ttf_calibration_fit_flat(&calibration, &flat, 0.9, NULL), 0);
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
}

void format_works_on(struct ttf_io *on)
{
    io = on;
}

struct ttf_io *format_io(void)
{
    return io;
}

void format_open_new(void)
{
    (void)io->ops->unlink(io, format_in("new"));
    handle = io->ops->open(io, format_in("new"), TTF_IO_CREATE_NEW);
    assert_true(handle >= 0);
}

int format_close_new(void)
{
    return io->ops->close(io, handle);
}

void format_keep(const char *name, int (*write)(struct ttf_err *err))
{
    struct ttf_err err = {0};
    char from[100];

    format_open_new();
    if (write(&err) != 0)
        fail_msg("%s: %s", name, err.what);
    assert_int_equal(format_close_new(), 0);
    snprintf(from, sizeof(from), "%s", format_in("new"));
    assert_int_equal(io->ops->rename(io, from, format_in(name)), 0);
}

void format_works_files(void)
{
    assert_int_equal(ttf_io_mkdirs(io, format_in("calibration"), NULL), 0);
    assert_int_equal(ttf_io_mkdirs(io, format_in("saved"), NULL), 0);
    assert_int_equal(ttf_calibration_save(&calibration, io, format_in("calibration"), NULL), 0);
    format_keep("picture.tif", format_write_tiff);
    format_keep("floats.tif", format_write_floats);
    format_keep("picture.png", format_write_png);
    format_keep("picture.jpg", format_write_jpeg);
    format_keep("raw.dng", format_write_dng);
}

void format_works_end(void)
{
    ttf_raw_sum_free(&dark);
    ttf_raw_sum_free(&flat);
    ttf_pixbuf_free(&picture);
    ttf_pixbuf_free(&floats);
    ttf_calibration_free(&calibration);
}
