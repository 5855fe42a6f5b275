/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Each allocation of reading and writing each format, of calibrating and developing, of importing and
 * exporting fails once (README.md).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "each_allocation.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/export.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/tiff.h"

#define SIDE 24

static struct alloc_run run_of_all; /* set once, by main */
static char folder[] = "/tmp/ttf-alloc-formats-XXXXXX";
static struct ttf_io *io;

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

static const char *in(const char *name)
{
    static char path[100];

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return path;
}

static void run_each(const struct alloc_piece *pieces, size_t n)
{
    for (size_t i = 0; i < n; i++)
        each_allocation_fails(&pieces[i], run_of_all);
}

#define RUN_EACH(pieces) run_each(pieces, sizeof(pieces) / sizeof((pieces)[0]))

/* ---- writing ---- */

static int handle; /* of the file "new", in writing */

static void begin_file(void)
{
    alloc_hook_pause();
    (void)unlink(in("new"));
    handle = io->ops->open(io, in("new"), TTF_IO_CREATE_NEW);
    alloc_hook_resume();
    assert_true(handle >= 0);
}

static void end_file(int r)
{
    assert_int_equal(io->ops->close(io, handle), 0);
}

static int write_tiff(struct ttf_err *err)
{
    return ttf_tiff_write(io, handle, &picture, &tiff_spec, err);
}

static int write_png(struct ttf_err *err)
{
    return ttf_png_write(io, handle, &picture, TTF_TRANSFER_LINEAR, 6, "says", err);
}

static int write_jpeg(struct ttf_err *err)
{
    struct ttf_pixbuf bytes = {0};
    int r = ttf_pixbuf_alloc(&bytes, SIDE, SIDE, 3, TTF_SAMPLE_U8);

    if (r)
        return ttf_err_set(err, r, "test", "no memory");
    r = ttf_jpeg_write(io, handle, &bytes, 90, err);
    ttf_pixbuf_free(&bytes);
    return r;
}

static int write_dng(struct ttf_err *err)
{
    return ttf_dng_write(&flat, &dng_info, io, handle, err);
}

static struct ttf_develop_config developing(void)
{
    return (struct ttf_develop_config){
        .format = flat.format, .calibration = &calibration, .encoding = {TTF_PEDESTAL, TTF_SCALE}};
}

static int develop_to_tiff(struct ttf_err *err)
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

static int develop_in_reserve(struct ttf_err *err)
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

static void a_file_that_found_no_memory_says_so(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "writing TIFF",
         .begin = begin_file,
         .work = write_tiff,
         .ours_only = true,
         .end = end_file},
        {.name = "writing PNG", .begin = begin_file, .work = write_png, .end = end_file},
        {.name = "writing JPEG", .begin = begin_file, .work = write_jpeg, .end = end_file},
        {.name = "writing DNG",
         .begin = begin_file,
         .work = write_dng,
         .ours_only = true,
         .end = end_file},
        {.name = "developing",
         .begin = begin_file,
         .work = develop_to_tiff,
         .ours_only = true,
         .end = end_file},
        {.name = "developing in reserve", .work = develop_in_reserve, .ours_only = true},
    };

    RUN_EACH(pieces);
}

/* ---- reading ---- */

static const struct ttf_pixbuf *expected;

