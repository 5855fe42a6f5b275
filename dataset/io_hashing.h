/* SPDX-License-Identifier: Apache-2.0 */
/* io_hashing.h: SHA-256 of a file while it is written. For the store's files only. */
#ifndef TTF_DATASET_IO_HASHING_H
#define TTF_DATASET_IO_HASHING_H

#include "ttf/dataset/hash.h"
#include "ttf/dataset/io.h"

/* A twin of base that watches what is written to one handle. */
struct ttf_io_hashing {
    struct ttf_io io; /* first */
    struct ttf_io *base;
    int file; /* the one watched */
    struct ttf_sha256 hash;
    int64_t at;      /* end of what was hashed */
    bool sequential; /* so far each byte came behind the last one */
};

void ttf_io_hashing_init(struct ttf_io_hashing *hashing, struct ttf_io *base, int file);

/*
 * Bytes and hash of the file: what was hashed on the way if it was written from
 * front to back, else it is read back by pieces into `piece` (TTF_SHA256_PIECE bytes).
 */
TTF_MUST_USE int ttf_io_hashing_result(struct ttf_io_hashing *hashing, void *piece,
                                       int64_t *ret_bytes, char ret_hex[65]);

#endif
