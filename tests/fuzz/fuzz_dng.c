/* SPDX-License-Identifier: Apache-2.0 */
/* DNG files, ours and foreign: plain and lossless JPEG. */
#include "fuzz.h"
#include "ttf/dataset/dng.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_dng_info info;
    struct ttf_raw_sum raw;
    struct ttf_err err = {0};
    struct fuzz_io io;

    fuzz_io_init(&io, data, size);
    if (ttf_dng_read(&io.base, "frame.dng", &raw, &info, &err) == 0)
        ttf_raw_sum_free(&raw);
    return 0;
}
