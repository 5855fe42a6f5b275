/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/calibration.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/hash.h"

static const char *const PARTS[] = {"dark", "flat", "chart", "geometry", "flicker"};

const char *ttf_calibration_part_name(enum ttf_calibration_part part)
{
    return PARTS[part];
}

int ttf_calibration_part_find(const char *name)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(PARTS); i++)
        if (strcmp(PARTS[i], name) == 0)
            return (int)i;
    return -ENOENT;
}

bool ttf_calibration_has(const struct ttf_calibration *calibration, enum ttf_calibration_part part)
{
    switch (part) {
    case TTF_CALIBRATION_DARK:
        return calibration->has_dark;
    case TTF_CALIBRATION_FLAT:
        return calibration->has_flat;
    case TTF_CALIBRATION_CHART:
        return calibration->has_chart;
    case TTF_CALIBRATION_GEOMETRY:
        return calibration->has_geometry;
    case TTF_CALIBRATION_FLICKER:
        break;
    }
    return calibration->has_flicker;
}

static int refuse_order(enum ttf_calibration_part part, const char *why, const char *hint,
                        struct ttf_err *err)
{
    ttf_err_set(err, -EINVAL, PARTS[part], "%s", why);
    ttf_err_hint(err, "%s", hint);
    return -EINVAL;
}

int ttf_calibration_may_take(const struct ttf_calibration *calibration,
                             enum ttf_calibration_part part, struct ttf_err *err)
{
    if (part == TTF_CALIBRATION_DARK && calibration->has_flat)
        return refuse_order(part, "the calibration has a flat, whose gains were made without it",
                            "begin a new calibration: the dark first, then the flat", err);
    if (part == TTF_CALIBRATION_CHART && !calibration->has_flat)
        return refuse_order(part, "the calibration has no flat yet",
                            "a chart is measured after a flat, under the same lamps", err);
    if ((part == TTF_CALIBRATION_GEOMETRY || part == TTF_CALIBRATION_FLICKER) &&
        !calibration->has_dark && !calibration->has_flat)
        return refuse_order(part, "the calibration has neither dark nor flat yet",
                            "it is kept with these: make one of them first", err);
    return 0;
}

void ttf_calibration_init(struct ttf_calibration *calibration)
{
    memset(calibration, 0, sizeof(*calibration));
    calibration->dark_temp_mdegc = INT32_MIN;
    for (int i = 0; i < 9; i += 4)
        calibration->colour_matrix[i] = 1.0;
}

void ttf_calibration_free(struct ttf_calibration *calibration)
{
    if (!calibration)
        return;
    free(calibration->dark_offset_16);
    free(calibration->hot);
    free(calibration->flat_gain);
    memset(calibration, 0, sizeof(*calibration));
}

/* Numbers go into the hash as little-endian bytes, whatever the machine. */
static void hash_u64(struct ttf_sha256 *hash, uint64_t value)
{
    uint8_t bytes[8];

    for (int i = 0; i < 8; i++)
        bytes[i] = (uint8_t)(value >> 8 * i);
    ttf_sha256_add(hash, bytes, sizeof(bytes));
}

static void hash_double(struct ttf_sha256 *hash, double value)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof(bits));
    hash_u64(hash, bits);
}

static void hash_settings(struct ttf_sha256 *hash, const struct ttf_exposure *settings)
{
    hash_u64(hash, (uint64_t)settings->exposure_ns);
    hash_u64(hash, settings->gain_milli);
    hash_u64(hash, settings->wb_r_milli);
    hash_u64(hash, settings->wb_b_milli);
    hash_u64(hash, settings->lens_mdpt);
}

static void hash_words(struct ttf_sha256 *hash, const void *words, size_t n, size_t bytes_each)
{
    uint8_t block[4096];
    size_t used = 0;

    for (size_t i = 0; i < n; i++) {
        uint32_t word =
            bytes_each == 2 ? ((const uint16_t *)words)[i] : ((const uint32_t *)words)[i];

        for (size_t k = 0; k < bytes_each; k++)
            block[used++] = (uint8_t)(word >> 8 * k);
        if (used + 4 > sizeof(block)) {
            ttf_sha256_add(hash, block, used);
            used = 0;
        }
    }
    ttf_sha256_add(hash, block, used);
}

void calibration_id(const struct ttf_calibration *calibration, char ret[64])
{
    size_t n = (size_t)calibration->width * calibration->height;
    struct ttf_sha256 hash;
    char hex[65];

    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, calibration->camera, strlen(calibration->camera) + 1);
    hash_u64(&hash, calibration->simulated);
    hash_u64(&hash, calibration->width);
    hash_u64(&hash, calibration->height);
    hash_u64(&hash, (uint64_t)calibration->cfa);
    hash_u64(&hash, calibration->black_level);
    hash_u64(&hash, calibration->white_level);
    hash_u64(&hash, calibration->has_dark);
    if (calibration->has_dark) {
        hash_settings(&hash, &calibration->dark_settings);
        hash_words(&hash, calibration->dark_offset_16, n, 4);
    }
    hash_u64(&hash, calibration->n_hot);
    for (unsigned i = 0; i < calibration->n_hot; i++)
        hash_u64(&hash, (uint64_t)calibration->hot[i].y << 16 | calibration->hot[i].x);
    hash_u64(&hash, calibration->has_flat);
    if (calibration->has_flat) {
        hash_settings(&hash, &calibration->flat_settings);
        hash_double(&hash, calibration->flat_reflectance);
        hash_double(&hash, calibration->flat_level);
        hash_words(&hash, calibration->flat_gain, n, 2);
    }
    for (int i = 0; i < 9; i++)
        hash_double(&hash, calibration->colour_matrix[i]);
    ttf_sha256_hex(&hash, hex);
    snprintf(ret, 64, "%s%.16s", CALIBRATION_ID_PREFIX, hex);
}

int ttf_calibration_name(struct ttf_calibration *calibration, struct ttf_err *err)
{
    if (!calibration->has_dark && !calibration->has_flat)
        return ttf_err_set(err, -EINVAL, NULL,
                           "the calibration holds neither dark nor flat frames");
    calibration_id(calibration, calibration->id);
    return 0;
}
