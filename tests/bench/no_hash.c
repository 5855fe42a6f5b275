/* SPDX-License-Identifier: Apache-2.0 */
/* no_hash.c: loaded before a program, it makes every SHA-256 that of nothing, at no cost: what hashing costs is the difference. */
#include <nettle/sha2.h>

void nettle_sha256_update(struct sha256_ctx *ctx, size_t length, const uint8_t *data)
{
    (void)ctx;
    (void)length;
    (void)data;
}
