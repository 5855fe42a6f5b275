/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/hash.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

void ttf_sha256_init(struct ttf_sha256 *hash)
{
    sha256_init(&hash->ctx);
}

void ttf_sha256_add(struct ttf_sha256 *hash, const void *data, size_t n)
{
    sha256_update(&hash->ctx, n, data);
}

void ttf_sha256_hex(struct ttf_sha256 *hash, char ret[65])
{
    static const char digits[] = "0123456789abcdef";
    uint8_t digest[SHA256_DIGEST_SIZE];
    size_t i;

    sha256_digest(&hash->ctx, sizeof(digest), digest);
    for (i = 0; i < sizeof(digest); i++) {
        ret[2 * i] = digits[digest[i] >> 4];
        ret[2 * i + 1] = digits[digest[i] & 15];
    }
    ret[64] = '\0';
}

bool ttf_sha256_is_hex(const char *text)
{
    return strspn(text, "0123456789abcdef") == 64 && text[64] == '\0';
}

uint32_t ttf_crc32(uint32_t crc, const void *data, size_t n)
{
    return (uint32_t)crc32_z(crc, data, n);
}

int ttf_sha256_handle(struct ttf_io *io, int file, int64_t *ret_bytes, char ret_hex[65])
{
    void *piece = malloc(TTF_SHA256_PIECE);
    int r = piece ? ttf_sha256_handle_in(io, file, piece, ret_bytes, ret_hex) : -ENOMEM;

    free(piece);
    return r;
}

int ttf_sha256_handle_in(struct ttf_io *io, int file, void *piece, int64_t *ret_bytes,
                         char ret_hex[65])
{
    struct ttf_sha256 hash;
    int64_t at = 0, got;

    ttf_sha256_init(&hash);
    while ((got = ttf_io_pread_all(io, file, piece, TTF_SHA256_PIECE, at)) > 0) {
        ttf_sha256_add(&hash, piece, (size_t)got);
        at += got;
    }
    if (got < 0)
        return (int)got;
    ttf_sha256_hex(&hash, ret_hex);
    if (ret_bytes)
        *ret_bytes = at;
    return 0;
}

int ttf_sha256_file(struct ttf_io *io, const char *path, int64_t *ret_bytes, char ret_hex[65],
                    struct ttf_err *err)
{
    int file, r;

    file = io->ops->open(io, path, TTF_IO_READ);
    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be opened: %s", strerrordesc_np(-file));
    r = ttf_sha256_handle(io, file, ret_bytes, ret_hex);
    if (r)
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    io->ops->close(io, file);
    return r;
}
