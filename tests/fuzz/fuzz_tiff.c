/* SPDX-License-Identifier: Apache-2.0 */
/* TIFF files: through the front of all pictures, and by rows and pages as sequences read them. */
#include <stdlib.h>

#include "fuzz.h"
#include "picture.h"
#include "ttf/dataset/tiff.h"

static void read_page(struct ttf_tiff_reader *tiff)
{
    const struct ttf_tiff_info *info = ttf_tiff_reader_info(tiff);
    size_t stride = (size_t)info->width * info->samples * ttf_sample_bytes(info->format);
    uint32_t last = info->height - 1;
    struct ttf_err err = {0};
    void *row;

    if ((uint64_t)info->width * info->height > 1000000u)
        return;
    row = malloc(stride);
    if (!row)
        return;
    /* Backwards, so that strips are found again. */
    for (uint32_t y = info->height; y-- > 0 && last - y < 64;)
        if (ttf_tiff_reader_rows(tiff, y, 1, row, stride, &err) < 0)
            break;
    free(row);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_tiff_reader *tiff = NULL;
    struct ttf_err err = {0};
    struct fuzz_io io;

    if (size < 4 || (data[0] != 'I' && data[0] != 'M'))
        return 0;
    fuzz_picture(data, size);
    fuzz_io_init(&io, data, size);
    if (ttf_tiff_reader_open(&io.base, "picture.tif", &tiff, &err) < 0)
        return 0;
    read_page(tiff);
    if (ttf_tiff_reader_info(tiff)->pages > 1 && ttf_tiff_reader_page(tiff, 1, &err) == 0)
        read_page(tiff);
    ttf_tiff_reader_close(tiff);
    return 0;
}
