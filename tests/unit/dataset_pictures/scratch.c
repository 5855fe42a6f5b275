/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scratch.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ttf/dataset/io.h"

int scratch_make(void **state)
{
    char template[] = "/tmp/ttf-pictures-XXXXXX";

    if (!mkdtemp(template))
        return -1;
    *state = strdup(template);
    return *state ? 0 : -1;
}

static void remove_tree(const char *path)
{
    DIR *dir = opendir(path);
    const struct dirent *entry;

    while (dir && (entry = readdir(dir))) { /* NOLINT(concurrency-mt-unsafe): one thread */
        char child[512];
        struct stat st;

        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
            continue;
        snprintf(child, sizeof(child), "%s/%s", path, entry->d_name);
        if (lstat(child, &st) == 0 && S_ISDIR(st.st_mode))
            remove_tree(child);
        else
            unlink(child);
    }
    if (dir)
        closedir(dir);
    rmdir(path);
}

int scratch_remove(void **state)
{
    remove_tree(*state);
    free(*state);
    return 0;
}

const char *scratch_path(void **state, const char *name)
{
    static char ring[8][512];
    static unsigned next;
    char *path = ring[next++ % 8];

    snprintf(path, sizeof(ring[0]), "%s/%s", (const char *)*state, name);
    return path;
}

int scratch_create(void **state, const char *name)
{
    struct ttf_io *io = ttf_io_posix();
    const char *path = scratch_path(state, name);
    int file;

    unlink(path);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    assert_true(file >= 0);
    return file;
}

void scratch_write(void **state, const char *name, const void *bytes, size_t n)
{
    struct ttf_io *io = ttf_io_posix();
    int file = scratch_create(state, name);

    assert_int_equal(ttf_io_pwrite_all(io, file, bytes, n, 0), 0);
    assert_int_equal(io->ops->close(io, file), 0);
}

uint8_t *scratch_read(void **state, const char *name, size_t *ret_bytes)
{
    char *text = NULL;

    assert_int_equal(ttf_io_slurp(ttf_io_posix(), scratch_path(state, name), (size_t)1 << 30, &text,
                                  ret_bytes, NULL),
                     0);
    return (uint8_t *)text;
}

uint32_t scratch_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8 ^ *seed << 16;
}

const char *scratch_real_data(void)
{
    /* From the tree, a build folder in it, or a test's own folder in that. */
    static const char up[] = "../../../../../../shared/data";
    const char *named =
        getenv("TTFBOX_TEST_DATA"); /* NOLINT(concurrency-mt-unsafe): nobody sets it */

    if (named)
        return access(named, R_OK) == 0 ? named : NULL;
    for (unsigned levels = 6; levels > 0; levels--) {
        const char *path = up + (levels - 1) * 3;

        if (access(path, R_OK) == 0)
            return path;
    }
    return NULL;
}
