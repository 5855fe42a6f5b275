/* SPDX-License-Identifier: Apache-2.0 */
/*
 * hash.h: SHA-256 of files, as users check it with sha256sum, and the CRC-32 of
 * record lines. Streaming: nothing is held in memory but a small piece.
 */
#ifndef TTF_DATASET_HASH_H
#define TTF_DATASET_HASH_H

#include <nettle/sha2.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

struct ttf_sha256 {
    struct sha256_ctx ctx;
};

void ttf_sha256_init(struct ttf_sha256 *hash);
void ttf_sha256_add(struct ttf_sha256 *hash, const void *data, size_t n);
void ttf_sha256_hex(struct ttf_sha256 *hash, char ret[65]); /* lower case; starts anew */

/* 64 lower-case hex digits and nothing else. */
bool ttf_sha256_is_hex(const char *text);

/* CRC-32 as zlib and PNG have it; crc is 0 at first, then the last result. */
uint32_t ttf_crc32(uint32_t crc, const void *data, size_t n);

#ifndef TTF_SHA256_PIECE /* cmake/Flags.cmake gives the fuzzer's builds less */
#define TTF_SHA256_PIECE \
    ((size_t)256 * 1024) /* bytes read at a time: they fit a small board's cache */
#endif

/* Reads a file from its start, by pieces into `piece` (TTF_SHA256_PIECE bytes). ret_bytes may be NULL. */
TTF_MUST_USE int ttf_sha256_handle_in(struct ttf_io *io, int file, void *piece, int64_t *ret_bytes,
                                      char ret_hex[65]);

/* The same with memory of its own. */
TTF_MUST_USE int ttf_sha256_handle(struct ttf_io *io, int file, int64_t *ret_bytes,
                                   char ret_hex[65]);
TTF_MUST_USE int ttf_sha256_file(struct ttf_io *io, const char *path, int64_t *ret_bytes,
                                 char ret_hex[65], struct ttf_err *err);

#endif
