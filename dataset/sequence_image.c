/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>

#include "ttf/dataset/image_file.h"
#include "ttf/dataset/sequence.h"

/* A sequence in memory that owns its one frame. */
struct image_sequence {
    struct ttf_sequence base; /* first: downcast by address */
    struct ttf_sequence *memory;
    struct ttf_pixbuf pixels;
};

static int image_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                           uint16_t *dst, struct ttf_err *err)
{
    struct image_sequence *image = (struct image_sequence *)sequence;

    return ttf_sequence_read_rows(image->memory, t, y0, rows, dst, err);
}

static void image_destroy(struct ttf_sequence *sequence)
{
    struct image_sequence *image = (struct image_sequence *)sequence;

    ttf_sequence_destroy(image->memory);
    ttf_pixbuf_free(&image->pixels);
    free(image);
}

static const struct ttf_sequence_ops image_ops = {
    .read_rows = image_read_rows,
    .destroy = image_destroy,
};

int ttf_sequence_of_image(struct ttf_io *io, const char *path, struct ttf_sequence **ret,
                          struct ttf_err *err)
{
    static const struct ttf_encoding encoding = {.pedestal = 0, .scale = 65535};
    struct image_sequence *image = calloc(1, sizeof(*image));
    int code;

    if (!image)
        return ttf_err_set(err, -ENOMEM, path, "no memory for a picture");
    code = ttf_image_read_linear(io, path, &image->pixels, NULL, err);
    if (!code)
        code = ttf_sequence_of_memory(image->pixels.data, image->pixels.width, image->pixels.height,
                                      1, &encoding, &image->memory, err);
    if (code) {
        ttf_pixbuf_free(&image->pixels);
        free(image);
        return code;
    }
    image->base = *image->memory;
    image->base.ops = &image_ops;
    *ret = &image->base;
    return 0;
}
