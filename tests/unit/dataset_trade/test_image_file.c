/* SPDX-License-Identifier: Apache-2.0 */
#include "trade_test.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h> /* after stdio.h, which it needs */

#include "ttf/dataset/hash.h"
#include "ttf/dataset/icc.h"

static struct ttf_pixbuf read_ok(const char *path, struct ttf_image_info *info)
{
    struct ttf_pixbuf pixels = {0};
    struct ttf_err err = {0};

    if (ttf_image_read(ttf_io_posix(), path, 0, &pixels, info, &err))
        fail_msg("%s: %s", err.where, err.what);
    return pixels;
}

static void png_of_every_depth_comes_back_to_the_bit(void **state)
{
    for (uint32_t samples = 1; samples <= 4; samples++) {
        for (int format = TTF_SAMPLE_U8; format <= TTF_SAMPLE_U16; format++) {
            const char *path = in_folder(state, "a.png");
            struct ttf_pixbuf out = make_picture(37, 21, samples, (enum ttf_sample)format, samples);
            struct ttf_image_info info;
            struct ttf_pixbuf in;

            save_png(path, &out);
            in = read_ok(path, &info);
            assert_true(same_pixels(&out, &in));
            assert_int_equal(info.kind, TTF_IMAGE_PNG);
            assert_int_equal(info.transfer, TTF_TRANSFER_SRGB);
            assert_int_equal(info.bits, format == TTF_SAMPLE_U16 ? 16 : 8);
            assert_true(info.taken_utc_ns == TTF_NS_UNKNOWN);
            ttf_pixbuf_free(&out);
            ttf_pixbuf_free(&in);
        }
    }
}

static void jpeg_comes_back_nearly_and_says_its_size_without_decoding(void **state)
{
    const char *path = in_folder(state, "a.jpg");
    struct ttf_pixbuf out, in;
    struct ttf_image_info info;
    int worst = 0;

    assert_int_equal(ttf_pixbuf_alloc(&out, 64, 40, 3, TTF_SAMPLE_U8), 0);
    for (uint32_t y = 0; y < 40; y++)
        for (uint32_t i = 0; i < 64 * 3; i++)
            ((uint8_t *)ttf_pixbuf_row(&out, y))[i] = (uint8_t)(i + y);
    save_jpeg(path, &out, 97);
    in = read_ok(path, &info);
    assert_int_equal(in.width, 64);
    assert_int_equal(in.samples, 3);
    for (uint32_t y = 0; y < 40; y++)
        for (uint32_t i = 0; i < 64 * 3; i++) {
            int d = abs(((uint8_t *)ttf_pixbuf_row(&out, y))[i] -
                        ((uint8_t *)ttf_pixbuf_row(&in, y))[i]);
            worst = d > worst ? d : worst;
        }
    assert_true(worst <= 12);
    assert_int_equal(ttf_image_probe(ttf_io_posix(), path, &info, NULL), 0);
    assert_int_equal(info.width, 64);
    assert_int_equal(info.height, 40);
    ttf_pixbuf_free(&out);
    ttf_pixbuf_free(&in);
}

/* An EXIF block as cameras write it: little-endian, orientation, folder with original time, zone, split seconds. */
static size_t exif_block(uint8_t *out, unsigned orientation)
{
    static const uint8_t head[] = {'I', 'I', '*', 0, 8, 0, 0, 0, 2, 0};
    uint8_t *p = out;
    const uint8_t orient[] = {0x12, 1, 3, 0, 1, 0, 0, 0, (uint8_t)orientation, 0, 0, 0};
    const uint8_t folder[] = {0x69, 0x87, 4, 0, 1, 0, 0, 0, 38, 0, 0, 0, 0, 0, 0, 0};
    const uint8_t inner[] = {3,    0,    0x03, 0x90, 2, 0, 20,  0,   0,   0, 80, 0, 0,    0,
                             0x11, 0x90, 2,    0,    7, 0, 0,   0,   100, 0, 0,  0, 0x91, 0x92,
                             2,    0,    4,    0,    0, 0, '2', '5', 0,   0, 0,  0, 0,    0};

    memcpy(p, head, sizeof(head));
    p += sizeof(head);
    memcpy(p, orient, sizeof(orient));
    p += sizeof(orient);
    memcpy(p, folder, sizeof(folder));
    p += sizeof(folder);
    memcpy(p, inner, sizeof(inner));
    memcpy(out + 80, "2005:05:04 18:13:49", 20);
    memcpy(out + 100, "+02:00", 7);
    return 107;
}

