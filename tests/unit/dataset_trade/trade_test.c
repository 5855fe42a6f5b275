/* SPDX-License-Identifier: Apache-2.0 */
#include "trade_test.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

int folder_setup(void **state)
{
    struct folder *folder = calloc(1, sizeof(*folder));

    snprintf(folder->path, sizeof(folder->path), "/tmp/ttf-trade-XXXXXX");
    if (!mkdtemp(folder->path))
        return -1;
    *state = folder;
    return 0;
}

static int remove_one(const char *path, const struct stat *st, int type, struct FTW *ftw)
{
    return remove(path);
}

static void remove_tree(const char *path)
{
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): tests of one thread */
    nftw(path, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

int folder_teardown(void **state)
{
    struct folder *folder = *state;

    remove_tree(folder->path);
    while (folder->texts) {
        struct folder_text *text = folder->texts;

        folder->texts = text->next;
        free(text);
    }
    free(folder);
    return 0;
}

const char *in_folder(void **state, const char *fmt, ...)
{
    struct folder *folder = *state;
    struct folder_text *text = malloc(sizeof(*text));
    va_list args;
    int n;

    assert_non_null(text);
    n = snprintf(text->text, sizeof(text->text), "%s/", folder->path);
    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    vsnprintf(text->text + n, sizeof(text->text) - (size_t)n, fmt, args);
    va_end(args);
    text->next = folder->texts;
    folder->texts = text;
    return text->text;
}

bool exists(const char *path)
{
    struct stat st;

    return lstat(path, &st) == 0;
}

static int count_one(void *ctx, const char *name, bool is_dir)
{
    *(int *)ctx += strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
    return 0;
}

int count_entries(const char *path)
{
    struct ttf_io *io = ttf_io_posix();
    int n = 0;

    return io->ops->list(io, path, count_one, &n) < 0 ? -1 : n;
}

uint8_t *slurp(const char *path, size_t *ret_bytes)
{
    char *text = NULL;

    assert_int_equal(ttf_io_slurp(ttf_io_posix(), path, (size_t)1 << 30, &text, ret_bytes, NULL),
                     0);
    return (uint8_t *)text;
}

void write_bytes(const char *path, const void *data, size_t n)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, n, file), n);
    fclose(file);
}

bool same_files(const char *a, const char *b)
{
    size_t na, nb;
    uint8_t *x = slurp(a, &na), *y = slurp(b, &nb);
    bool same = na == nb && memcmp(x, y, na) == 0;

    free(x);
    free(y);
    return same;
}

static unsigned hash(unsigned x)
{
    x = (x ^ 61u) ^ (x >> 16);
    x *= 9u;
    x ^= x >> 4;
    x *= 0x27d4eb2du;
    return x ^ (x >> 15);
}

struct ttf_pixbuf make_picture(uint32_t width, uint32_t height, uint32_t samples,
                               enum ttf_sample format, unsigned seed)
{
    struct ttf_pixbuf pixels;

    assert_int_equal(ttf_pixbuf_alloc(&pixels, width, height, samples, format), 0);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t i = 0; i < width * samples; i++) {
            unsigned code = hash(seed * 7919u + y * width * samples + i);

            if (format == TTF_SAMPLE_U8)
                ((uint8_t *)ttf_pixbuf_row(&pixels, y))[i] = (uint8_t)code;
            else if (format == TTF_SAMPLE_U16)
                ((uint16_t *)ttf_pixbuf_row(&pixels, y))[i] = (uint16_t)code;
            else
                ((float *)ttf_pixbuf_row(&pixels, y))[i] = (float)(code % 1000) / 100.0f - 2.0f;
        }
    }
    return pixels;
}

static int create(const char *path)
{
    struct ttf_io *io = ttf_io_posix();
    int file;

    remove(path);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    assert_true(file >= 0);
    return file;
}

void save_png(const char *path, const struct ttf_pixbuf *pixels)
{
    struct ttf_io *io = ttf_io_posix();
    int file = create(path);

    assert_int_equal(ttf_png_write(io, file, pixels, TTF_TRANSFER_SRGB, 1, NULL, NULL), 0);
    io->ops->close(io, file);
}

void save_jpeg(const char *path, const struct ttf_pixbuf *pixels, int quality)
{
    struct ttf_io *io = ttf_io_posix();
    int file = create(path);

    assert_int_equal(ttf_jpeg_write(io, file, pixels, quality, NULL), 0);
    io->ops->close(io, file);
}

bool same_pixels(const struct ttf_pixbuf *a, const struct ttf_pixbuf *b)
{
    if (a->width != b->width || a->height != b->height || a->samples != b->samples ||
        a->format != b->format)
        return false;
    for (uint32_t y = 0; y < a->height; y++) {
        if (memcmp(ttf_pixbuf_row(a, y), ttf_pixbuf_row(b, y),
                   (size_t)a->width * a->samples * ttf_sample_bytes(a->format)) != 0)
            return false;
    }
    return true;
}

void picture_file(const char *path, uint32_t width, uint32_t height, unsigned seed)
{
    struct ttf_pixbuf pixels = make_picture(width, height, 3, TTF_SAMPLE_U8, seed);

    save_png(path, &pixels);
    ttf_pixbuf_free(&pixels);
}

int run_program(const char *const argv[], char *ret, size_t size)
{
    int ends[2], status;
    size_t n = 0;
    ssize_t got;
    pid_t pid;

    assert_int_equal(pipe(ends), 0);
    pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        dup2(ends[1], 1);
        dup2(ends[1], 2);
        close(ends[0]);
        close(ends[1]);
        execvp(argv[0], (char *const *)argv);
        _exit(127);
    }
    close(ends[1]);
    while ((got = read(ends[0], ret + n, size - 1 - n)) > 0)
        n += (size_t)got;
    ret[n] = 0;
    close(ends[0]);
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 255;
}

const char *real_data(const char *inside)
{
    static char path[512];
    const char *root = getenv("TTFBOX_TEST_DATA"); /* NOLINT(concurrency-mt-unsafe) */

    if (root && root[0])
        snprintf(path, sizeof(path), "%s/%s", root, inside);
    else
        snprintf(path, sizeof(path), "%s/%s", TEST_DATA_DEFAULT, inside);
    if (exists(path))
        return path;
    print_message("skipped: there is no %s (optional real data, see CONTRIBUTING.md)\n", path);
    return NULL;
}

bool have_program(const char *program)
{
    char text[64];

    if (run_program((const char *const[]){program, "-version", NULL}, text, sizeof(text)) == 0)
        return true;
    print_message("skipped: there is no %s here\n", program);
    return false;
}

int open_files(void)
{
    return count_entries("/proc/self/fd");
}
