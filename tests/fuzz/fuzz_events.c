/* SPDX-License-Identifier: Apache-2.0 */
/* events.jsonl of a small dataset: the first byte is a mode, the rest the file. */
#include <stdlib.h>

#include "framing.h"
#include "fuzz.h"
#include "store.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_disk disk;
    char *framed;
    size_t n;

    if (size == 0)
        return 0;
    fuzz_disk_init(&disk);
    fuzz_store_small(&disk, data[0]);
    if (data[0] & FUZZ_FRAME_EVENTS) {
        framed = fuzz_frame_lines(data + 1, size - 1, &n);
        fuzz_disk_put(&disk, FUZZ_DATASET "/events.jsonl", framed, n);
        free(framed);
    } else {
        fuzz_disk_put(&disk, FUZZ_DATASET "/events.jsonl", data + 1, size - 1);
    }
    fuzz_store_check(&disk);
    fuzz_disk_free(&disk);
    return 0;
}
