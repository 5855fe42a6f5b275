/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's file system as an I/O table. Handles are file descriptors. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <sys/statvfs.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "ttf/base/time.h"
#include "ttf/dataset/io.h"

#define F2FS 0xF2F52010ul /* struct statfs, f_type */

/* A signal is no failure: whatever it interrupted before anything happened is done again. */
#define RETRY(ret, call) \
    do {                 \
        (ret) = (call);  \
    } while ((ret) < 0 && errno == EINTR)

static int px_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    int flags = O_CLOEXEC | O_NOCTTY;
    int fd;

    switch (mode) {
    case TTF_IO_READ:
        flags |= O_RDONLY | O_NONBLOCK; /* a pipe that lies in a file's place holds nobody up */
        break;
    case TTF_IO_CREATE_NEW:
        flags |= O_RDWR | O_CREAT | O_EXCL;
        break;
    case TTF_IO_APPEND:
        flags |= O_RDWR | O_CREAT | O_APPEND;
        break;
    default:
        return -EINVAL;
    }
    RETRY(fd, open(path, flags, 0666));
    return fd < 0 ? -errno : fd;
}

static int64_t px_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    ssize_t got;

    RETRY(got, pread(file, buf, n, offset));
    return got < 0 ? -errno : got;
}

static int64_t px_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    ssize_t put;

    RETRY(put, pwrite(file, buf, n, offset));
    return put < 0 ? -errno : put;
}

static int64_t px_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    ssize_t put;

    /* A file of CREATE_NEW has no O_APPEND: go to its end first. */
    if (lseek(file, 0, SEEK_END) < 0)
        return -errno;
    RETRY(put, write(file, buf, n));
    return put < 0 ? -errno : put;
}

static int px_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    struct stat st;

    if (fstat(file, &st) < 0)
        return -errno;
    *ret_bytes = st.st_size;
    return 0;
}

static int px_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    int r;

    RETRY(r, ftruncate(file, bytes));
    return r < 0 ? -errno : 0;
}

static int px_reserve(struct ttf_io *io, int file, int64_t offset, int64_t n)
{
    int r;

    RETRY(r, fallocate(file, 0, offset, n));
    return r < 0 ? -errno : 0;
}

static bool lies_on_f2fs(int file)
{
    struct statfs fs;

    return fstatfs(file, &fs) == 0 && (unsigned long)fs.f_type == F2FS;
}

static int px_sync(struct ttf_io *io, int file, bool data_only)
{
    /* Not retried, EINTR included: a sync that did not succeed is final (DESIGN.md). */
    if ((data_only ? fdatasync(file) : fsync(file)) < 0)
        return -errno;
    /* There the first sync after a checkpoint does not wait for the block that has the file's length; a checkpoint does (DESIGN.md). */
    if (lies_on_f2fs(file) && syncfs(file) < 0)
        return -errno;
    return 0;
}

static int px_close(struct ttf_io *io, int file)
{
    /* On Linux the descriptor is gone even after EINTR. */
    if (close(file) < 0 && errno != EINTR)
        return -errno;
    return 0;
}

static int px_rename(struct ttf_io *io, const char *from, const char *to)
{
    return rename(from, to) < 0 ? -errno : 0;
}

static int px_unlink(struct ttf_io *io, const char *path)
{
    struct stat st;

    /* One op for files and for empty folders. */
    if (lstat(path, &st) < 0)
        return -errno;
    if (S_ISDIR(st.st_mode))
        return rmdir(path) < 0 ? -errno : 0;
    return unlink(path) < 0 ? -errno : 0;
}

static int px_mkdir(struct ttf_io *io, const char *path)
{
    return mkdir(path, 0777) < 0 ? -errno : 0;
}

static int px_sync_dir(struct ttf_io *io, const char *path)
{
    int fd, ret = 0;

    RETRY(fd, open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd < 0)
        return -errno;
    /* EINVAL: this file system has no such operation; there is nothing more that could be done. */
    if (fsync(fd) < 0 && errno != EINVAL)
        ret = -errno;
    close(fd);
    return ret;
}

static int px_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    struct stat st;

    if (stat(path, &st) < 0)
        return -errno;
    ret->is_dir = S_ISDIR(st.st_mode);
    ret->is_regular = S_ISREG(st.st_mode);
    ret->mtime_ns = (int64_t)st.st_mtim.tv_sec * TTF_NS_PER_S + st.st_mtim.tv_nsec;
    ret->bytes = st.st_size;
    ret->device = st.st_dev;
    ret->inode = st.st_ino;
    return 0;
}

