/* SPDX-License-Identifier: Apache-2.0 */
#include "tar_read.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct tar_reader {
    const struct folder *folder;
    struct tar_layout layout;
    size_t at; /* the file that is open */
    int fd;    /* -1: none */
};

struct tar_reader *tar_reader_create(const struct folder *folder, struct tar_layout *layout)
{
    struct tar_reader *reader = calloc(1, sizeof *reader);

    if (!reader) {
        tar_layout_free(layout);
        return NULL;
    }
    reader->folder = folder;
    reader->layout = *layout;
    *layout = (struct tar_layout){0};
    reader->fd = -1;
    return reader;
}

void tar_reader_destroy(struct tar_reader *reader)
{
    if (!reader)
        return;
    if (reader->fd >= 0)
        (void)close(reader->fd);
    tar_layout_free(&reader->layout);
    free(reader);
}

const struct tar_layout *tar_reader_layout(const struct tar_reader *reader)
{
    return &reader->layout;
}

/* The last file whose header begins at or before offset. There is one. */
static size_t find(const struct tar_layout *layout, int64_t offset)
{
    size_t lo = 0, hi = layout->n;

    while (hi - lo > 1) {
        size_t mid = lo + (hi - lo) / 2;

        if (layout->files[mid].offset <= offset)
            lo = mid;
        else
            hi = mid;
    }
    return lo;
}

static ssize_t read_content(struct tar_reader *reader, size_t i, int64_t inside, void *buf,
                            size_t n)
{
    const struct tar_file *file = &reader->layout.files[i];
    ssize_t got;

    if (reader->fd >= 0 && reader->at != i) {
        (void)close(reader->fd);
        reader->fd = -1;
    }
    if (reader->fd < 0)
        reader->fd = folder_file(reader->folder, reader->layout.dataset, file->path, NULL);
    if (reader->fd < 0)
        return -EIO; /* it was there when it was laid out */
    reader->at = i;
    if ((int64_t)n > file->bytes - inside)
        n = (size_t)(file->bytes - inside);
    got = pread(reader->fd, buf, n, inside);
    if (got < 0)
        return -errno;
    return got == 0 ? -EIO : got;
}

static ssize_t zeros(void *buf, size_t n, int64_t left)
{
    if ((int64_t)n > left)
        n = (size_t)left;
    memset(buf, 0, n);
    return (ssize_t)n;
}

ssize_t tar_read(struct tar_reader *reader, int64_t offset, void *buf, size_t n)
{
    const struct tar_layout *layout = &reader->layout;
    int64_t tail = layout->bytes - (int64_t)2 * TAR_BLOCK;
    const struct tar_file *file;
    unsigned char header[TAR_BLOCK];
    int64_t inside;
    size_t i;

    if (offset >= layout->bytes)
        return 0;
    if (offset >= tail)
        return zeros(buf, n, layout->bytes - offset);
    i = find(layout, offset);
    file = &layout->files[i];
    inside = offset - file->offset;
    if (inside < TAR_BLOCK) {
        if (!tar_header(layout, file, header))
            return -EIO; /* it was looked at when it was laid out */
        if (n > (size_t)(TAR_BLOCK - inside))
            n = (size_t)(TAR_BLOCK - inside);
        memcpy(buf, header + inside, n);
        return (ssize_t)n;
    }
    inside -= TAR_BLOCK;
    if (inside < file->bytes)
        return read_content(reader, i, inside, buf, n);
    return zeros(buf, n, (file->bytes + TAR_BLOCK - 1) / TAR_BLOCK * TAR_BLOCK - inside);
}
