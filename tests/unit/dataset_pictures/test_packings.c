/* SPDX-License-Identifier: Apache-2.0 */
/* However a camera packs its samples, the light that is summed is the same. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/calibration.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/develop.h"

#define W 7 /* ends within a group of four and a pair */
#define H 5

static uint32_t code(unsigned i, unsigned bits)
{
    return (i * 2654435761u >> 11) & ((1u << bits) - 1);
}

static struct ttf_frame_format format_of(enum ttf_packing packing, unsigned bits, size_t stride)
{
    return (struct ttf_frame_format){.width = W,
                                     .height = H,
                                     .stride = stride,
                                     .packing = packing,
                                     .cfa = TTF_CFA_GRBG,
                                     .bits = (uint8_t)bits,
                                     .black_level = 3,
                                     .white_level = (uint16_t)((1u << bits) - 1)};
}

/* Adds the same frame twice; each sum must be twice its code. */
static void sums_are_twice(const struct ttf_frame_format *format, const void *data, size_t bytes)
{
    struct ttf_frame frame = {.format = *format, .data = data, .bytes = bytes};
    struct ttf_raw_sum sum;

    assert_int_equal(ttf_raw_sum_init(&sum, format), 0);
    assert_int_equal(sum.samples, 1);
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), 0);
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), 0);
    for (unsigned i = 0; i < W * H; i++)
        assert_int_equal(sum.sum[i], 2 * code(i, format->bits));
    frame.bytes--;
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), -EINVAL);
    ttf_raw_sum_free(&sum);
}

static void bytes_are_linear_codes(void **state)
{
    uint8_t data[H][W + 2];
    struct ttf_frame_format format = format_of(TTF_PACKING_RAW8, 8, sizeof(data[0]));

    (void)state;
    for (unsigned i = 0; i < W * H; i++)
        data[i / W][i % W] = (uint8_t)code(i, 8);
    sums_are_twice(&format, data, sizeof(data) - 2);
}

static void ten_bits_are_unpacked_four_from_five_bytes(void **state)
{
    uint8_t data[H][12] = {{0}};
    struct ttf_frame_format format = format_of(TTF_PACKING_RAW10P, 10, sizeof(data[0]));

    (void)state;
    for (unsigned i = 0; i < W * H; i++) {
        uint8_t *group = data[i / W] + i % W / 4 * 5;

        group[i % W % 4] = (uint8_t)(code(i, 10) >> 2);
        group[4] |= (uint8_t)((code(i, 10) & 3) << 2 * (i % W % 4));
    }
    sums_are_twice(&format, data, sizeof(data) - 2);
}

static void twelve_bits_are_unpacked_two_from_three_bytes(void **state)
{
    uint8_t data[H][13] = {{0}};
    struct ttf_frame_format format = format_of(TTF_PACKING_RAW12P, 12, sizeof(data[0]));

    (void)state;
    for (unsigned i = 0; i < W * H; i++) {
        uint8_t *group = data[i / W] + i % W / 2 * 3;

        group[i % W % 2] = (uint8_t)(code(i, 12) >> 4);
        group[2] |= (uint8_t)((code(i, 12) & 15) << 4 * (i % W % 2));
    }
    sums_are_twice(&format, data, sizeof(data) - 1);
}