/* Puts the block into a JPEG, behind its first marker. */
static void add_exif(const char *path, unsigned orientation)
{
    uint8_t app1[4 + 6 + 128] = {0xff, 0xe1, 0, 0, 'E', 'x', 'i', 'f', 0, 0}, *old, *all;
    size_t n, block = exif_block(app1 + 10, orientation);

    app1[2] = (uint8_t)((block + 8) >> 8);
    app1[3] = (uint8_t)(block + 8);
    old = slurp(path, &n);
    all = malloc(n + block + 10);
    memcpy(all, old, 2);
    memcpy(all + 2, app1, block + 10);
    memcpy(all + 2 + block + 10, old + 2, n - 2);
    write_bytes(path, all, n + block + 10);
    free(old);
    free(all);
}

static void exif_says_when_and_which_side_is_up(void **state)
{
    /* A white spot in the stored corner (0, 0): where it goes for each orientation. */
    static const struct {
        bool right, bottom;
    } corner[9] = {{0},           {false, false}, {true, false},
                   {true, true},  {false, true},  {false, false},
                   {true, false}, {true, true},   {false, true}};

    for (unsigned orientation = 1; orientation <= 8; orientation++) {
        const char *path = in_folder(state, "o%u.jpg", orientation);
        struct ttf_pixbuf out, in;
        struct ttf_image_info info;
        uint32_t x, y;

        assert_int_equal(ttf_pixbuf_alloc(&out, 48, 32, 1, TTF_SAMPLE_U8), 0);
        for (y = 0; y < 8; y++)
            memset(ttf_pixbuf_row(&out, y), 255, 8);
        save_jpeg(path, &out, 95);
        add_exif(path, orientation);
        in = read_ok(path, &info);
        assert_int_equal(in.width, orientation < 5 ? 48 : 32);
        assert_int_equal(info.width, in.width);
        x = corner[orientation].right ? in.width - 4 : 4;
        y = corner[orientation].bottom ? in.height - 4 : 4;
        assert_true(((uint8_t *)ttf_pixbuf_row(&in, y))[x] > 200);
        assert_true(((uint8_t *)ttf_pixbuf_row(&in, in.height - 1 - y))[x] < 50);
        assert_true(((uint8_t *)ttf_pixbuf_row(&in, y))[in.width - 1 - x] < 50);
        /* 18:13:49.25 at two hours east */
        assert_true(info.zone_known);
        assert_true(info.taken_utc_ns == INT64_C(1115223229) * TTF_NS_PER_S + 250000000);
        ttf_pixbuf_free(&out);
        ttf_pixbuf_free(&in);
    }
}