/* What is read is what was written, or nothing. */
static int read_picture(const char *name, struct ttf_err *err)
{
    struct ttf_pixbuf got = {0};
    struct ttf_image_info info;
    int r = ttf_image_read(io, in(name), 0, &got, &info, err);

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

static int read_tiff(struct ttf_err *err)
{
    expected = &picture;
    return read_picture("picture.tif", err);
}

static int read_floats(struct ttf_err *err)
{
    expected = &floats;
    return read_picture("floats.tif", err);
}

static int read_png(struct ttf_err *err)
{
    expected = &picture;
    return read_picture("picture.png", err);
}

static int read_jpeg(struct ttf_err *err)
{
    struct ttf_pixbuf got = {0};
    int r = ttf_image_read_linear(io, in("picture.jpg"), &got, NULL, err);

    ttf_pixbuf_free(&got);
    return r;
}

static int probe(struct ttf_err *err)
{
    struct ttf_image_info info;
    int r = ttf_image_probe(io, in("picture.jpg"), &info, err);

    r = r ? r : ttf_image_probe(io, in("picture.png"), &info, err);
    r = r ? r : ttf_image_probe(io, in("picture.tif"), &info, err);
    if (r == 0)
        assert_int_equal(info.taken_utc_ns, 1000000000);
    return r;
}

static int read_dng(struct ttf_err *err)
{
    struct ttf_raw_sum got;
    struct ttf_dng_info info;
    int r = ttf_dng_read(io, in("raw.dng"), &got, &info, err);

    if (r)
        return r;
    assert_string_equal(info.serial, "1");
    assert_int_equal(info.times.exposure_ns, 20000000);
    assert_memory_equal(got.sum, flat.sum, SIDE * SIDE * sizeof(*got.sum));
    ttf_raw_sum_free(&got);
    return 0;
}

static int read_sequence(struct ttf_err *err)
{
    uint16_t rows[SIDE * SIDE * 3];
    struct ttf_sequence *s;
    int r = ttf_sequence_of_image(io, in("picture.png"), &s, err);

    if (r)
        return r;
    r = ttf_sequence_read_rows(s, 0, 0, SIDE, rows, err);
    ttf_sequence_destroy(s);
    return r;
}

static void a_picture_is_read_as_it_is_or_not_at_all(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "reading TIFF", .work = read_tiff, .ours_only = true},
        {.name = "reading TIFF of floats", .work = read_floats, .ours_only = true},
        {.name = "reading PNG", .work = read_png},
        {.name = "reading JPEG", .work = read_jpeg},
        {.name = "looking at pictures", .work = probe, .ours_only = true},
        {.name = "reading DNG", .work = read_dng, .ours_only = true},
        {.name = "a picture as a sequence", .work = read_sequence},
    };

    RUN_EACH(pieces);
}

/* ---- calibrations ---- */

static int fit(struct ttf_err *err)
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

static int save(struct ttf_err *err)
{
    return ttf_calibration_save(&calibration, io, in("saved"), err);
}

static int load(struct ttf_err *err)
{
    struct ttf_calibration c;
    int r = ttf_calibration_load(io, in("calibration"), &c, err);

    if (r)
        return r;
    assert_string_equal(c.id, calibration.id);
    ttf_calibration_free(&c);
    return 0;
}

static void a_calibration_is_whole_or_none(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "fitting a calibration", .work = fit},
        {.name = "saving one", .work = save, .ours_only = true},
        {.name = "loading one", .work = load, .ours_only = true},
    };

    RUN_EACH(pieces);
}

/* ---- import and export ---- */

static int remove_one(const char *path, const struct stat *what, int kind, struct FTW *at)
{
    return remove(path);
}

static void remove_tree(const char *path)
{
    alloc_hook_pause();
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread */
    assert_int_equal(nftw(path, remove_one, 8, FTW_DEPTH | FTW_PHYS), 0);
    alloc_hook_resume();
}

static void begin_output(void)
{
    if (access(in("out"), F_OK) == 0)
        remove_tree(in("out"));
    (void)remove(in("out.json"));
}

/* Neither it nor a piece of it is there, unless it is whole. */
static void end_output(int r)
{
    const struct dirent *entry;
    DIR *dir;

    alloc_hook_pause();
    dir = opendir(folder);
    assert_non_null(dir);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread */
    while (dir && (entry = readdir(dir)))
        if (r != 0 && (strncmp(entry->d_name, "out", 3) == 0 || strstr(entry->d_name, ".tmp")))
            fail_msg("%s was left behind", entry->d_name);
    if (dir)
        closedir(dir);
    alloc_hook_resume();
    if (r == 0)
        assert_int_equal(access(in("out"), F_OK), 0);
}

