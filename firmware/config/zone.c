/* SPDX-License-Identifier: Apache-2.0 */
/*
 * zone.c: a time zone's offset at one instant, from the machine's zone files
 * (TZif, RFC 8536). The C library knows zones only through the environment of
 * the whole process, which no library may change.
 */
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/config/plan_file.h"

#define ZONE_BYTES_MAX 65536
#define HEADER         44

static int64_t big_endian(const unsigned char *p, unsigned bytes)
{
    uint64_t v = (p[0] & 0x80) ? UINT64_MAX : 0;

    for (unsigned i = 0; i < bytes; i++)
        v = v << 8 | p[i];
    return (int64_t)v;
}

/* One data block of a TZif file; `wide` is 8 for version 2 blocks. */
struct block {
    const unsigned char *times, *types, *infos;
    uint32_t n_times, n_types;
    size_t bytes; /* of the block behind its header */
};

static bool read_block(const unsigned char *p, size_t left, unsigned wide, struct block *ret)
{
    uint32_t n[6]; /* isutc, isstd, leap, time, type, char */

    if (left < HEADER || memcmp(p, "TZif", 4) != 0)
        return false;
    for (unsigned i = 0; i < 6; i++) {
        n[i] = (uint32_t)big_endian(p + 20 + 4 * (size_t)i, 4);
        if (n[i] > ZONE_BYTES_MAX)
            return false;
    }
    ret->n_times = n[3];
    ret->n_types = n[4];
    ret->times = p + HEADER;
    ret->types = ret->times + (size_t)n[3] * wide;
    ret->infos = ret->types + n[3];
    ret->bytes = (size_t)n[3] * (wide + 1) + (size_t)n[4] * 6 + n[5] + (size_t)n[2] * (wide + 4) +
                 n[1] + n[0];
    return ret->n_types > 0 && ret->bytes <= left - HEADER;
}

/*
 * The offset in force at second `at`. Zone files of the distribution list every
 * change up to 2037; the rule behind them is not read, later instants get the
 * last offset listed.
 */
static bool offset_at(const unsigned char *file, size_t bytes, int64_t at, int *ret)
{
    struct block b;
    unsigned wide = 4, type = 0;

    if (!read_block(file, bytes, 4, &b))
        return false;
    if (file[4] >= '2') {
        size_t skip = HEADER + b.bytes;

        if (!read_block(file + skip, bytes - skip, 8, &b))
            return false;
        wide = 8;
    }
    for (uint32_t i = 0; i < b.n_times; i++)
        if (big_endian(b.times + (size_t)i * wide, wide) <= at)
            type = b.types[i];
    if (type >= b.n_types)
        return false;
    *ret = (int)big_endian(b.infos + (size_t)type * 6, 4);
    return true;
}

int ttf_zone_offset(const char *zone, int64_t utc_ns, int *ret_offset_s, struct ttf_err *err)
{
    char path[128];
    unsigned char *file;
    size_t n;
    FILE *f;
    bool ok;

    if (strcmp(zone, "UTC") == 0 || !*zone) {
        *ret_offset_s = 0;
        return 0;
    }
    snprintf(path, sizeof path, "/usr/share/zoneinfo/%s", zone);
    f = strstr(zone, "..") || *zone == '/' ? NULL : fopen(path, "rbe");
    if (!f) {
        ttf_err_set(err, -ENOENT, NULL, "this machine knows no time zone '%s'", zone);
        ttf_err_hint(err, "write UTC or a name as Europe/Berlin; the package tzdata has them");
        return -ENOENT;
    }
    file = malloc(ZONE_BYTES_MAX);
    n = file ? fread(file, 1, ZONE_BYTES_MAX, f) : 0;
    ok = n && offset_at(file, n, utc_ns / TTF_NS_PER_S, ret_offset_s);
    free(file);
    (void)fclose(f);
    if (!ok)
        return ttf_err_set(err, -EINVAL, NULL, "the zone file %s cannot be read", path);
    return 0;
}
