/* SPDX-License-Identifier: Apache-2.0 */
/*
 * bench_patches: how like a picture other pictures look, patch by patch, as JSON.
 *
 *   bench_patches [--samples N] [--threads N] INPUT OUTPUT...
 *
 * Pictures are PNG, JPEG or TIFF. A measurement: it passes or fails nothing.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/image_file.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/hal/clock.h"
#include "ttf/synth/likeness.h"

struct picture {
    uint32_t width, height;
    uint8_t *rgb; /* display codes */
};

struct bench {
    unsigned samples, threads;
    char **paths; /* the input's, then those of the outputs */
    int n_paths;
};

static int load(const char *path, struct picture *ret, struct ttf_err *err)
{
    struct ttf_pixbuf pixels = {0};
    size_t row;
    int r = ttf_image_read_linear(ttf_io_posix(), path, &pixels, NULL, err);

    if (r < 0)
        return r;
    row = (size_t)pixels.width * 3;
    ret->width = pixels.width;
    ret->height = pixels.height;
    ret->rgb = malloc(row * pixels.height);
    if (ret->rgb) {
        for (uint32_t y = 0; y < pixels.height; y++) {
            const uint16_t *codes = ttf_pixbuf_row(&pixels, y);

            for (size_t i = 0; i < row; i++)
                ret->rgb[y * row + i] = ttf_linear16_to_srgb8(codes[i]);
        }
    } else {
        r = ttf_err_set(err, -ENOMEM, path, "no memory");
    }
    ttf_pixbuf_free(&pixels);
    return r;
}

static void write_figures(struct ttf_json *json, const char *path,
                          const struct ttf_patch_figures *figures, int64_t took_ns)
{
    ttf_json_object(json);
    ttf_json_kstring(json, "path", path);
    ttf_json_key(json, "sliced");
    ttf_json_array(json);
    for (int i = 0; i < 3; i++)
        ttf_json_double(json, figures->sliced[i]);
    ttf_json_array_end(json);
    ttf_json_kdouble(json, "to_input", figures->to_input);
    ttf_json_kdouble(json, "from_input", figures->from_input);
    ttf_json_kdouble(json, "seconds", (double)took_ns / 1e9);
    ttf_json_object_end(json);
}

static int compare(const struct bench *bench, const struct picture *input, const char *path,
                   struct ttf_pool *pool, struct ttf_clock *clock, struct ttf_json *json,
                   struct ttf_err *err)
{
    struct ttf_patch_figures figures;
    struct picture output = {0};
    int r = load(path, &output, err);

    if (r == 0) {
        int64_t begin = ttf_clock_now_ns(clock);

        r = ttf_patch_compare(input->rgb, input->width, input->height, output.rgb, output.width,
                              output.height, bench->samples, pool, &figures);
        if (r < 0)
            r = ttf_err_set(err, r, path, "cannot be compared: each side takes 28 pixels");
        else
            write_figures(json, path, &figures, ttf_clock_now_ns(clock) - begin);
    }
    free(output.rgb);
    return r;
}

static int run(const struct bench *bench, struct ttf_json *json, struct ttf_err *err)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_pool *pool = ttf_pool_create(bench->threads);
    struct picture input = {0};
    int r = load(bench->paths[0], &input, err);

    ttf_json_object(json);
    ttf_json_kstring(json, "input", bench->paths[0]);
    ttf_json_kint(json, "samples", bench->samples);
    ttf_json_key(json, "outputs");
    ttf_json_array(json);
    for (int i = 1; i < bench->n_paths && r == 0; i++)
        r = compare(bench, &input, bench->paths[i], pool, clock, json, err);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
    free(input.rgb);
    ttf_pool_destroy(pool);
    ttf_clock_destroy(clock);
    return r;
}

static int parse(struct bench *bench, int argc, char **argv)
{
    int i = 1;

    for (; i + 1 < argc && strncmp(argv[i], "--", 2) == 0; i += 2) {
        if (strcmp(argv[i], "--samples") == 0)
            bench->samples = (unsigned)strtoul(argv[i + 1], NULL, 10);
        else if (strcmp(argv[i], "--threads") == 0)
            bench->threads = (unsigned)strtoul(argv[i + 1], NULL, 10);
        else
            return -EINVAL;
    }
    bench->paths = argv + i;
    bench->n_paths = argc - i;
    return bench->n_paths >= 2 ? 0 : -EINVAL;
}

int main(int argc, char **argv)
{
    struct bench bench = {.samples = 2000};
    struct ttf_err err = {0};
    struct ttf_json json;
    const char *text;
    char line[1024];
    size_t n;
    int r;

    if (parse(&bench, argc, argv) < 0) {
        fprintf(stderr, "usage: bench_patches [--samples N] [--threads N] INPUT OUTPUT...\n");
        return 2;
    }
    ttf_json_init(&json, true);
    r = run(&bench, &json, &err);
    if (r < 0)
        fprintf(stderr, "bench_patches: %s\n", ttf_err_text(&err, line, sizeof(line)));
    else if (ttf_json_finish(&json, &text, &n) == 0)
        fputs(text, stdout);
    ttf_json_free(&json);
    return r < 0;
}
