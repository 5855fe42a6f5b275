/* SPDX-License-Identifier: Apache-2.0 */
/* store.h: a small dataset in memory, and what must hold of any, however damaged. */
#ifndef FUZZ_STORE_H
#define FUZZ_STORE_H

#include "disk.h"

#define FUZZ_DATASET "d"
#define FUZZ_SLOTS   3

/* How the input's lines come to the disk: the bits of its first byte. */
enum fuzz_mode {
    FUZZ_FRAME_RECORDS = 1, /* seq and crc are made to hold */
    FUZZ_FRAME_EVENTS = 2,
    FUZZ_MEND_SUMS = 4, /* the sha256 of files that are there are made to hold */
    FUZZ_ENDED = 8      /* of the dataset's own records: with the "end" line */
};

/* The manifest, a plan, FUZZ_SLOTS slots with a file each, and their records; no SHA256SUMS. */
void fuzz_store_small(struct fuzz_disk *disk, unsigned mode);

/* Lines of SHA256SUMS: if mended, each hash is the one of the file it names, where there is one. */
void fuzz_store_put_sums(struct fuzz_disk *disk, const uint8_t *data, size_t size, unsigned mode);

/*
 * Verifies, reads, opens to go on, writes, seals. Aborts if looking changes a byte, if opening what
 * it refuses does, if a line that was whole is lost, or if what had no damage then has.
 */
void fuzz_store_check(struct fuzz_disk *disk);

#endif
