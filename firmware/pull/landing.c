/* SPDX-License-Identifier: Apache-2.0 */
#include "landing.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "anew.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/hash.h"

#define PATH_SIZE 4600

/* A file that is coming. */
struct coming {
    struct ttf_io *io;
    int file;
    int64_t bytes;         /* there */
    unsigned char *memory; /* where they are, instead of in file; NULL: they are not */
    int64_t expected;      /* -1: not known */
    struct ttf_sha256 hash;
    int ours; /* what failed here, not on the wire; 0 */
};

static void place(const struct landing *landing, const char *path, const char *end,
                  char ret[PATH_SIZE])
{
    (void)snprintf(ret, PATH_SIZE, "%s/%s%s", landing->folder, path, end);
}

static int make_folder(struct landing *landing, const char *path, struct ttf_err *err)
{
    const char *slash = strrchr(path, '/');
    char whole[PATH_SIZE];
    int r;

    if (!slash)
        return 0;
    (void)snprintf(whole, sizeof whole, "%s/%.*s", landing->folder, (int)(slash - path), path);
    if (strcmp(landing->made, whole) == 0)
        return 0;
    r = ttf_io_mkdirs(landing->io, whole, err);
    if (r == 0)
        (void)snprintf(landing->made, sizeof landing->made, "%s", whole);
    return r;
}

/* ---- from the wire ---- */

static int on_begin(void *ctx, int64_t first)
{
    struct coming *c = ctx;
    int r = 0;

    if (first == c->bytes)
        return 0;
    /* The whole, although a part was asked for: it is another entity, or the server knows no parts. */
    if (!c->memory)
        r = c->ours = c->io->ops->truncate(c->io, c->file, 0);
    c->bytes = 0;
    ttf_sha256_init(&c->hash);
    return first == 0 ? r : -EIO;
}

static int on_take(void *ctx, const void *data, size_t n)
{
    struct coming *c = ctx;

    if (c->expected >= 0 && (int64_t)n > c->expected - c->bytes)
        return -TTF_EDAMAGED; /* longer than recorded */
    ttf_sha256_add(&c->hash, data, n);
    if (c->memory)
        memcpy(c->memory + c->bytes, data, n);
    else
        c->ours = ttf_io_pwrite_all(c->io, c->file, data, n, c->bytes);
    c->bytes += (int64_t)n;
    return c->ours;
}

/* What an earlier pull left of it: hashed, so that the rest can be added. */
static int take_up(struct coming *c)
{
    unsigned char piece[16384];
    int64_t bytes, at = 0;
    int r = c->io->ops->size(c->io, c->file, &bytes);

    if (r < 0)
        return r;
    if (c->expected >= 0 && bytes > c->expected)
        return c->io->ops->truncate(c->io, c->file, 0);
    while (at < bytes) {
        int64_t got = ttf_io_pread_all(c->io, c->file, piece, sizeof piece, at);

        if (got <= 0)
            return got < 0 ? (int)got : -EIO;
        ttf_sha256_add(&c->hash, piece, (size_t)got);
        at += got;
    }
    c->bytes = at;
    return 0;
}

static int fetch(struct landing *landing, struct coming *c, const char *path, const char *sha256,
                 struct ttf_err *err)
{
    const struct wire_sink sink = {on_begin, on_take, c};
    char url[300];
    int r;

    if (c->bytes == c->expected && c->bytes > 0)
        return 0; /* all of it came, and then there was no time to give it its name */
    (void)snprintf(url, sizeof url, "/datasets/%s/files/%s", landing->name, path);
    r = pull_wire_get(landing->wire, url, c->bytes, -1, sha256, &sink, err);
    if (r == -ERANGE)
        r = -TTF_EDAMAGED; /* shorter than what was here: begun anew by the caller */
    return r;
}

/* Of this machine's disk. */
static int own(struct landed *ret, int r, const char *place, const char *what, struct ttf_err *err)
{
    ret->ours = true;
    return ttf_err_set(err, r, place, "%s: %s", what, strerrordesc_np(-r));
}

