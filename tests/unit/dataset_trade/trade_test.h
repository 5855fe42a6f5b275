/* SPDX-License-Identifier: Apache-2.0 */
/* trade_test.h: a folder of one's own, pictures to put there, and looking at what came out. */
#ifndef TRADE_TEST_H
#define TRADE_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/pixbuf.h"

struct folder_text {
    struct folder_text *next;
    char text[512];
};

struct folder {
    char path[64];
    struct folder_text *texts; /* handed out by in_folder */
};

/* cmocka fixtures: *state is a struct folder, removed with all that is in it afterwards. */
int folder_setup(void **state);
int folder_teardown(void **state);

/* "FOLDER/...", good until teardown. */
const char *in_folder(void **state, const char *fmt, ...) TTF_PRINTF(2, 3);

bool exists(const char *path);
/* Entries of a folder without . and .., -1 if there is none. */
int count_entries(const char *path);
/* Whole file, to be freed. */
uint8_t *slurp(const char *path, size_t *ret_bytes);
void write_bytes(const char *path, const void *data, size_t n);
/* Equal bytes? */
bool same_files(const char *a, const char *b);

/* A test picture: codes that differ by place, sample and `seed`. To be freed. */
struct ttf_pixbuf make_picture(uint32_t width, uint32_t height, uint32_t samples,
                               enum ttf_sample format, unsigned seed);
void save_png(const char *path, const struct ttf_pixbuf *pixels);
void save_jpeg(const char *path, const struct ttf_pixbuf *pixels, int quality);
bool same_pixels(const struct ttf_pixbuf *a, const struct ttf_pixbuf *b);
/* Makes it and saves it. */
void picture_file(const char *path, uint32_t width, uint32_t height, unsigned seed);

/* Runs a program (argv ends in NULL) and hands back its exit code; what it printed (cut) in ret, size bytes. */
int run_program(const char *const argv[], char *ret, size_t size);

/* Is there such a program (that knows -version)? If not, says so. */
bool have_program(const char *program);

/* Of this process: before and after, to see that none is left open. */
int open_files(void);

/* The folder of optional real data, or NULL: then says so and the test should skip(). */
const char *real_data(const char *inside);

#endif
