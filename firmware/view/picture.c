/* SPDX-License-Identifier: Apache-2.0 */
/*
 * picture.c: the writers of PNG and JPEG write at a handle of an I/O table. Here is one whose only
 * file is a piece of memory; they ask for nothing but writing.
 */
#include "picture.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/image_file.h"
#include "ttf/dataset/io.h"

#define PICTURE_BYTES_MAX ((size_t)1 << 30)

struct memory_io {
    struct ttf_io io; /* first: downcast by address */
    struct view_picture *picture;
};

static int64_t memory_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct view_picture *picture = ((struct memory_io *)io)->picture;
    size_t end = (size_t)offset + n;

    (void)file;
    if (offset < 0 || (size_t)offset > PICTURE_BYTES_MAX || n > PICTURE_BYTES_MAX)
        return -EFBIG;
    if (end > picture->room) {
        size_t room = end + end / 2 + 4096;
        uint8_t *data = realloc(picture->data, room);

        if (!data)
            return -ENOMEM;
        picture->data = data;
        picture->room = room;
    }
    memcpy(picture->data + offset, buf, n);
    if (end > picture->bytes)
        picture->bytes = end;
    return (int64_t)n;
}

static const struct ttf_io_ops memory_ops = {.name = "memory", .pwrite = memory_pwrite};

int view_picture_encode(struct view_picture *ret, const struct ttf_pixbuf *rgb8, bool exact,
                        struct ttf_err *err)
{
    struct memory_io memory = {.io = {.ops = &memory_ops}, .picture = ret};

    ret->bytes = 0;
    return exact ? ttf_png_write(&memory.io, 0, rgb8, TTF_TRANSFER_SRGB, VIEW_PNG_LEVEL, NULL, err)
                 : ttf_jpeg_write(&memory.io, 0, rgb8, VIEW_QUALITY, err);
}

void view_picture_free(struct view_picture *picture)
{
    free(picture->data);
    *picture = (struct view_picture){0};
}