static void a_packed_mosaic_develops_to_the_bits_of_an_unpacked_one(void **state)
{
    static const struct ttf_encoding encoding = {TTF_PEDESTAL, TTF_SCALE};
    uint8_t packed[H][12] = {{0}};
    uint16_t words[H][W];
    struct ttf_pixbuf out[2];

    (void)state;
    for (unsigned i = 0; i < W * H; i++) {
        uint8_t *group = packed[i / W] + i % W / 2 * 3;

        group[i % W % 2] = (uint8_t)(code(i, 12) >> 4);
        group[2] |= (uint8_t)((code(i, 12) & 15) << 4 * (i % W % 2));
        words[i / W][i % W] = (uint16_t)code(i, 12);
    }
    for (unsigned k = 0; k < 2; k++) {
        struct ttf_frame_format format = k ? format_of(TTF_PACKING_RAW12P, 12, sizeof(packed[0]))
                                           : format_of(TTF_PACKING_RAW16, 12, sizeof(words[0]));
        struct ttf_frame frame = {.format = format,
                                  .data = k ? (const void *)packed : (const void *)words,
                                  .bytes = k ? sizeof(packed) : sizeof(words)};
        struct ttf_develop_config config = {.format = format, .encoding = encoding};
        struct ttf_develop *develop = NULL;
        struct ttf_raw_sum sum;

        assert_int_equal(ttf_raw_sum_init(&sum, &format), 0);
        assert_int_equal(ttf_raw_sum_add(&sum, &frame), 0);
        assert_int_equal(ttf_develop_create(&config, &develop, NULL), 0);
        assert_int_equal(ttf_pixbuf_alloc(&out[k], W, H, 3, TTF_SAMPLE_U16), 0);
        assert_int_equal(ttf_develop_run(develop, &sum, NULL, &out[k], NULL, NULL), 0);
        ttf_develop_destroy(develop);
        ttf_raw_sum_free(&sum);
    }
    assert_memory_equal(out[0].data, out[1].data, (size_t)W * H * 3 * 2);
    ttf_pixbuf_free(&out[0]);
    ttf_pixbuf_free(&out[1]);
}

/* The same picture as YUYV and NV12; colours are shared by pairs of a row, and here by pairs of rows. */
static void nv12_and_yuyv_of_a_picture_are_the_same_light(void **state)
{
    uint8_t yuyv[H][(W + 1) * 2] = {{0}}, nv12[H + (H + 1) / 2][W + 3] = {{0}};
    struct ttf_frame frames[2];
    struct ttf_raw_sum sums[2];

    (void)state;
    for (unsigned y = 0; y < H; y++) {
        for (unsigned x = 0; x < W + 1; x++) {
            uint8_t luma = (uint8_t)(16 + code(y * 16 + x, 7));
            uint8_t colour = (uint8_t)(64 + code(y / 2 * 64 + x, 7));

            yuyv[y][2 * x] = nv12[y][x] = luma;
            yuyv[y][2 * x + 1] = nv12[H + y / 2][x] = colour; /* Cb, then Cr */
        }
    }
    frames[0] = (struct ttf_frame){.format = format_of(TTF_PACKING_YUYV8, 8, sizeof(yuyv[0])),
                                   .data = yuyv,
                                   .bytes = sizeof(yuyv)};
    frames[1] = (struct ttf_frame){.format = format_of(TTF_PACKING_NV12, 8, sizeof(nv12[0])),
                                   .data = nv12,
                                   .bytes = sizeof(nv12)};
    for (unsigned k = 0; k < 2; k++) {
        assert_int_equal(ttf_raw_sum_init(&sums[k], &frames[k].format), 0);
        assert_int_equal(sums[k].samples, 3);
        assert_int_equal(ttf_raw_sum_add(&sums[k], &frames[k]), 0);
    }
    assert_memory_equal(sums[0].sum, sums[1].sum, (size_t)W * H * 3 * sizeof(uint32_t));
    /* All of the second plane must be there. */
    frames[1].bytes = (size_t)H * sizeof(nv12[0]);
    assert_int_equal(ttf_raw_sum_add(&sums[1], &frames[1]), -EINVAL);
    ttf_raw_sum_free(&sums[0]);
    ttf_raw_sum_free(&sums[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_linear_codes),
        cmocka_unit_test(ten_bits_are_unpacked_four_from_five_bytes),
        cmocka_unit_test(twelve_bits_are_unpacked_two_from_three_bytes),
        cmocka_unit_test(a_packed_mosaic_develops_to_the_bits_of_an_unpacked_one),
        cmocka_unit_test(nv12_and_yuyv_of_a_picture_are_the_same_light),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