static void times_are_found_in_file_names(void **state)
{
    const int64_t minute = INT64_C(1590690000) * TTF_NS_PER_S; /* 2020-05-28 18:20 */

    assert_true(ttf_time_in_name("11_F_2020-05-28_18-20_U.png") == minute);
    assert_true(ttf_time_in_name("20200528182000.png") == minute);
    assert_true(ttf_time_in_name("IMG_20200528_182007.jpg") == minute + 7 * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("2020-05-28T18:20:07Z") == minute + 7 * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("S60_050504_181349.jpg") == INT64_C(1115230429) * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("000123.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2020-13-28_18-20.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2021-02-29_18-20.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("") == TTF_NS_UNKNOWN);
    /* Leap days, and the bounds of each part. */
    assert_true(ttf_time_in_name("2020-02-29_00-00.png") == INT64_C(1582934400) * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("2000-02-29_00-00.png") == INT64_C(951782400) * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("1900-02-29_00-00.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("1960-01-01_00-00.png") == INT64_C(-315619200) * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("2020-00-28_18-20.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2020-05-00_18-20.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2020-04-31_18-20.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2020-05-28_24-00.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2020-05-28_18-60.png") == TTF_NS_UNKNOWN);
    assert_true(ttf_time_in_name("2020-05-28_18-20-61.png") != minute + 61 * TTF_NS_PER_S);
    assert_true(ttf_time_in_name("701231_235959.jpg") == INT64_C(31535999) * TTF_NS_PER_S);
}

static void eight_bit_pictures_become_light_and_come_back_to_the_bit(void **state)
{
    const char *path = in_folder(state, "a.png");
    struct ttf_pixbuf out = make_picture(50, 40, 4, TTF_SAMPLE_U8, 3), linear;

    save_png(path, &out);
    assert_int_equal(ttf_image_read_linear(ttf_io_posix(), path, &linear, NULL, NULL), 0);
    assert_int_equal(linear.samples, 3);
    for (uint32_t y = 0; y < 40; y++)
        for (uint32_t x = 0; x < 50; x++)
            for (uint32_t c = 0; c < 3; c++)
                assert_int_equal(
                    ttf_linear16_to_srgb8(((uint16_t *)ttf_pixbuf_row(&linear, y))[x * 3 + c]),
                    ((uint8_t *)ttf_pixbuf_row(&out, y))[x * 4 + c]);
    ttf_pixbuf_free(&out);
    ttf_pixbuf_free(&linear);
}

static void what_is_no_picture_is_refused_with_its_path(void **state)
{
    const char *path = in_folder(state, "a.png");
    struct ttf_pixbuf pixels;
    struct ttf_err err = {0};

    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err), -ENOENT);
    assert_string_equal(err.where, path);
    write_bytes(path, "hello", 5);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err), -ENOTSUP);
    assert_string_equal(err.where, path);
    write_bytes(path, "", 0);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err), -ENOTSUP);
    assert_non_null(strstr(err.what, "empty"));
    picture_file(path, 4, 4, 1);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 1, &pixels, NULL, &err), -EINVAL);
}

static void a_forged_size_is_refused_before_memory_is_asked_for(void **state)
{
    const char *path = in_folder(state, "a.png");
    struct ttf_pixbuf pixels;
    struct ttf_err err = {0};
    static const uint8_t huge[8] = {0, 0x0f, 0xff, 0xff,
                                    0, 0x0f, 0xff, 0xff}; /* 1048575 x 1048575 */
    uint8_t *data;
    uint32_t crc;
    size_t n;

    picture_file(path, 4, 4, 1);
    data = slurp(path, &n);
    memcpy(data + 16, huge, sizeof(huge));
    crc = ttf_crc32(0, data + 12, 17);
    for (unsigned i = 0; i < 4; i++)
        data[29 + i] = (uint8_t)(crc >> (24 - 8 * i));
    write_bytes(path, data, n);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err), -EFBIG);
    assert_string_equal(err.where, path);
    free(data);
}

/* Every cut and many flipped bits: an error with the path or whole pixels, never a crash (run under ASan). */
static void torture(void **state, const char *path, unsigned least_refused)
{
    const char *bad = in_folder(state, "bad");
    size_t n;
    uint8_t *data = slurp(path, &n), *copy = malloc(n);
    unsigned refused = 0;

    for (size_t cut = 0; cut < n; cut += 1 + n / 150) {
        struct ttf_pixbuf pixels = {0};
        struct ttf_err err = {0};
        int code;

        write_bytes(bad, data, cut);
        code = ttf_image_read(ttf_io_posix(), bad, 0, &pixels, NULL, &err);
        if (code == 0)
            ttf_pixbuf_free(&pixels);
        else
            assert_string_equal(err.where, bad);
        if (cut < n - 12)
            assert_true(code < 0);
    }
    for (unsigned i = 0; i < 400; i++) {
        struct ttf_pixbuf pixels = {0};
        size_t at = (size_t)i * 2654435761u % (i % 2 ? n : n < 300 ? n : 300);

        memcpy(copy, data, n);
        copy[at] ^= (uint8_t)(1u << (i % 8));
        if (i % 3 == 0)
            copy[(at + 1) % n] = 0xff;
        write_bytes(bad, copy, n);
        if (ttf_image_read(ttf_io_posix(), bad, 0, &pixels, NULL, NULL) == 0)
            ttf_pixbuf_free(&pixels);
        else
            refused++;
    }
    assert_true(refused >= least_refused);
    free(copy);
    free(data);
}

static void broken_png_never_crashes(void **state)
{
    const char *path = in_folder(state, "a.png");

    picture_file(path, 40, 30, 5);
    torture(state, path, 50);
}

