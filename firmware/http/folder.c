/* SPDX-License-Identifier: Apache-2.0 */
#include "folder.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/copy.h"

#define LOOK_BYTES 65536

int folder_open(const char *path, struct folder *ret, struct ttf_err *err)
{
    char *real = realpath(path, NULL);

    *ret = (struct folder){.fd = -1};
    if (!real)
        return ttf_err_set(err, -errno, path, "there is no such folder");
    (void)snprintf(ret->path, sizeof ret->path, "%s", real);
    free(real);
    ret->fd = open(ret->path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (ret->fd < 0)
        return ttf_err_set(err, -errno, path, "cannot be opened as a folder");
    return 0;
}

void folder_close(struct folder *folder)
{
    if (folder->fd >= 0)
        (void)close(folder->fd);
    folder->fd = -1;
}

bool folder_is_name(const char *name)
{
    return name[0] != '.' && ttf_name_ok(name);
}

bool folder_is_path(const char *path)
{
    return path[0] != '.' && !strstr(path, "/.") && ttf_path_ok(path);
}

/*
 * Beneath a folder, whatever the names are made of: one by one, and none may be a link, so none leads out. (openat2 would do it
 * in one call, and a service with RestrictSUIDSGID= may not call it.) path: "." or names that are no "." and "..".
 */
static int open_beneath(int folder, const char *path, int flags)
{
    int at = folder;

    while (true) {
        const char *slash = strchr(path, '/');
        size_t n = slash ? (size_t)(slash - path) : strlen(path);
        char name[NAME_MAX + 1];
        int next, error;

        if (n > NAME_MAX) {
            errno = ENAMETOOLONG;
            next = -1;
        } else {
            memcpy(name, path, n);
            name[n] = '\0';
            next =
                openat(at, name, (slash ? O_PATH | O_DIRECTORY : flags) | O_NOFOLLOW | O_CLOEXEC);
        }
        error = errno;
        if (at != folder)
            (void)close(at);
        errno = error;
        if (next < 0 || !slash)
            return next;
        at = next;
        path = slash + 1;
    }
}

static int open_file(const struct folder *folder, const char *below, const char *dataset,
                     const char *path, struct stat *ret_stat)
{
    char whole[320];
    struct stat st;
    int fd;

    if (!folder_is_name(dataset) || !folder_is_path(path))
        return -ENOENT;
    (void)snprintf(whole, sizeof whole, "%s%s/%s", below, dataset, path);
    /* Not to hang on a pipe that somebody put there. */
    fd = open_beneath(folder->fd, whole, O_RDONLY | O_NONBLOCK | O_NOCTTY);
    if (fd < 0)
        return errno == ELOOP || errno == EXDEV || errno == ENOTDIR || errno == ENXIO ? -ENOENT
                                                                                      : -errno;
    if (fstat(fd, &st) < 0 || !S_ISREG(st.st_mode)) {
        (void)close(fd);
        return -ENOENT;
    }
    if (ret_stat)
        *ret_stat = st;
    return fd;
}

int folder_file(const struct folder *folder, const char *dataset, const char *path,
                struct stat *ret_stat)
{
    return open_file(folder, "", dataset, path, ret_stat);
}

int folder_preview(const struct folder *folder, const char *dataset, const char *path,
                   struct stat *ret_stat)
{
    return open_file(folder, ".preview/", dataset, path, ret_stat);
}

int folder_dataset(const struct folder *folder, const char *dataset, char *ret, size_t size)
{
    int fd = folder_file(folder, dataset, "dataset.json", NULL);

    if (fd < 0)
        return fd;
    (void)close(fd);
    if ((size_t)snprintf(ret, size, "%s/%s", folder->path, dataset) >= size)
        return -ENAMETOOLONG;
    return 0;
}

const struct dirent *folder_next(DIR *dir, int *ret_r)
{
    const struct dirent *entry;

    errno = 0;
    entry = readdir(dir); /* NOLINT(concurrency-mt-unsafe): a stream of its own */
    *ret_r = entry ? 0 : -errno;
    return entry;
}

static int by_bytes(const void *a, const void *b)
{
    return strcmp(a, b);
}

int64_t folder_list(const struct folder *folder, char (**ret)[65])
{
    int fd = open_beneath(folder->fd, ".", O_RDONLY | O_DIRECTORY);
    DIR *dir = fd < 0 ? NULL : fdopendir(fd);
    char(*names)[65] = NULL;
    size_t n = 0, room = 0;
    const struct dirent *entry;
    int r = 0;

    if (!dir) {
        r = -errno;
        if (fd >= 0)
            (void)close(fd);
        return r;
    }
    while ((entry = folder_next(dir, &r))) {
        int file = folder_file(folder, entry->d_name, "dataset.json", NULL);

        if (file == -ENOENT || file == -EACCES) /* none, or in a folder that is not for us to see */
            continue;
        if (file == -EMFILE || file == -ENFILE || file == -ENOMEM) {
            r = file; /* of this machine: nothing is known of any */
            break;
        }
        if (file >= 0)
            (void)close(file);
        if (n == room) {
            char(*more)[65] = realloc(names, (room ? 2 * room : 16) * sizeof *names);

            if (!more) {
                r = -ENOMEM;
                break;
            }
            names = more;
            room = room ? 2 * room : 16;
        }
        (void)snprintf(names[n++], sizeof *names, "%.64s", entry->d_name);
    }
    (void)closedir(dir);
    if (r < 0) {
        free(names);
        return r;
    }
    if (n > 1)
        qsort(names, n, sizeof *names, by_bytes);
    *ret = names;
    return (int64_t)n;
}

bool folder_grows(const char *path, bool sealed)
{
    return strcmp(path, "notes.jsonl") == 0 ||
           (!sealed && (strcmp(path, "records.jsonl") == 0 || strcmp(path, "events.jsonl") == 0));
}

int64_t folder_whole_lines(int fd, int64_t bytes)
{
    char *look = malloc(LOOK_BYTES);
    int64_t end = bytes;

    if (!look)
        return -ENOMEM;
    while (end > 0) {
        int64_t first = end > LOOK_BYTES ? end - LOOK_BYTES : 0;
        ssize_t got = pread(fd, look, (size_t)(end - first), first);
        const char *lf;

        if (got < 0) {
            int r = -errno;

            free(look);
            return r;
        }
        lf = memrchr(look, '\n', (size_t)got);
        if (lf) {
            end = first + (lf - look) + 1;
            break;
        }
        end = first;
    }
    free(look);
    return end;
}
