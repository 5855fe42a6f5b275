/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the USB scenarios (usb.py) ask of programs in the rig's guest:
 *
 *   rig_usb source FOLDER           a box's end of a cable without streams
 *   rig_usb drain BYTES             a PC's end of it: MB/s
 *   rig_usb body BOX PATH [once]    GETs it again and again until the box goes, and throws it away: bytes; once: MB/s
 *   rig_usb status BOX              as soon as somebody listens there: milliseconds until the right answer
 *   rig_usb sha256 BYTES            MB/s of hashing alone
 *   rig_usb write FILE BYTES        MB/s of writing alone, as a pull writes
 *
 * BOX is written as for `ttfbox pull`.
 */
#include "rig_usb.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/io.h"
#include "wire.h"

#define PIECE     65536u
#define LISTEN_NS (20 * TTF_NS_PER_S)
#define AGAIN_NS  (2 * TTF_NS_PER_MS)

static int say_rate(int64_t bytes, int64_t took_ns)
{
    printf("%.2f MB/s\n", (double)bytes * 1e3 / (double)(took_ns > 0 ? took_ns : 1));
    return 0;
}

static int drain(struct ttf_clock *clock, int64_t bytes)
{
    int64_t rate = rig_usb_drain(clock, bytes);

    return rate < 0 ? (int)rate : say_rate(rate, TTF_NS_PER_S);
}

/* ---- by HTTP ---- */

static int count(void *ctx, const void *data, size_t n)
{
    (void)data;
    *(int64_t *)ctx += (int64_t)n;
    return 0;
}

static int body(struct ttf_clock *clock, const char *box, const char *path, bool once)
{
    const struct ttf_pull_config config = {.box = box};
    struct ttf_err err = {0};
    struct wire *wire;
    int64_t bytes = 0, begun, before;
    const struct wire_sink sink = {NULL, count, &bytes};
    int r = pull_wire_create(&config, &wire, &err);

    if (r < 0)
        return r;
    do {
        begun = ttf_clock_now_ns(clock);
        before = bytes;
        r = pull_wire_get(wire, path, 0, -1, NULL, &sink, &err);
    } while (r == 0 && !once);
    if (!once)
        printf("%" PRId64 " bytes\n", bytes);
    else if (r == 0)
        (void)say_rate(bytes - before, ttf_clock_now_ns(clock) - begun);
    pull_wire_destroy(wire);
    return once ? r : 0;
}

static int status(struct ttf_clock *clock, const char *box)
{
    const struct ttf_pull_config config = {.box = box};
    struct ttf_err err = {0};
    struct wire *wire;
    int64_t until = ttf_clock_now_ns(clock) + LISTEN_NS, begun;
    char *text = NULL;
    size_t n;
    int r = pull_wire_create(&config, &wire, &err);

    if (r < 0)
        return r;
    do {
        begun = ttf_clock_now_ns(clock);
        r = pull_wire_get_text(wire, "/health", 0, -1, PIECE, &text, &n, &err);
        if (r == -ECONNREFUSED)
            (void)ttf_clock_wait_until(clock, begun + AGAIN_NS);
    } while (r == -ECONNREFUSED && begun < until);
    if (r == 0 && text && !strstr(text, "\"ok\":true"))
        r = -EPROTO;
    if (r == 0)
        printf("%.1f ms\n", (double)(ttf_clock_now_ns(clock) - begun) / 1e6);
    free(text);
    pull_wire_destroy(wire);
    return r;
}

/* ---- what else a pull does ---- */

static int hash_alone(struct ttf_clock *clock, const uint8_t *piece, int64_t bytes)
{
    struct ttf_sha256 hash;
    char hex[65];
    int64_t begun = ttf_clock_now_ns(clock);

    ttf_sha256_init(&hash);
    for (int64_t n = 0; n < bytes; n += PIECE)
        ttf_sha256_add(&hash, piece, PIECE);
    ttf_sha256_hex(&hash, hex);
    return say_rate(bytes, ttf_clock_now_ns(clock) - begun);
}

static int write_alone(struct ttf_clock *clock, const char *path, const uint8_t *piece,
                       int64_t bytes)
{
    struct ttf_io *io = ttf_io_posix();
    int64_t begun = ttf_clock_now_ns(clock);
    int file = io->ops->open(io, path, TTF_IO_CREATE_NEW), r = file < 0 ? file : 0;

    for (int64_t n = 0; r == 0 && n < bytes; n += PIECE)
        r = ttf_io_append_all(io, file, piece, PIECE);
    if (r == 0)
        r = io->ops->sync(io, file, true);
    if (file >= 0)
        (void)io->ops->close(io, file);
    return r < 0 ? r : say_rate(bytes, ttf_clock_now_ns(clock) - begun);
}

static int run(int argc, char **argv, struct ttf_clock *clock)
{
    static uint8_t piece[PIECE];
    const char *what = argc > 1 ? argv[1] : "";
    int64_t number = argc > 2 ? strtoll(argv[argc - 1], NULL, 10) : 0;

    memset(piece, 0x5a, sizeof piece);
    if (argc == 3 && strcmp(what, "source") == 0)
        return rig_usb_source(argv[2]);
    if (argc == 3 && strcmp(what, "drain") == 0)
        return drain(clock, number);
    if ((argc == 4 || argc == 5) && strcmp(what, "body") == 0)
        return body(clock, argv[2], argv[3], argc == 5);
    if (argc == 3 && strcmp(what, "status") == 0)
        return status(clock, argv[2]);
    if (argc == 3 && strcmp(what, "sha256") == 0)
        return hash_alone(clock, piece, number);
    if (argc == 4 && strcmp(what, "write") == 0)
        return write_alone(clock, argv[2], piece, number);
    return -EINVAL;
}

int main(int argc, char **argv)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    int r = clock ? run(argc, argv, clock) : -ENOSYS;

    ttf_clock_destroy(clock);
    if (r < 0)
        (void)fprintf(stderr, "rig_usb: %s\n", strerrordesc_np(-r));
    return r < 0;
}