/* Once: -TTF_EDAMAGED if what came is not it; the temporary file is gone then. */
static int try_once(struct landing *landing, const char *path, int64_t bytes, const char *sha256,
                    enum landing_trust trust, struct landed *ret, struct ttf_err *err)
{
    struct ttf_io *io = landing->io;
    struct coming c = {.io = io, .expected = bytes};
    char temporary[PATH_SIZE], final[PATH_SIZE], hex[65];
    bool is_new;
    int r, closed;

    place(landing, path, ".tmp", temporary);
    place(landing, path, "", final);
    if (landing->doubtful)
        (void)io->ops->unlink(io, temporary);
    c.file = io->ops->open(io, temporary, TTF_IO_CREATE_NEW);
    is_new = c.file >= 0;
    if (c.file == -EEXIST)
        c.file = io->ops->open(io, temporary, TTF_IO_APPEND);
    if (c.file < 0)
        return own(ret, c.file, temporary, "cannot be made", err);
    ttf_sha256_init(&c.hash);
    r = c.ours = is_new ? 0 : take_up(&c);
    if (r == 0)
        r = fetch(landing, &c, path, sha256, err);
    if (c.ours < 0)
        r = own(ret, c.ours, temporary, "cannot be written or read", err);
    /* Of these the name alone is believed later: nothing may be behind it that is not on the disk. */
    if (r == 0 && trust == LANDING_SIZE) {
        r = io->ops->sync(io, c.file, true);
        if (r < 0)
            r = own(ret, r, temporary, "cannot be synced", err);
    }
    closed = io->ops->close(io, c.file);
    if (r == 0 && closed < 0)
        r = own(ret, closed, temporary, "cannot be closed", err);
    ttf_sha256_hex(&c.hash, hex);
    if (r == 0 && (strcmp(hex, sha256) != 0 || (bytes >= 0 && c.bytes != bytes)))
        r = -TTF_EDAMAGED;
    if (r == -TTF_EDAMAGED) {
        (void)io->ops->unlink(io, temporary);
        ttf_err_set(err, r, path, "is on the box not what the box recorded");
    }
    if (r < 0)
        return r;
    r = io->ops->rename(io, temporary, final);
    return r == 0 ? 0 : own(ret, r, final, "cannot be put in place", err);
}

/* ---- small files, written when they are known to be right ---- */

static bool has_small(struct landing *landing)
{
    if (!landing->small)
        landing->small = malloc((size_t)LANDING_SMALL);
    return landing->small != NULL;
}

/* A new file of these bytes. *ret: of what failed. */
static int write_new(struct landing *landing, const char *place, const struct coming *c,
                     struct landed *ret, struct ttf_err *err)
{
    struct ttf_io *io = landing->io;
    int file = io->ops->open(io, place, TTF_IO_CREATE_NEW), r, closed;

    if (file < 0)
        return own(ret, file, place, "cannot be made", err);
    r = ttf_io_pwrite_all(io, file, c->memory, (size_t)c->bytes, 0);
    closed = io->ops->close(io, file);
    if (r == 0)
        r = closed;
    if (r == 0)
        return 0;
    (void)io->ops->unlink(io, place);
    return own(ret, r, place, "cannot be written", err);
}

/* As try_once, without its temporary file and the renaming of it, which take longer than a small file's bytes. */
static int try_small(struct landing *landing, const char *path, int64_t bytes, const char *sha256,
                     struct landed *ret, struct ttf_err *err)
{
    struct coming c = {.io = landing->io, .file = -1, .expected = bytes, .memory = landing->small};
    char final[PATH_SIZE], temporary[PATH_SIZE], hex[65];
    int r;

    place(landing, path, "", final);
    place(landing, path, ".tmp", temporary);
    ttf_sha256_init(&c.hash);
    r = fetch(landing, &c, path, sha256, err);
    if (r < 0 && r != -TTF_EDAMAGED) { /* gone on with the next time */
        struct landed unsaid;

        if (c.bytes > 0)
            (void)write_new(landing, temporary, &c, &unsaid, NULL);
        return r;
    }
    ttf_sha256_hex(&c.hash, hex);
    if (r == 0 && (strcmp(hex, sha256) != 0 || c.bytes != bytes))
        r = -TTF_EDAMAGED; /* asked for once more, and said then */
    return r < 0 ? r : write_new(landing, final, &c, ret, err);
}