static void broken_jpeg_never_crashes(void **state)
{
    const char *path = in_folder(state, "a.jpg");
    struct ttf_pixbuf pixels = make_picture(40, 30, 3, TTF_SAMPLE_U8, 5);

    save_jpeg(path, &pixels, 80);
    add_exif(path, 6);
    torture(state, path, 50);
    ttf_pixbuf_free(&pixels);
}

/* What libjpeg writes of 8 x 8 pixels of so many components, in so many scans. */
static void odd_jpeg(const char *path, int components, int scans)
{
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    jpeg_scan_info *script = calloc((size_t)scans, sizeof(*script));
    unsigned char *bytes = NULL;
    unsigned long n = 0;
    JSAMPLE row[8 * 4] = {0};
    JSAMPROW rows[] = {row};

    assert_non_null(script);
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &n);
    jpeg.image_width = jpeg.image_height = 8;
    jpeg.input_components = components;
    jpeg.in_color_space = components == 4 ? JCS_CMYK : JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg);
    /* Each frequency on its own. */
    for (int i = 0; i < scans; i++)
        script[i] = (jpeg_scan_info){.comps_in_scan = 1, .Ss = i, .Se = i, .Al = 0};
    if (scans > 1) {
        jpeg.scan_info = script;
        jpeg.num_scans = scans;
    }
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height)
        (void)jpeg_write_scanlines(&jpeg, rows, 1);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    write_bytes(path, bytes, n);
    free(bytes);
    free(script);
}

static void a_jpeg_for_print_is_refused_with_what_to_do(void **state)
{
    const char *path = in_folder(state, "cmyk.jpg");
    struct ttf_pixbuf pixels = {0};
    struct ttf_err err = {0};

    odd_jpeg(path, 4, 1);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err), -ENOTSUP);
    assert_non_null(strstr(err.what, "4 components (CMYK?)"));
    assert_non_null(strstr(err.hint, "save it as RGB"));
    assert_null(pixels.data);
}

/* Some encoders write zeros where a scan says which frequencies it holds, which of a plain JPEG are always all. */
static void a_jpeg_whose_scan_says_nothing_of_itself_is_whole(void **state)
{
    const char *path = in_folder(state, "zeros.jpg");
    struct ttf_pixbuf pixels = make_picture(24, 16, 3, TTF_SAMPLE_U8, 5), whole, zeros;
    size_t n, scan;
    uint8_t *bytes;

    save_jpeg(path, &pixels, 90);
    whole = read_ok(path, NULL);
    bytes = slurp(path, &n);
    for (scan = 0; !(bytes[scan] == 0xff && bytes[scan + 1] == 0xda); scan++)
        assert_true(scan + 14 < n);
    assert_int_equal(bytes[scan + 12],
                     63); /* behind the length, 3 components of 2 bytes, the first frequency */
    bytes[scan + 12] = 0;
    write_bytes(path, bytes, n);
    zeros = read_ok(path, NULL);
    assert_true(same_pixels(&whole, &zeros));
    free(bytes);
    ttf_pixbuf_free(&pixels);
    ttf_pixbuf_free(&whole);
    ttf_pixbuf_free(&zeros);
}

/* A small file that says the same pixels over and over: each scan costs as much as the first. */
static void a_jpeg_of_endless_scans_is_refused(void **state)
{
    const char *path = in_folder(state, "scans.jpg");
    struct ttf_pixbuf pixels = {0};
    struct ttf_err err = {0};
    size_t n, scan, at;
    uint8_t *bytes, *many;

    odd_jpeg(path, 1, 64);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err), 0);
    ttf_pixbuf_free(&pixels);
    bytes = slurp(path, &n);
    for (scan = n - 2; !(bytes[scan - 1] == 0xff && bytes[scan] == 0xda); scan--)
        assert_true(scan > 2);
    scan--; /* the last scan, to the end's mark */
    many = malloc(n + 300 * (n - 2 - scan));
    assert_non_null(many);
    memcpy(many, bytes, n - 2);
    at = n - 2;
    for (int i = 0; i < 300; i++, at += n - 2 - scan)
        memcpy(many + at, bytes + scan, n - 2 - scan);
    memcpy(many + at, bytes + n - 2, 2);
    write_bytes(path, many, at + 2);
    assert_true(ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err) < 0);
    if (!strstr(err.what, "more than 200 scans"))
        fail_msg("%s", err.what);
    assert_null(pixels.data);
    free(bytes);
    free(many);
}

