/* SPDX-License-Identifier: Apache-2.0 */
#include "described.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/hash.h"

#define PIECE 65536

/* The line "HEX  path" within text, which holds whole lines. */
static bool find_line(const char *text, size_t n, const char *wanted, size_t n_wanted, char ret[65])
{
    const char *at = text, *end = text + n;

    while (at < end && (at = memmem(at, (size_t)(end - at), wanted, n_wanted))) {
        size_t before = (size_t)(at - text); /* wanted begins with the two blanks */

        if (before == 64 || (before > 64 && at[-65] == '\n')) {
            memcpy(ret, at - 64, 64);
            ret[64] = '\0';
            if (ttf_sha256_is_hex(ret))
                return true;
        }
        at++;
    }
    return false;
}

static int search(int fd, const char *path, char ret[65])
{
    char wanted[200], *piece = malloc(PIECE);
    int n_wanted = snprintf(wanted, sizeof wanted, "  %s\n", path);
    size_t kept = 0;
    int r = -ENODATA;
    int64_t offset = 0;

    if (!piece)
        return -ENOMEM;
    for (;;) {
        ssize_t got = pread(fd, piece + kept, PIECE - kept, offset);
        const char *lf;
        size_t n, lines;

        if (got <= 0) {
            if (got < 0)
                r = -errno;
            break;
        }
        offset += got;
        n = kept + (size_t)got;
        lf = memrchr(piece, '\n', n);
        lines = lf ? (size_t)(lf - piece) + 1 : 0;
        if (find_line(piece, lines, wanted, (size_t)n_wanted, ret)) {
            r = 0;
            break;
        }
        kept = n - lines;
        if (kept > PIECE / 2)
            kept = 0; /* a line as no list has it */
        memmove(piece, piece + lines, kept);
    }
    free(piece);
    return r;
}

int described_sha256(const struct folder *folder, const char *dataset, const char *path,
                     char ret[65])
{
    int fd = folder_file(folder, dataset, "SHA256SUMS", NULL);
    int r;

    if (fd < 0)
        return fd == -ENOENT ? -ENODATA : fd;
    r = search(fd, path, ret);
    (void)close(fd);
    return r;
}

bool described_sealed(const struct folder *folder, const char *dataset)
{
    char hex[65];

    return described_sha256(folder, dataset, "records.jsonl", hex) == 0;
}
