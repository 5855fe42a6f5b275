/* SPDX-License-Identifier: Apache-2.0 */
#include "picture.h"

#include "fuzz.h"
#include "ttf/dataset/image_file.h"

#define PIXELS_MAX 1000000u

void fuzz_picture(const uint8_t *data, size_t size)
{
    struct ttf_image_info info;
    struct ttf_pixbuf pixels, linear;
    struct ttf_err err = {0};
    struct fuzz_io io;

    fuzz_io_init(&io, data, size);
    if (ttf_image_probe(&io.base, "picture", &info, &err) < 0 ||
        (uint64_t)info.width * info.height > PIXELS_MAX)
        return;
    for (unsigned page = 0; page < info.pages && page < 3; page++) {
        struct ttf_image_info of_page;

        /* Later pages may be larger than the first that was probed. */
        if (ttf_image_read(&io.base, "picture", page, &pixels, &of_page, &err) < 0)
            continue;
        if (ttf_image_linear(&pixels, &of_page, TTF_TRANSFER_AUTO, NULL, 3, &linear) == 0)
            ttf_pixbuf_free(&linear);
        ttf_pixbuf_free(&pixels);
    }
}
