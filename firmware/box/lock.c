/* SPDX-License-Identifier: Apache-2.0 */
#include "lock.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* The folder alone, not those above it: /run/ttfbox is a box's, /run the machine's. */
static void make_folder_of(const char *path)
{
    char folder[512];
    const char *slash = strrchr(path, '/');

    if (!slash || slash == path)
        return;
    (void)snprintf(folder, sizeof folder, "%.*s", (int)(slash - path), path);
    (void)mkdir(folder, 0755); /* what is the matter with it shows in opening the file */
}

static void read_owner(int fd, char ret[256])
{
    ssize_t n = pread(fd, ret, 255, 0);

    ret[n > 0 ? n : 0] = '\0';
    ret[strcspn(ret, "\n")] = '\0';
    if (!*ret)
        (void)snprintf(ret, 256, "another program");
}

/* Another user's file can be locked, though not written. */
static int open_lock(const char *path)
{
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);

    return fd < 0 && errno == EACCES ? open(path, O_RDONLY | O_CLOEXEC) : fd;
}

int box_lock_take(const char *path, const char *who, bool make_folder, struct box_lock *ret,
                  struct ttf_err *err)
{
    char owner[256];
    int fd, r;

    ret->fd = -1;
    if (!*path)
        return 0;
    if (make_folder)
        make_folder_of(path);
    fd = open_lock(path);
    if (fd < 0 && errno == ENOENT && !make_folder)
        return 0;
    if (fd < 0) {
        r = -errno;
        ttf_err_set(err, r, path, "the box's lock cannot be had: %s", strerrordesc_np(-r));
        ttf_err_hint(err, "'lock: PATH' of the board names another place");
        return r;
    }
    if (flock(fd, LOCK_EX | LOCK_NB) < 0) {
        r = errno == EWOULDBLOCK ? -EBUSY : -errno;
        read_owner(fd, owner);
        ttf_err_set(err, r, path, "the box is owned by %s", owner);
        ttf_err_hint(err, "one program has a box at a time: stop that one first");
        (void)close(fd);
        return r;
    }
    if (ftruncate(fd, 0) == 0) /* where it cannot be written, the lock alone must do */
        (void)!pwrite(fd, who, strlen(who), 0);
    ret->fd = fd;
    return 0;
}

int box_lock_owner(const char *path, char ret[256])
{
    int fd = *path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    int owned = 0;

    if (fd < 0)
        return 0;
    if (flock(fd, LOCK_SH | LOCK_NB) < 0 && errno == EWOULDBLOCK) {
        read_owner(fd, ret);
        owned = 1;
    }
    (void)close(fd);
    return owned;
}

void box_lock_drop(struct box_lock *lock)
{
    if (lock->fd >= 0)
        (void)close(lock->fd);
    lock->fd = -1;
}