/* Puts a profile into a JPEG as one APP2 segment, behind its first marker. */
static void add_profile(const char *path, enum ttf_icc icc)
{
    static const uint8_t head[18] = {0xff, 0xe2, 0,   0,   'I', 'C', 'C', '_', 'P',
                                     'R',  'O',  'F', 'I', 'L', 'E', 0,   1,   1};
    uint8_t *profile, *old, *all;
    size_t n, bytes, segment;

    assert_int_equal(ttf_icc_create(icc, 3, &profile, &bytes, NULL), 0);
    old = slurp(path, &n);
    segment = bytes + 16;
    all = malloc(n + segment + 2);
    memcpy(all, old, 2);
    memcpy(all + 2, head, sizeof(head));
    all[4] = (uint8_t)(segment >> 8);
    all[5] = (uint8_t)segment;
    memcpy(all + 20, profile, bytes);
    memcpy(all + 20 + bytes, old + 2, n - 2);
    write_bytes(path, all, n + bytes + 18);
    free(profile);
    free(old);
    free(all);
}

static void an_srgb_profile_is_known_and_another_is_told(void **state)
{
    const char *path = in_folder(state, "a.jpg");
    struct ttf_pixbuf pixels = make_picture(16, 16, 3, TTF_SAMPLE_U8, 5);
    struct ttf_image_info info;

    save_jpeg(path, &pixels, 80);
    add_profile(path, TTF_ICC_SRGB);
    assert_int_equal(ttf_image_probe(ttf_io_posix(), path, &info, NULL), 0);
    assert_false(info.foreign_profile);
    torture(state, path, 5); /* most of it is the profile, which spoils no pixel */
    save_jpeg(path, &pixels, 80);
    add_profile(path, TTF_ICC_LINEAR);
    assert_int_equal(ttf_image_probe(ttf_io_posix(), path, &info, NULL), 0);
    assert_true(info.foreign_profile);
    ttf_pixbuf_free(&pixels);
}

static int deny_writes(void *ctx, const char *op, const char *path)
{
    return strcmp(op, "pwrite") == 0 ? -ENOSPC : 0;
}

static void a_full_disk_is_told_when_writing(void **state)
{
    struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), deny_writes, NULL);
    struct ttf_pixbuf pixels = make_picture(40, 30, 3, TTF_SAMPLE_U8, 5);
    int file = io->ops->open(io, in_folder(state, "full"), TTF_IO_CREATE_NEW);
    struct ttf_err err = {0};

    assert_true(file >= 0);
    assert_int_equal(ttf_png_write(io, file, &pixels, TTF_TRANSFER_SRGB, 6, NULL, &err), -ENOSPC);
    assert_int_equal(ttf_jpeg_write(io, file, &pixels, 80, &err), -ENOSPC);
    io->ops->close(io, file);
    ttf_io_faulty_destroy(io);
    ttf_pixbuf_free(&pixels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(png_of_every_depth_comes_back_to_the_bit),
        IN_FOLDER(jpeg_comes_back_nearly_and_says_its_size_without_decoding),
        IN_FOLDER(exif_says_when_and_which_side_is_up),
        IN_FOLDER(times_are_found_in_file_names),
        IN_FOLDER(eight_bit_pictures_become_light_and_come_back_to_the_bit),
        IN_FOLDER(what_is_no_picture_is_refused_with_its_path),
        IN_FOLDER(a_forged_size_is_refused_before_memory_is_asked_for),
        IN_FOLDER(broken_png_never_crashes),
        IN_FOLDER(broken_jpeg_never_crashes),
        IN_FOLDER(a_jpeg_for_print_is_refused_with_what_to_do),
        IN_FOLDER(a_jpeg_whose_scan_says_nothing_of_itself_is_whole),
        IN_FOLDER(a_jpeg_of_endless_scans_is_refused),
        IN_FOLDER(an_srgb_profile_is_known_and_another_is_told),
        IN_FOLDER(a_full_disk_is_told_when_writing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
