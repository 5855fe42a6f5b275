/* SPDX-License-Identifier: Apache-2.0 */
/* What TIFF files of other programs and cameras say of time, made here with libtiff itself: read as far as it is a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <tiffio.h>

#include "scratch.h"
#include "ttf/dataset/tiff.h"

static struct ttf_tiff_info info_of_date(void **state, const char *date)
{
    const char *path = scratch_path(state, "date.tif");
    TIFF *tiff = TIFFOpen(path, "w");
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_tiff_info info;
    uint8_t pixel = 0;

    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 1);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_DATETIME, date);
    assert_int_equal(TIFFWriteEncodedStrip(tiff, 0, &pixel, 1), 1);
    TIFFClose(tiff);
    assert_int_equal(ttf_tiff_reader_open(ttf_io_posix(), path, &reader, NULL), 0);
    info = *ttf_tiff_reader_info(reader);
    ttf_tiff_reader_close(reader);
    return info;
}

static void dates_that_are_none_are_not_known(void **state)
{
    static const char *const none[] = {
        "2026:00:01 00:00:00", "2026:13:01 00:00:00", "2026:01:00 00:00:00",
        "2026:01:32 00:00:00", "2026:01:01 24:00:00", "2026:01:01 00:60:00",
        "2026:01:01 00:00:61", "0000:01:01 00:00:00", "2026:01:01 -1:00:00",
        "2026:01:01 00:-1:00", "2026:01:01 00:00:-1", "2026:-1:01 00:00:00",
        "2026:01:-1 00:00:00", "2026-01-01T00:00:00", "2026:01:01 00:00:0",
        "yesterday at noon..."};

    for (unsigned i = 0; i < sizeof(none) / sizeof(*none); i++)
        if (info_of_date(state, none[i]).times.start_utc_ns != TTF_NS_UNKNOWN)
            fail_msg("%s", none[i]);
    assert_true(info_of_date(state, "1970:01:02 00:00:03").times.start_utc_ns ==
                TTF_NS_PER_DAY + 3 * TTF_NS_PER_S);
    assert_true(info_of_date(state, "1968:02:29 00:00:00").times.start_utc_ns ==
                -672 * TTF_NS_PER_DAY);
    assert_false(info_of_date(state, "1970:01:02 00:00:03").zone_known);
}

/* As cameras write it; NULL: left out. */
struct exif {
    const char *date, *fraction, *offset, *other_offset;
    double exposure_s;
    const char *file_date; /* DateTime, beside the folder */
};

static struct ttf_tiff_info info_of_exif(void **state, const struct exif *exif)
{
    const char *path = scratch_path(state, "exif.tif");
    TIFF *tiff = TIFFOpen(path, "w");
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_tiff_info info;
    uint64_t at = 0;
    uint8_t pixel = 0;

    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 1);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    assert_int_equal(TIFFWriteEncodedStrip(tiff, 0, &pixel, 1), 1);
    assert_int_equal(TIFFWriteDirectory(tiff), 1);
    assert_int_equal(TIFFCreateEXIFDirectory(tiff), 0);
    if (exif->date)
        TIFFSetField(tiff, EXIFTAG_DATETIMEORIGINAL, exif->date);
    if (exif->fraction)
        TIFFSetField(tiff, EXIFTAG_SUBSECTIMEORIGINAL, exif->fraction);
    if (exif->offset)
        TIFFSetField(tiff, EXIFTAG_OFFSETTIMEORIGINAL, exif->offset);
    if (exif->other_offset)
        TIFFSetField(tiff, EXIFTAG_OFFSETTIME, exif->other_offset);
    TIFFSetField(tiff, EXIFTAG_EXPOSURETIME, exif->exposure_s);
    assert_int_equal(TIFFWriteCustomDirectory(tiff, &at), 1);
    assert_int_equal(TIFFSetDirectory(tiff, 0), 1);
    TIFFSetField(tiff, TIFFTAG_EXIFIFD, at);
    if (exif->file_date)
        TIFFSetField(tiff, TIFFTAG_DATETIME, exif->file_date);
    assert_int_equal(TIFFRewriteDirectory(tiff), 1);
    TIFFClose(tiff);
    assert_int_equal(ttf_tiff_reader_open(ttf_io_posix(), path, &reader, NULL), 0);
    info = *ttf_tiff_reader_info(reader);
    ttf_tiff_reader_close(reader);
    return info;
}

#define DAY_2 "1970:01:02 00:00:00"

static void what_a_camera_says_of_time_is_read_as_far_as_it_is_a_time(void **state)
{
    static const struct {
        struct exif exif;
        int64_t start_ns;
        int zone_s;
        bool zone_known;
        int64_t exposure_ns;
    } cases[] = {
        {{DAY_2, "25", "+01:30", NULL, 0.5, NULL},
         TTF_NS_PER_DAY - 5400 * TTF_NS_PER_S + 250000000,
         5400,
         true,
         500000000},
        {{DAY_2, NULL, NULL, "-02:00", 0, NULL},
         TTF_NS_PER_DAY + 7200 * TTF_NS_PER_S,
         -7200,
         true,
         0},
        {{DAY_2, "1234567890123", NULL, NULL, 2e6, NULL}, TTF_NS_PER_DAY + 123456789, 0, false, 0},
        {{DAY_2, "1:9", "+24:00", NULL, 0, NULL}, TTF_NS_PER_DAY + 100000000, 0, false, 0},
        {{DAY_2, NULL, "+10:60", NULL, 0, NULL}, TTF_NS_PER_DAY, 0, false, 0},
        {{DAY_2, NULL, "+-1:00", NULL, 0, NULL}, TTF_NS_PER_DAY, 0, false, 0},
        {{DAY_2, NULL, "+01:-1", NULL, 0, NULL}, TTF_NS_PER_DAY, 0, false, 0},
        {{DAY_2, NULL, "noon", NULL, 0, NULL}, TTF_NS_PER_DAY, 0, false, 0},
        {{"no date, no time...", "25", "+01:30", NULL, 0, NULL}, TTF_NS_UNKNOWN, 0, false, 0},
        {{NULL, "25", "+01:30", NULL, 1, NULL}, TTF_NS_UNKNOWN, 0, false, 1000000000},
        /* The zone is DateTime's, too, whose own fraction nobody writes. */
        {{NULL, NULL, NULL, "+02:00", 0, DAY_2},
         TTF_NS_PER_DAY - 7200 * TTF_NS_PER_S,
         7200,
         true,
         0},
        {{"    :  :     :  :  ", "25", "   :  ", "-01:00", 0, DAY_2},
         TTF_NS_PER_DAY + 3600 * TTF_NS_PER_S,
         -3600,
         true,
         0},
        {{"9999:12:31 23:59:59", NULL, NULL, NULL, 0, NULL}, TTF_NS_UNKNOWN, 0, false, 0},
    };

    for (unsigned i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        struct ttf_tiff_info info = info_of_exif(state, &cases[i].exif);

        if (info.times.start_utc_ns != cases[i].start_ns ||
            info.times.zone_offset_s != cases[i].zone_s || info.zone_known != cases[i].zone_known ||
            info.times.exposure_ns != cases[i].exposure_ns)
            fail_msg("case %u: %lld ns, zone %d s (%d), exposed %lld ns", i,
                     (long long)info.times.start_utc_ns, info.times.zone_offset_s, info.zone_known,
                     (long long)info.times.exposure_ns);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(dates_that_are_none_are_not_known, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(what_a_camera_says_of_time_is_read_as_far_as_it_is_a_time,
                                        scratch_make, scratch_remove),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
