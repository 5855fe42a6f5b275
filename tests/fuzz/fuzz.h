/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz.h: what the fuzz targets share: the entry points, and a file that lies in memory. */
#ifndef FUZZ_FUZZ_H
#define FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/dataset/io.h"

/* The fuzzer's entry point, one in each target; always returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What mutate.c brings beside the fuzzer's own mutations, which LLVMFuzzerMutate are. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

/* An I/O table in which every path is the same read-only file. Embedded first. */
struct fuzz_io {
    struct ttf_io base;
    const uint8_t *data;
    size_t size;
};

/* data is borrowed. Nothing is to be freed. */
void fuzz_io_init(struct fuzz_io *io, const uint8_t *data, size_t size);

#endif
