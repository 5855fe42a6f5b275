/* SPDX-License-Identifier: Apache-2.0 */
#include "more_works.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "format_works.h"
#include "ttf/base/time.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/flicker.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/thumbnail.h"
#include "ttf/dataset/tiff.h"
#include "ttf/dataset/writer.h"

#define SIDE 24 /* of the pictures of format_works */

/* A grid of dots, 16 pixels apart. */
#define GRID_W 192
#define GRID_H 144
#define PITCH  16

static struct ttf_raw_sum grid;

/* ---- pictures ---- */

static int show(const char *name, enum ttf_sample format, double scale, struct ttf_err *err)
{
    const struct ttf_stream stream = {.samples = 3, .format = format, .encoding = {.scale = scale}};
    const struct ttf_thumbnail_size size = {.side = 8};
    void *jpeg = NULL;
    size_t bytes = 0;
    int r = ttf_thumbnail_of_file(format_io(), format_in(name), &stream, &size, &jpeg, &bytes, err);

    if (r)
        return r;
    assert_true(bytes > 100);
    assert_memory_equal(jpeg, "\xff\xd8", 2);
    free(jpeg);
    return 0;
}

int more_show_small(struct ttf_err *err)
{
    int r = show("picture.tif", TTF_SAMPLE_U16, 65535, err);

    r = r ? r : show("floats.tif", TTF_SAMPLE_F32, 2, err);
    return r ? r : show("raw.dng", TTF_SAMPLE_U16, 65535, err);
}

int more_read_float_dataset(struct ttf_err *err)
{
    float values[SIDE * SIDE * 3] = {0};
    uint16_t rows[SIDE * SIDE * 3];
    struct ttf_sequence *s = NULL;
    struct ttf_reader *reader = NULL;
    int r = ttf_reader_open(format_io(), format_in("floats"), &reader, err);

    r = r ? r : ttf_sequence_of_dataset(reader, NULL, &s, err);
    r = r ? r : ttf_sequence_read_rows(s, 0, 0, SIDE, rows, err);
    r = r ? r : ttf_sequence_read_values(s, 0, 0, SIDE, values, err);
    if (r == 0) {
        assert_int_equal(rows[0], 0);
        assert_int_equal(rows[SIDE * SIDE * 3 - 1], 65535);
        for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
            assert_true(values[i] == (float)i / 1000);
    }
    ttf_sequence_destroy(s);
    ttf_reader_close(reader);
    return r;
}

int more_import_by_time(struct ttf_err *err)
{
    char later[100], first[100], out[100];
    const char *const inputs[] = {later, first};
    struct ttf_import_config config = {
        .inputs = inputs, .n_inputs = 2, .output = out, .order = TTF_IMPORT_NAME_TIME};
    struct ttf_import_result result;

    snprintf(later, sizeof(later), "%s", format_in("20260101_000100.png"));
    snprintf(first, sizeof(first), "%s", format_in("20260101_000000.png"));
    snprintf(out, sizeof(out), "%s", format_in("out"));
    return ttf_import(format_io(), &config, &result, err);
}

int more_note(struct ttf_err *err)
{
    static const struct ttf_note note = {.utc_ns = 1, .text = "a fly"};

    return ttf_note_append(format_io(), format_in("floats"), &note, err);
}

int more_sample(struct ttf_err *err)
{
    static const struct ttf_sample_rect corner = {.width = 4, .height = 4};
    static const struct ttf_sample_change change = {.id = "A2", .region = &corner};

    return ttf_samples_change(format_io(), format_in("floats"), &change, 1, err);
}

/* ---- measured on frames ---- */

int more_measure_grid(struct ttf_err *err)
{
    struct ttf_calibration c;
    int r;

    ttf_calibration_init(&c);
    r = ttf_calibration_fit_geometry(&c, &grid, 5, err);
    if (r == 0)
        assert_true(c.geometry.mm_per_px > 4.9 / PITCH && c.geometry.mm_per_px < 5.1 / PITCH);
    ttf_calibration_free(&c);
    return r;
}