static bool entry_is_dir(DIR *dir, const struct dirent *entry)
{
    struct stat st;

    if (entry->d_type != DT_UNKNOWN && entry->d_type != DT_LNK)
        return entry->d_type == DT_DIR;
    return fstatat(dirfd(dir), entry->d_name, &st, 0) == 0 && S_ISDIR(st.st_mode);
}

static int px_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    struct dirent *entry;
    DIR *dir;
    int ret = 0;

    dir = opendir(path);
    if (!dir)
        return -errno;
    for (;;) {
        errno = 0;
        entry = readdir(dir); /* NOLINT(concurrency-mt-unsafe): no other thread has this DIR */
        if (!entry) {
            ret = -errno;
            break;
        }
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
            continue;
        ret = fn(ctx, entry->d_name, entry_is_dir(dir, entry));
        if (ret)
            break;
    }
    closedir(dir);
    return ret;
}

static int px_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    struct statvfs vfs;
    struct stat st;
    int r;

    RETRY(r, statvfs(path, &vfs));
    if (r < 0)
        return -errno;
    ret->free_bytes = (int64_t)vfs.f_bavail * (int64_t)vfs.f_frsize;
    ret->total_bytes = (int64_t)vfs.f_blocks * (int64_t)vfs.f_frsize;
    ret->read_only = (vfs.f_flag & ST_RDONLY) != 0;
    ret->fs_errors = stat(path, &st) == 0 ? ttf_io_fs_errors("/sys", st.st_dev) : 0;
    return 0;
}

static int px_lock(struct ttf_io *io, int file)
{
    int r;

    RETRY(r, flock(file, LOCK_EX | LOCK_NB));
    return r < 0 ? -errno : 0;
}

/*
 * Linux tells of failed write-back by syncfs since 5.8. Of these file systems it is known to be so, and that they bring over everything;
 * what comes over a network or from a program (FUSE) may have been handed on, and no more.
 */
static bool tells_of_all(int file)
{
    static const unsigned long KNOWN[] = {0xEF53 /* ext2, 3, 4 */, 0x58465342 /* XFS */,
                                          0x9123683E /* btrfs */, F2FS,
                                          0x01021994 /* tmpfs: on no disk */};
    unsigned long major, minor = 0;
    struct utsname kernel;
    struct statfs fs;
    char *end;

    if (uname(&kernel) < 0 || fstatfs(file, &fs) < 0)
        return false;
    major = strtoul(kernel.release, &end, 10);
    if (*end == '.')
        minor = strtoul(end + 1, NULL, 10);
    if (major < 5 || (major == 5 && minor < 8))
        return false;
    for (unsigned i = 0; i < sizeof KNOWN / sizeof *KNOWN; i++)
        if ((unsigned long)fs.f_type == KNOWN[i])
            return true;
    return false;
}

static int px_sync_all(struct ttf_io *io, int file)
{
    if (!tells_of_all(file))
        return -EOPNOTSUPP;
    return syncfs(file) < 0 ? -errno : 0;
}

static int px_inherit(struct ttf_io *io, int file, const char *path)
{
    struct stat st;

    if (lstat(path, &st) < 0)
        return errno == ENOENT ? 0 : -errno;
    if (S_ISLNK(st.st_mode))
        return -ELOOP;
    /* The owner first: giving a file away may take bits of its mode. Only root may; anybody may give it a group that he is of. */
    if (fchown(file, st.st_uid, st.st_gid) < 0)
        (void)!fchown(file, (uid_t)-1, st.st_gid);
    (void)!fchmod(file, st.st_mode & 0777); /* FAT has no modes */
    return 0;
}

static const struct ttf_io_ops posix_ops = {
    .name = "posix",
    .open = px_open,
    .pread = px_pread,
    .pwrite = px_pwrite,
    .append = px_append,
    .size = px_size,
    .truncate = px_truncate,
    .sync = px_sync,
    .close = px_close,
    .rename = px_rename,
    .unlink = px_unlink,
    .mkdir = px_mkdir,
    .sync_dir = px_sync_dir,
    .stat = px_stat,
    .list = px_list,
    .space = px_space,
    .lock = px_lock,
    .sync_all = px_sync_all,
    .inherit = px_inherit,
    .reserve = px_reserve,
};

struct ttf_io *ttf_io_posix(void)
{
    /* Never written to: the table has no state of its own. */
    static const struct ttf_io posix_io = {.ops = &posix_ops};

    return (struct ttf_io *)&posix_io;
}
