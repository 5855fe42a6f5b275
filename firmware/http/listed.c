/* SPDX-License-Identifier: Apache-2.0 */
#include "listed.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "described.h"
#include "ttf/base/time.h"
#include "ttf/dataset/hash.h"

#define KEPT 4
#define LINES_MAX \
    ((size_t)1 << 20) /* of a longer list all is searched for, as if there were no index */
#define PIECE          65536
#define LINE_MAX_BYTES 300 /* hash, blanks, a path, a line end: more is no line of such a list */

struct place {
    uint64_t hash;  /* of the path */
    int64_t offset; /* of its line, plus 1; 0: free */
};

/* A table by hash, at most half full. */
struct list {
    char dataset[65]; /* empty: free */
    uint64_t used, inode;
    int64_t bytes;                /* read so far, to the end of a line */
    int64_t file_bytes, mtime_ns; /* of the file then */
    struct place *place;
    size_t room, n;
    bool too_long;
};

struct listed {
    pthread_mutex_t lock; /* over all below */
    struct list lists[KEPT];
    uint64_t uses;
};

struct listed *listed_create(void)
{
    struct listed *listed = calloc(1, sizeof *listed);

    if (listed && pthread_mutex_init(&listed->lock, NULL) != 0) {
        free(listed);
        return NULL;
    }
    return listed;
}

static void forget(struct list *list)
{
    free(list->place);
    *list = (struct list){0};
}

void listed_destroy(struct listed *listed)
{
    if (!listed)
        return;
    for (unsigned i = 0; i < KEPT; i++)
        forget(&listed->lists[i]);
    (void)pthread_mutex_destroy(&listed->lock);
    free(listed);
}

static struct list *recall(struct listed *listed, const char *dataset)
{
    struct list *oldest = &listed->lists[0];

    for (unsigned i = 0; i < KEPT; i++) {
        struct list *list = &listed->lists[i];

        if (strcmp(list->dataset, dataset) == 0) {
            list->used = ++listed->uses;
            return list;
        }
        if (list->used < oldest->used)
            oldest = list;
    }
    forget(oldest);
    (void)snprintf(oldest->dataset, sizeof oldest->dataset, "%s", dataset);
    oldest->used = ++listed->uses;
    return oldest;
}

/* ---- the table ---- */

static uint64_t hash_of(const char *path, size_t n)
{
    uint64_t hash = 14695981039346656037u; /* FNV-1a */

    for (size_t i = 0; i < n; i++)
        hash = (hash ^ (unsigned char)path[i]) * 1099511628211u;
    return hash;
}

static void put(struct place *place, size_t room, struct place one)
{
    size_t i = (size_t)one.hash & (room - 1);

    while (place[i].offset)
        i = (i + 1) & (room - 1);
    place[i] = one;
}

static int add(struct list *list, uint64_t hash, int64_t offset)
{
    if (2 * (list->n + 1) > list->room) {
        size_t room = list->room ? 2 * list->room : 1024;
        struct place *more = calloc(room, sizeof *more);

        if (!more)
            return -ENOMEM;
        for (size_t i = 0; i < list->room; i++)
            if (list->place[i].offset)
                put(more, room, list->place[i]);
        free(list->place);
        list->place = more;
        list->room = room;
    }
    put(list->place, list->room, (struct place){hash, offset + 1});
    list->n++;
    return 0;
}

/* ---- reading ---- */

/* "HEX  PATH", without its line end. Anything else is passed over. */
static int take_line(struct list *list, const char *line, size_t n, int64_t offset)
{
    if (n <= 66 || n > LINE_MAX_BYTES || line[64] != ' ' || line[65] != ' ')
        return 0;
    if (list->n == LINES_MAX) {
        list->too_long = true;
        return 0;
    }
    return add(list, hash_of(line + 66, n - 66), offset);
}

