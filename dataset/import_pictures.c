/* SPDX-License-Identifier: Apache-2.0 */
/* import_pictures.c: frames from a list of pictures and of pages of stacks. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "image_file_codecs.h"
#include "import_source.h"

struct picture_source {
    struct import_source base; /* first: downcast by address */
    struct ttf_io *io;
    const struct import_list *list;
    size_t next;
    struct ttf_tiff_reader
        *stack; /* stays open from page to page: finding page k walks over those before */
    const char *stack_path;
    unsigned stack_page;
};

static int open_page(struct picture_source *source, const struct import_frame *frame,
                     struct ttf_err *err)
{
    int code = 0;

    if (!source->stack || strcmp(source->stack_path, frame->path) != 0) {
        ttf_tiff_reader_close(source->stack);
        source->stack = NULL;
        code = ttf_tiff_reader_open(source->io, frame->path, &source->stack, err);
        if (code)
            return code;
        source->stack_path = frame->path;
        source->stack_page = 0;
    }
    if (frame->page != source->stack_page)
        code = ttf_tiff_reader_page(source->stack, frame->page, err);
    source->stack_page = frame->page;
    return code;
}

static int read_page(struct picture_source *source, const struct import_frame *frame,
                     struct ttf_pixbuf *ret, struct ttf_image_info *info, struct ttf_err *err)
{
    struct ttf_pixbuf pixels;
    int code = open_page(source, frame, err);

    if (code)
        return code;
    *info = (struct ttf_image_info){.orientation = 1, .taken_utc_ns = TTF_NS_UNKNOWN};
    image_info_of_tiff(source->stack, info);
    code = image_check_size(info->width, info->height, frame->path, err);
    if (code)
        return code;
    code = ttf_pixbuf_alloc(&pixels, info->width, info->height, info->samples, info->format);
    if (code)
        return ttf_err_set(err, code, frame->path, "no memory for %u x %u pixels", info->width,
                           info->height);
    code = ttf_tiff_reader_rows(source->stack, 0, pixels.height, pixels.data, pixels.stride, err);
    if (!code && (code = image_upright(&pixels, info->orientation)))
        ttf_err_set(err, code, frame->path, "no memory to turn the picture upright");
    if (code) {
        ttf_pixbuf_free(&pixels);
        return code;
    }
    info->width = pixels.width;
    info->height = pixels.height;
    *ret = pixels;
    return 0;
}

static int picture_next(struct import_source *base, struct ttf_pixbuf *ret,
                        struct ttf_image_info *ret_info, const char **ret_name, struct ttf_err *err)
{
    struct picture_source *source = (struct picture_source *)base;
    const struct import_frame *frame;
    int code;

    if (source->next >= source->list->n)
        return 0;
    frame = &source->list->frame[source->next++];
    *ret_name = frame->path;
    if (frame->kind == TTF_IMAGE_TIFF)
        code = read_page(source, frame, ret, ret_info, err);
    else
        code = ttf_image_read(source->io, frame->path, 0, ret, ret_info, err);
    return code ? code : 1;
}

static void picture_destroy(struct import_source *base)
{
    struct picture_source *source = (struct picture_source *)base;

    ttf_tiff_reader_close(source->stack);
    free(source);
}

static const struct import_source_ops picture_ops = {
    .next = picture_next,
    .destroy = picture_destroy,
};

int import_pictures(const struct import_list *list, struct ttf_io *io, struct import_source **ret,
                    struct ttf_err *err)
{
    struct picture_source *source = calloc(1, sizeof(*source));

    if (!source)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to read pictures");
    source->base.ops = &picture_ops;
    source->base.total = (int64_t)list->n;
    source->io = io;
    source->list = list;
    *ret = &source->base;
    return 0;
}
