/* SPDX-License-Identifier: Apache-2.0 */
/* Space kept back, so that what happened can be written down on a full disk (DESIGN.md, "Events"). */
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "writer_private.h"

#define STEP_BYTES ((int64_t)64 * 1024)

/* Noise: a file system that compresses or skips zeros would keep nothing back for it. */
static void fill_noise(uint64_t *words, size_t n, uint64_t seed)
{
    uint64_t x = seed * 2 + 1;
    size_t i;

    for (i = 0; i < n; i++) {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        words[i] = x;
    }
}

static int grow(struct ttf_io *io, int file, int64_t bytes)
{
    uint64_t *words = malloc((size_t)STEP_BYTES);
    int r = words ? 0 : -1;

    while (r == 0 && bytes < TTF_RESERVE_BYTES) {
        int64_t n = TTF_RESERVE_BYTES - bytes < STEP_BYTES ? TTF_RESERVE_BYTES - bytes : STEP_BYTES;

        fill_noise(words, (size_t)STEP_BYTES / sizeof(*words), (uint64_t)bytes + 1);
        r = ttf_io_append_all(io, file, words, (size_t)n);
        bytes += n;
    }
    free(words);
    return r;
}

void ttf_reserve_make(struct ttf_writer *writer)
{
    char *path = ttf_path_format("%s/" TTF_RESERVE_NAME, writer->path);
    struct ttf_io *io = writer->io;
    int64_t bytes = 0;
    int file;

    if (!path)
        return;
    file = io->ops->open(io, path, TTF_IO_APPEND);
    free(path);
    if (file < 0)
        return;
    if (io->ops->size(io, file, &bytes) == 0 && bytes < TTF_RESERVE_BYTES &&
        grow(io, file, bytes) == 0)
        (void)io->ops->sync(io, file, false);
    io->ops->close(io, file);
}

bool ttf_reserve_use(struct ttf_writer *writer)
{
    char *path = ttf_path_format("%s/" TTF_RESERVE_NAME, writer->path);
    struct ttf_io *io = writer->io;
    struct ttf_io_stat st;
    bool used = false;
    int file;

    if (!path)
        return false;
    if (io->ops->stat(io, path, &st) == 0 && st.bytes > 0) {
        file = io->ops->open(io, path, TTF_IO_APPEND);
        if (file >= 0) {
            used =
                io->ops->truncate(io, file, st.bytes > STEP_BYTES ? st.bytes - STEP_BYTES : 0) == 0;
            /* Blocks may come free only when the file system has written this down. */
            (void)io->ops->sync(io, file, false);
            io->ops->close(io, file);
        }
    }
    free(path);
    return used;
}
