/* SPDX-License-Identifier: Apache-2.0 */
/* SHA256SUMS of a small dataset, running and sealed: the first byte is a mode, the rest the file. */
#include "fuzz.h"
#include "store.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_disk disk;

    if (size == 0)
        return 0;
    fuzz_disk_init(&disk);
    fuzz_store_small(&disk, data[0]);
    fuzz_store_put_sums(&disk, data + 1, size - 1, data[0]);
    fuzz_store_check(&disk);
    fuzz_disk_free(&disk);
    return 0;
}