/* ---- what is there ---- */

int landing_has(const struct landing *landing, const char *path, int64_t bytes, struct ttf_err *err)
{
    char final[PATH_SIZE];
    struct ttf_io_stat st;
    int r;

    place(landing, path, "", final);
    r = landing->io->ops->stat(landing->io, final, &st);
    if (r == -ENOENT)
        return 0;
    if (r < 0)
        return ttf_err_set(err, r, path, "cannot be looked at: %s", strerrordesc_np(-r));
    return st.is_regular && (bytes < 0 || st.bytes == bytes);
}

/* 1: it is what it should be; 0: it is not there, or something else. */
static int is_there(struct landing *landing, const char *path, int64_t bytes, const char *sha256,
                    enum landing_trust trust, struct ttf_err *err)
{
    char final[PATH_SIZE], hex[65];
    int64_t got;
    int r = trust == LANDING_NEW ? 0 : landing_has(landing, path, bytes, err);

    if (r <= 0 || trust == LANDING_SIZE)
        return r;
    place(landing, path, "", final);
    r = landing->doubtful ? anew_write(landing->io, final, false, hex, err)
                          : ttf_sha256_file(landing->io, final, &got, hex, err);
    return r < 0 ? r : strcmp(hex, sha256) == 0;
}

bool landing_is_listed(const char *path)
{
    return path[0] != '.' && !strstr(path, "/.") && !strstr(path, ".tmp/") &&
           strncmp(path, "preview/", 8) != 0 && ttf_is_sealed_file(path);
}

bool landing_is_image(const char *path)
{
    static const char *const FOLDERS[] = {"frames/", "raw/", "plans/", "calibration/"};

    for (unsigned i = 0; i < sizeof FOLDERS / sizeof *FOLDERS; i++)
        if (strncmp(path, FOLDERS[i], strlen(FOLDERS[i])) == 0)
            return landing_is_listed(path);
    return false;
}

static int come(struct landing *landing, const char *path, int64_t bytes, const char *sha256,
                enum landing_trust trust, struct landed *ret, struct ttf_err *err)
{
    int r = make_folder(landing, path, err);

    ret->ours = r < 0;
    if (r == 0 && trust == LANDING_NEW && bytes > 0 && bytes <= LANDING_SMALL && has_small(landing))
        r = try_small(landing, path, bytes, sha256, ret, err);
    else if (r == 0)
        r = try_once(landing, path, bytes, sha256, trust, ret, err);
    if (r == -TTF_EDAMAGED) { /* the wire, or a temporary file of another time */
        memset(err, 0, sizeof *err);
        r = try_once(landing, path, bytes, sha256, trust, ret, err);
    }
    return r;
}

int landing_ensure(struct landing *landing, const char *path, int64_t bytes, const char *sha256,
                   enum landing_trust trust, struct landed *ret, struct ttf_err *err)
{
    int r = is_there(landing, path, bytes, sha256, trust, err);

    *ret = (struct landed){.ours = r < 0};
    if (r < 0)
        return r;
    /* What an earlier try brought and did not settle is settled with the rest. */
    ret->unsettled = r == 0 || trust != LANDING_SIZE;
    if (r > 0)
        return 0;
    r = come(landing, path, bytes, sha256, trust, ret, err);
    if (r == -EEXIST && trust == LANDING_NEW) { /* named twice */
        memset(err, 0, sizeof *err);
        return landing_ensure(landing, path, bytes, sha256, LANDING_HASH, ret, err);
    }
    ret->came = r == 0;
    return r;
}

void landing_free(struct landing *landing)
{
    free(landing->small);
    landing->small = NULL;
}

int landing_put(struct landing *landing, const char *path, const void *data, size_t n,
                struct ttf_err *err)
{
    char final[PATH_SIZE];
    int r = make_folder(landing, path, err);

    place(landing, path, "", final);
    return r < 0 ? r : ttf_io_write_file(landing->io, final, data, n, err);
}
