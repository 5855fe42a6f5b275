/* SPDX-License-Identifier: Apache-2.0 */
/*
 * bench_quilt: times and figures of quilting a folder of pictures, as JSON.
 *
 *   bench_quilt FOLDER [--size WxH] [--block WxH] [--seed N] [--threads N] [--from T]
 *               [--frames N] [--feather N] [--tolerance X] [--per-frame] [--png PREFIX T...]
 *
 * Nothing is written but the PNGs asked for. A measurement: it passes or fails nothing.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "ttf/dataset/image_file.h"
#include "ttf/hal/clock.h"
#include "ttf/synth/run.h"

#define PNGS_MAX 32

struct bench {
    const char *folder;
    struct ttf_quilt_config config;
    unsigned threads;
    uint32_t from, frames; /* frames 0: all */
    const char *png_prefix;
    uint32_t pngs[PNGS_MAX];
    unsigned n_pngs;
    uint16_t *codes; /* all input frames */
    uint32_t width, height, n;
};

static int64_t now(void *ctx)
{
    return ttf_clock_now_ns(ctx);
}

static int is_picture(const struct dirent *entry)
{
    const char *dot = strrchr(entry->d_name, '.');

    return dot && (strcmp(dot, ".png") == 0 || strcmp(dot, ".jpg") == 0);
}

static int load_one(struct bench *bench, const char *name, struct ttf_err *err)
{
    struct ttf_pixbuf pixels = {0};
    char path[4096];
    size_t samples;
    int r;

    snprintf(path, sizeof(path), "%s/%s", bench->folder, name);
    r = ttf_image_read_linear(ttf_io_posix(), path, &pixels, NULL, err);
    if (r < 0)
        return r;
    if (bench->n == 0) {
        bench->width = pixels.width;
        bench->height = pixels.height;
    }
    if (pixels.width != bench->width || pixels.height != bench->height) {
        ttf_pixbuf_free(&pixels);
        return ttf_err_set(err, -EINVAL, path, "not of the size of the first picture");
    }
    samples = (size_t)bench->width * bench->height * 3;
    bench->codes = realloc(bench->codes, (bench->n + 1) * samples * sizeof(uint16_t));
    if (!bench->codes)
        abort();
    for (uint32_t y = 0; y < bench->height; y++)
        memcpy(bench->codes + bench->n * samples + (size_t)y * bench->width * 3,
               ttf_pixbuf_row(&pixels, y), (size_t)bench->width * 3 * sizeof(uint16_t));
    ttf_pixbuf_free(&pixels);
    bench->n++;
    return 0;
}

static int load_folder(struct bench *bench, struct ttf_err *err)
{
    struct dirent **names = NULL;
    int n = scandir(bench->folder, &names, is_picture, alphasort);
    int r = n > 0 ? 0 : ttf_err_set(err, -ENOENT, bench->folder, "no pictures");

    for (int i = 0; i < n; i++) {
        if (r == 0 && i >= (int)bench->from && (bench->frames == 0 || bench->n < bench->frames))
            r = load_one(bench, names[i]->d_name, err);
        free(names[i]);
    }
    free(names);
    if (r == 0 && bench->n == 0)
        r = ttf_err_set(err, -EINVAL, bench->folder, "fewer than %u pictures", bench->from + 1);
    return r;
}

static int write_png(const struct bench *bench, uint32_t t, const uint16_t *codes,
                     struct ttf_err *err)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_pixbuf picture = {0};
    char path[4096];
    int file, r;

    r = ttf_pixbuf_alloc(&picture, bench->config.width, bench->config.height, 3, TTF_SAMPLE_U8);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory");
    for (uint32_t y = 0; y < picture.height; y++) {
        uint8_t *row = ttf_pixbuf_row(&picture, y);

        for (size_t i = 0; i < (size_t)picture.width * 3; i++)
            row[i] = ttf_linear16_to_srgb8(codes[(size_t)y * picture.width * 3 + i]);
    }
    snprintf(path, sizeof(path), "%s%03u.png", bench->png_prefix, t);
    remove(path);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    r = file < 0 ? ttf_err_set(err, file, path, "cannot be created")
                 : ttf_png_write(io, file, &picture, TTF_TRANSFER_SRGB, 1, NULL, err);
    if (file >= 0)
        io->ops->close(io, file);
    ttf_pixbuf_free(&picture);
    return r;
}

