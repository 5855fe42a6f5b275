/* SPDX-License-Identifier: Apache-2.0 */
/* store_test.h: what the tests of the store share: folders, a small dataset, commands. */
#ifndef STORE_TEST_H
#define STORE_TEST_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>

#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/record.h"
#include "ttf/dataset/writer.h"

/* cmocka setup and teardown: *state is a fresh folder's path, removed afterwards. */
int folder_setup(void **state);
int folder_teardown(void **state);

/* Joined into one of sixteen static buffers. */
const char *in(const char *folder, const char *fmt, ...) __attribute__((format(printf, 2, 3)));

/* Runs a shell command quietly: its exit status. */
int run(const char *fmt, ...) __attribute__((format(printf, 1, 2)));

/* `sha256sum --strict -c` in that dataset: its exit status. */
int sha256sum_check(const char *dataset);

/* One stream "main" of 4 x 3 pixels. */
void small_manifest(struct ttf_manifest *manifest);

/* A new dataset with a plan and segment 0 (10 s interval). */
struct ttf_writer *small_create(struct ttf_io *io, const char *path);

/* Writes text as one file of the slot and commits it: 0 or the error. */
int small_slot(struct ttf_writer *writer, int64_t index);

/* The bytes that small_slot gives slot `index`. */
void small_bytes(int64_t index, char ret[64]);

/* Reads all slots and their files: how many captured slots are whole; fails the test on a torn one. */
int64_t small_check(struct ttf_io *io, const char *path);

/* A file's whole text, zero-terminated; to be freed. Fails the test if it cannot be read. */
char *file_text(const char *path, size_t *ret_bytes);
void write_text(const char *path, const void *data, size_t n);
bool exists(const char *path);
int64_t size_of(const char *path);

#endif