static int import_pictures(struct ttf_err *err)
{
    char png[100], tiff[100], out[100];
    const char *const inputs[] = {png, tiff};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = out,
                                       .interval_ns = TTF_NS_PER_S,
                                       .order = TTF_IMPORT_NATURAL};
    struct ttf_import_result result;

    snprintf(png, sizeof(png), "%s", in("picture.png"));
    snprintf(tiff, sizeof(tiff), "%s", in("picture.tif"));
    snprintf(out, sizeof(out), "%s", in("out"));
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
    snprintf(out, sizeof(out), "%s", in("out"));
    r = ttf_export(s, io, &config, &result, err);
    ttf_sequence_destroy(s);
    return r;
}

static int export_png(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_PNG, err);
}

static int export_tiff(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_TIFF, err);
}

static int export_npy(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_NPY, err);
}

static int export_y4m(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_Y4M, err);
}

static int export_sheet(struct ttf_err *err)
{
    return export_as(TTF_EXPORT_SHEET, err);
}

static void what_is_imported_or_exported_is_whole_or_not_there(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "importing pictures",
         .begin = begin_output,
         .work = import_pictures,
         .ours_only = true,
         .end = end_output,
         .may_do_without = true, /* the dataset's reserve */
         .share = 3,
         .share_of_all = 61},
        {.name = "exporting PNG", .begin = begin_output, .work = export_png, .end = end_output},
        {.name = "exporting TIFF",
         .begin = begin_output,
         .work = export_tiff,
         .ours_only = true,
         .end = end_output,
         .share_of_all = 7},
        {.name = "exporting NPY", .begin = begin_output, .work = export_npy, .end = end_output},
        {.name = "exporting Y4M", .begin = begin_output, .work = export_y4m, .end = end_output},
        {.name = "exporting a sheet",
         .begin = begin_output,
         .work = export_sheet,
         .end = end_output},
    };

    RUN_EACH(pieces);
}

/* ---- */

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

static void keep(const char *name, int (*write)(struct ttf_err *err))
{
    struct ttf_err err = {0};
    char from[100];

    begin_file();
    if (write(&err) != 0)
        fail_msg("%s: %s", name, err.what);
    end_file(0);
    snprintf(from, sizeof(from), "%s", in("new"));
    assert_int_equal(rename(from, in(name)), 0);
}

static int write_floats(struct ttf_err *err)
{
    return ttf_tiff_write(io, handle, &floats, &tiff_spec, err);
}

static int make(void **state)
{
    io = ttf_io_posix();
    if (!mkdtemp(folder))
        return -1;
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
    assert_int_equal(ttf_io_mkdirs(io, in("calibration"), NULL), 0);
    assert_int_equal(ttf_io_mkdirs(io, in("saved"), NULL), 0);
    assert_int_equal(ttf_calibration_save(&calibration, io, in("calibration"), NULL), 0);
    keep("picture.tif", write_tiff);
    keep("floats.tif", write_floats);
    keep("picture.png", write_png);
    keep("picture.jpg", write_jpeg);
    keep("raw.dng", write_dng);
    return 0;
}

static int clear(void **state)
{
    ttf_raw_sum_free(&dark);
    ttf_raw_sum_free(&flat);
    ttf_pixbuf_free(&picture);
    ttf_pixbuf_free(&floats);
    ttf_calibration_free(&calibration);
    remove_tree(folder);
    return 0;
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_that_found_no_memory_says_so),
        cmocka_unit_test(a_picture_is_read_as_it_is_or_not_at_all),
        cmocka_unit_test(a_calibration_is_whole_or_none),
        cmocka_unit_test(what_is_imported_or_exported_is_whole_or_not_there),
    };

    run_of_all = alloc_run_of(argc, argv);
    return cmocka_run_group_tests(tests, make, clear);
}