static int take_frame(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    const struct bench *bench = ctx;

    for (unsigned i = 0; i < bench->n_pngs; i++) {
        if (bench->pngs[i] == t)
            return write_png(bench, t, codes, err);
    }
    return 0;
}

/* WxH; what is no number is 0, which the synthesis refuses. */
static void parse_size(const char *text, uint32_t *ret_width, uint32_t *ret_height)
{
    char *end;

    *ret_width = (uint32_t)strtoul(text, &end, 10);
    *ret_height = *end == 'x' ? (uint32_t)strtoul(end + 1, NULL, 10) : 0;
}

static int parse(struct bench *bench, int argc, char **argv)
{
    struct ttf_quilt_config *config = &bench->config;

    if (argc < 2)
        return -EINVAL;
    bench->folder = argv[1];
    for (int i = 2; i < argc; i++) {
        const char *word = argv[i];
        const char *value = i + 1 < argc ? argv[i + 1] : "";

        if (strcmp(word, "--per-frame") == 0) {
            config->per_frame = true;
            continue;
        }
        i++;
        if (strcmp(word, "--size") == 0)
            parse_size(value, &config->width, &config->height);
        else if (strcmp(word, "--block") == 0)
            parse_size(value, &config->block_width, &config->block_height);
        else if (strcmp(word, "--seed") == 0)
            config->seed = strtoull(value, NULL, 10);
        else if (strcmp(word, "--threads") == 0)
            bench->threads = (unsigned)strtoul(value, NULL, 10);
        else if (strcmp(word, "--from") == 0)
            bench->from = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(word, "--frames") == 0)
            bench->frames = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(word, "--feather") == 0)
            config->feather_px = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(word, "--tolerance") == 0)
            config->tolerance = strtod(value, NULL);
        else if (strcmp(word, "--png") == 0) {
            bench->png_prefix = value;
            while (i + 1 < argc && argv[i + 1][0] != '-' && bench->n_pngs < PNGS_MAX)
                bench->pngs[bench->n_pngs++] = (uint32_t)strtoul(argv[++i], NULL, 10);
        } else
            return -EINVAL;
    }
    return 0;
}

static int run(struct bench *bench, struct ttf_quilt_report *ret, struct ttf_err *err)
{
    const struct ttf_quilt_sink sink = {.frame = take_frame, .ctx = bench};
    const struct ttf_encoding encoding = {0.0, 65535.0};
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_pool *pool = ttf_pool_create(bench->threads);
    struct ttf_sequence *input = NULL;
    int r = load_folder(bench, err);

    bench->config.now_ns = now;
    bench->config.now_ctx = clock;
    if (r == 0)
        r = ttf_sequence_of_memory(bench->codes, bench->width, bench->height, bench->n, &encoding,
                                   &input, err);
    if (r == 0)
        r = ttf_quilt_run(&bench->config, input, pool, &sink, ret, NULL, err);
    ttf_sequence_destroy(input);
    ttf_pool_destroy(pool);
    ttf_clock_destroy(clock);
    return r;
}

int main(int argc, char **argv)
{
    struct bench bench = {0};
    struct ttf_quilt_report report;
    struct ttf_err err = {0};
    struct ttf_json json;
    struct rusage usage;
    const char *text;
    char line[1024];
    size_t n;

    ttf_quilt_defaults(&bench.config);
    if (parse(&bench, argc, argv) < 0) {
        fprintf(stderr, "usage: bench_quilt FOLDER [--size WxH] [--block WxH] [--seed N] "
                        "[--threads N] [--from T] [--frames N] [--feather N] [--tolerance X] "
                        "[--per-frame] [--png PREFIX T...]\n");
        return 2;
    }
    if (run(&bench, &report, &err) < 0) {
        fprintf(stderr, "bench_quilt: %s\n", ttf_err_text(&err, line, sizeof(line)));
        free(bench.codes);
        return 1;
    }
    free(bench.codes);
    ttf_json_init(&json, true);
    ttf_quilt_report_json(&report, &json);
    if (ttf_json_finish(&json, &text, &n) == 0)
        fputs(text, stdout);
    ttf_json_free(&json);
    getrusage(RUSAGE_SELF, &usage);
    printf("peak resident with the whole input in memory: %ld kB\n", usage.ru_maxrss);
    return 0;
}