int more_measure_flicker(struct ttf_err *err)
{
    struct ttf_flicker_frames frames;
    struct ttf_flicker flicker;
    int r = ttf_flicker_init(&frames, &grid.format, TTF_FLICKER_FRAMES_LEAST, err);

    if (r)
        return r;
    for (int i = 0; i < TTF_FLICKER_FRAMES_LEAST; i++)
        assert_int_equal(ttf_flicker_add(&frames, &grid, i * TTF_NS_PER_S), 0);
    r = ttf_flicker_measure(&frames, &flicker, err);
    if (r == 0)
        assert_true(flicker.frame_rms < 1e-9);
    ttf_flicker_free(&frames);
    return r;
}

/* ---- */

void more_works_begin(void)
{
    const struct ttf_frame_format format = {.width = GRID_W,
                                            .height = GRID_H,
                                            .packing = TTF_PACKING_RAW16,
                                            .stride = 2 * GRID_W,
                                            .cfa = TTF_CFA_NONE,
                                            .bits = 12,
                                            .black_level = 64,
                                            .white_level = 4095};

    assert_int_equal(ttf_raw_sum_init(&grid, &format), 0);
    for (int y = 0; y < GRID_H; y++)
        for (int x = 0; x < GRID_W; x++) {
            int dx = x % PITCH - PITCH / 2, dy = y % PITCH - PITCH / 2;

            grid.sum[y * GRID_W + x] = dx * dx + dy * dy < 16 ? 300 : 3000;
        }
    grid.n = 1;
    grid.settings = (struct ttf_exposure){.exposure_ns = 20 * TTF_NS_PER_MS, .gain_milli = 1000};
}

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct ttf_tiff_spec spec = {.times = {.start_utc_ns = TTF_NS_UNKNOWN}};

    return ttf_tiff_write(io, file, ctx, &spec, err);
}

/* A dataset of one slot, its image of floats. */
static void make_float_dataset(void)
{
    const struct ttf_segment segment = {.origin_utc_ns = TTF_NS_UNKNOWN,
                                        .trust = "none",
                                        .uncertainty_ns = TTF_NS_UNKNOWN,
                                        .interval_ns = TTF_NS_PER_S,
                                        .plan = -1,
                                        .zone = "UTC"};
    struct ttf_stream stream = {.id = "main",
                                .quantity = "radiance",
                                .unit = "1",
                                .colour_space = "linear-srgb",
                                .width = SIDE,
                                .height = SIDE,
                                .samples = 3,
                                .format = TTF_SAMPLE_F32,
                                .encoding = {.scale = 1}};
    struct ttf_writer *writer = NULL;
    struct ttf_manifest manifest;
    struct ttf_slot_record record;
    struct ttf_pixbuf floats = {0};
    struct ttf_image *image;

    assert_int_equal(ttf_image_read(format_io(), format_in("floats.tif"), 0, &floats, NULL, NULL),
                     0);
    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    manifest.streams[manifest.n_streams++] = stream;
    assert_int_equal(
        ttf_writer_create(format_io(), format_in("floats"), &manifest, NULL, NULL, &writer, NULL),
        0);
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    ttf_slot_record_init(&record);
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    image = &record.images[0];
    snprintf(image->stream, sizeof(image->stream), "main");
    image->n_averaged = 1;
    image->n_files = 1;
    assert_int_equal(ttf_writer_file(writer, "developed", "main", 0, -1, "tif", produce, &floats,
                                     &image->files[0], NULL),
                     0);
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
    ttf_writer_close(writer);
    ttf_pixbuf_free(&floats);
}

void more_works_files(void)
{
    static const struct ttf_sample_rect corner = {.width = 2, .height = 2};
    static const struct ttf_sample_change change = {.id = "A1", .region = &corner};

    format_keep("20260101_000000.png", format_write_png);
    format_keep("20260101_000100.png", format_write_png);
    make_float_dataset();
    assert_int_equal(ttf_samples_change(format_io(), format_in("floats"), &change, 1, NULL), 0);
}

void more_works_end(void)
{
    ttf_raw_sum_free(&grid);
}
