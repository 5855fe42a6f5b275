/* SPDX-License-Identifier: Apache-2.0 */
/*
 * calibration.json, beside pictures of 4 x 3 pixels that belong to none and to all: what is
 * accepted can be saved, and loaded again as the same.
 */
#include <stdlib.h>
#include <string.h>

#include "disk.h"
#include "fuzz.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/tiff.h"

#define WIDTH  4u
#define HEIGHT 3u

static void put_picture(struct fuzz_disk *disk, const char *path, enum ttf_sample format)
{
    const struct ttf_tiff_spec spec = {.samples = 1};
    struct ttf_pixbuf pixels;
    struct ttf_err err = {0};
    int file = disk->base.ops->open(&disk->base, path, TTF_IO_CREATE_NEW);

    if (file < 0 || ttf_pixbuf_alloc(&pixels, WIDTH, HEIGHT, 1, format) < 0)
        abort();
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            if (format == TTF_SAMPLE_F32)
                ((float *)ttf_pixbuf_row(&pixels, y))[x] = 0.25f * (float)x - (float)y;
            else
                ((uint16_t *)ttf_pixbuf_row(&pixels, y))[x] = (uint16_t)(16384 + 100 * x + y);
        }
    if (ttf_tiff_write(&disk->base, file, &pixels, &spec, &err) < 0)
        abort();
    disk->base.ops->close(&disk->base, file);
    ttf_pixbuf_free(&pixels);
}

/* The same file in both folders. */
static bool same(const struct fuzz_disk *disk, const char *a, const char *b)
{
    size_t n, m;
    const uint8_t *x = fuzz_disk_get(disk, a, &n), *y = fuzz_disk_get(disk, b, &m);

    return x && y && n == m && memcmp(x, y, n) == 0;
}

static void again(struct fuzz_disk *disk, const struct ttf_calibration *first)
{
    struct ttf_calibration second;
    struct ttf_err err = {0};

    if (ttf_calibration_save(first, &disk->base, "once", &err) < 0 ||
        ttf_calibration_load(&disk->base, "once", &second, &err) < 0 ||
        ttf_calibration_save(&second, &disk->base, "twice", &err) < 0)
        abort();
    if (!same(disk, "once/calibration.json", "twice/calibration.json") ||
        (first->has_dark && !same(disk, "once/dark.tif", "twice/dark.tif")) ||
        (first->has_flat && !same(disk, "once/flat.tif", "twice/flat.tif")))
        abort();
    ttf_calibration_free(&second);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_calibration calibration;
    struct ttf_err err = {0};
    struct fuzz_disk disk;

    fuzz_disk_init(&disk);
    fuzz_disk_put(&disk, "c/calibration.json", data, size);
    put_picture(&disk, "c/dark.tif", TTF_SAMPLE_F32);
    put_picture(&disk, "c/flat.tif", TTF_SAMPLE_U16);
    if (ttf_calibration_load(&disk.base, "c", &calibration, &err) == 0) {
        again(&disk, &calibration);
        ttf_calibration_free(&calibration);
    }
    if (fuzz_disk_open_handles(&disk) > 0)
        abort();
    fuzz_disk_free(&disk);
    return 0;
}