static int take_piece(struct list *list, const char *piece, size_t n, size_t *ret_taken)
{
    size_t at = 0;
    int r = 0;

    while (r == 0 && at < n) {
        const char *end = memchr(piece + at, '\n', n - at);

        if (!end)
            break;
        r = take_line(list, piece + at, (size_t)(end - piece) - at, list->bytes + (int64_t)at);
        at = (size_t)(end - piece) + 1;
    }
    *ret_taken = at;
    return r;
}

static int read_on(struct list *list, int fd)
{
    char *piece = malloc(PIECE);
    int r = piece ? 0 : -ENOMEM;

    while (r == 0) {
        ssize_t got = pread(fd, piece, PIECE, list->bytes);
        size_t taken = 0;

        if (got <= 0) {
            r = got < 0 ? -errno : 0;
            break;
        }
        r = take_piece(list, piece, (size_t)got, &taken);
        if (taken == 0 && (size_t)got == PIECE)
            taken = PIECE; /* no list has such a line */
        if (r == 0 && taken == 0)
            break; /* a line that is not whole yet */
        list->bytes += (int64_t)taken;
    }
    free(piece);
    return r;
}

/* The list as the file is now. */
static int follow(struct list *list, int fd, const struct stat *st)
{
    int64_t mtime_ns = (int64_t)st->st_mtim.tv_sec * TTF_NS_PER_S + st->st_mtim.tv_nsec;
    char dataset[65];
    uint64_t used = list->used;

    if (list->inode == st->st_ino && list->mtime_ns == mtime_ns && list->file_bytes == st->st_size)
        return 0;
    if (list->inode != st->st_ino || st->st_size <= list->bytes) {
        memcpy(dataset, list->dataset, sizeof dataset);
        forget(list);
        memcpy(list->dataset, dataset, sizeof dataset);
        list->used = used;
    }
    list->inode = st->st_ino;
    list->mtime_ns = mtime_ns;
    list->file_bytes = st->st_size;
    return read_on(list, fd);
}

/* Is it this path's line, as the list has it now? */
static bool is_line(int fd, int64_t offset, const char *path, char ret[65])
{
    char line[LINE_MAX_BYTES + 1];
    size_t n = strlen(path);
    ssize_t got = pread(fd, line, 66 + n + 1, offset);

    if (got != (ssize_t)(66 + n + 1) || line[66 + n] != '\n' || memcmp(line + 66, path, n) != 0 ||
        line[64] != ' ' || line[65] != ' ')
        return false;
    memcpy(ret, line, 64);
    ret[64] = '\0';
    return ttf_sha256_is_hex(ret);
}

static int find(const struct list *list, int fd, const char *path, char ret[65])
{
    uint64_t hash = hash_of(path, strlen(path));
    size_t i;

    if (list->room == 0)
        return -ENODATA;
    for (i = (size_t)hash & (list->room - 1); list->place[i].offset; i = (i + 1) & (list->room - 1))
        if (list->place[i].hash == hash && is_line(fd, list->place[i].offset - 1, path, ret))
            return 0;
    return -ENODATA;
}

int listed_sha256(struct listed *listed, const struct folder *folder, const char *dataset,
                  const char *path, char ret[65])
{
    struct stat st;
    struct list *list;
    bool too_long;
    int fd = folder_file(folder, dataset, "SHA256SUMS", &st);
    int r;

    if (fd < 0)
        return fd == -ENOENT ? -ENODATA : fd;
    if (strlen(path) > LINE_MAX_BYTES - 67) {
        (void)close(fd);
        return -ENODATA;
    }
    (void)pthread_mutex_lock(&listed->lock);
    list = recall(listed, dataset);
    r = follow(list, fd, &st);
    if (r == 0)
        r = find(list, fd, path, ret);
    else
        forget(list);
    too_long = list->too_long;
    (void)pthread_mutex_unlock(&listed->lock);
    (void)close(fd);
    return too_long && r == -ENODATA ? described_sha256(folder, dataset, path, ret) : r;
}

bool listed_sealed(struct listed *listed, const struct folder *folder, const char *dataset)
{
    char hex[65];

    return listed_sha256(listed, folder, dataset, "records.jsonl", hex) == 0;
}
