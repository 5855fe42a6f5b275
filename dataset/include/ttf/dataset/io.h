/* SPDX-License-Identifier: Apache-2.0 */
/*
 * io.h: the table that all file access of a dataset goes through.
 *
 * So that a test can cut power at every operation, and the simulated box can
 * have a full disk. Paths are those of the process; handles are small integers
 * of the table's own. Ops return 0, a count or a handle, or a negative errno.
 * Thread-safe; one file's handle is used by one thread at a time, but for pread and pwrite, which any may call at once.
 */
#ifndef TTF_DATASET_IO_H
#define TTF_DATASET_IO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

enum ttf_io_mode {
    TTF_IO_READ = 0,
    TTF_IO_CREATE_NEW, /* read and write; -EEXIST if it is there */
    TTF_IO_APPEND      /* read and append; created where missing */
};

struct ttf_io_stat {
    bool is_dir;
    bool is_regular;
    int64_t bytes;
    uint64_t device;  /* of the file system it lies on; 0: not known */
    uint64_t inode;   /* its number there: with device, whether two names are of one folder */
    int64_t mtime_ns; /* when it was written last, since 1970; 0: not known */
};

struct ttf_io_space {
    int64_t free_bytes, total_bytes;
    bool read_only;
    /* Which the file system has found in itself since it was last checked (ext2 to 4 count them); 0: none, or it does not count. */
    int64_t fs_errors;
};

/* The same of the file system on this device (st_dev). sys: "/sys", or a folder laid out like it. */
int64_t ttf_io_fs_errors(const char *sys, uint64_t device);

struct ttf_io;

/* Called for each entry of a folder, in no order; return non-zero to stop. */
typedef int ttf_io_entry_fn(void *ctx, const char *name, bool is_dir);

/* All mandatory, but those that may be NULL. */
struct ttf_io_ops {
    const char *name;
    int (*open)(struct ttf_io *io, const char *path, enum ttf_io_mode mode);
    int64_t (*pread)(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset);
    int64_t (*pwrite)(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset);
    int64_t (*append)(struct ttf_io *io, int file, const void *buf, size_t n);
    int (*size)(struct ttf_io *io, int file, int64_t *ret_bytes);
    int (*truncate)(struct ttf_io *io, int file, int64_t bytes);
    int (*sync)(struct ttf_io *io, int file, bool data_only);
    int (*close)(struct ttf_io *io, int file);
    int (*rename)(struct ttf_io *io, const char *from, const char *to);
    int (*unlink)(struct ttf_io *io, const char *path);
    int (*mkdir)(struct ttf_io *io, const char *path);
    int (*sync_dir)(struct ttf_io *io, const char *path);
    int (*stat)(struct ttf_io *io, const char *path, struct ttf_io_stat *ret);
    int (*list)(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx);
    int (*space)(struct ttf_io *io, const char *path, struct ttf_io_space *ret);
    int (*lock)(struct ttf_io *io, int file);     /* exclusive, not blocking: -EAGAIN */
    int (*sync_all)(struct ttf_io *io, int file); /* ttf_io_sync_all; NULL: there is none */
    int (*inherit)(struct ttf_io *io, int file, const char *path); /* NULL: files have no owners */
    int (*reserve)(struct ttf_io *io, int file, int64_t offset,
                   int64_t n); /* ttf_io_reserve; NULL: there is none */
};

struct ttf_io {
    const struct ttf_io_ops *ops;
};

/* The machine's file system. Never freed. */
struct ttf_io *ttf_io_posix(void);

/* What the faulty twin asks before each operation that changes something: 0, or the errno to fail with. */
typedef int ttf_io_fault_fn(void *ctx, const char *op, const char *path);

/* A twin of `base` that fails when told to. base must outlive it. NULL: no memory. */
struct ttf_io *ttf_io_faulty_create(struct ttf_io *base, ttf_io_fault_fn *fault, void *ctx);
void ttf_io_faulty_destroy(struct ttf_io *io);

/* Asked, with the same ctx, what to make of the room that `base` says there is. */
typedef void ttf_io_space_fn(void *ctx, const char *path, struct ttf_io_space *space);
void ttf_io_faulty_space(struct ttf_io *io, ttf_io_space_fn *space);

/* ---- whole operations on top of the table ---- */

/*
 * All that was written so far to the file system that `file` (a folder's handle, too) lies on is on the disk: bytes, names, folders. It waits for
 * what others wrote there, too. Any error of writing back since the handle was opened, whosever file it was, is this call's, once.
 * -EOPNOTSUPP: there is none here that would tell of such errors; each file is to be synced by itself.
 */
TTF_MUST_USE int ttf_io_sync_all(struct ttf_io *io, int file);

/*
 * The file is to take the place of what lies at path: it gets its mode, and its owner and group, as far as may be. Nothing if there is none.
 * -ELOOP: a link lies there.
 */
TTF_MUST_USE int ttf_io_inherit(struct ttf_io *io, int file, const char *path);

/*
 * Room for bytes offset .. offset+n-1 is the file's own; it is as long as that at least, zeros where nothing was written. -EOPNOTSUPP: not on
 * this file system, whatever it says of it; nothing is lost by that. -ENOSPC, -EDQUOT, -EFBIG, -EIO: known before anything is written.
 * -EINVAL: no such bytes.
 */
TTF_MUST_USE int ttf_io_reserve(struct ttf_io *io, int file, int64_t offset, int64_t n);

/* Writes or appends all of it, going on after short counts and EINTR. 0 or a negative errno. */
TTF_MUST_USE int ttf_io_pwrite_all(struct ttf_io *io, int file, const void *buf, size_t n,
                                   int64_t offset);
TTF_MUST_USE int ttf_io_append_all(struct ttf_io *io, int file, const void *buf, size_t n);

/* Reads n bytes or up to the end; returns how many. */
TTF_MUST_USE int64_t ttf_io_pread_all(struct ttf_io *io, int file, void *buf, size_t n,
                                      int64_t offset);

/* The whole file, zero-terminated, to be freed with free(); -EFBIG beyond max_bytes. */
TTF_MUST_USE int ttf_io_slurp(struct ttf_io *io, const char *path, size_t max_bytes,
                              char **ret_text, size_t *ret_bytes, struct ttf_err *err);

/* Temporary name, sync, rename, sync of the folder: all or nothing. Replaces what was there. */
TTF_MUST_USE int ttf_io_write_file(struct ttf_io *io, const char *path, const void *data, size_t n,
                                   struct ttf_err *err);

/* Makes a folder and those above it, each synced. */
TTF_MUST_USE int ttf_io_mkdirs(struct ttf_io *io, const char *path, struct ttf_err *err);

/*
 * Removes a file, or a folder with all that lies below it; a link itself, and nothing that it leads to. Allocates nothing. 0, or the first
 * error: what could not be removed stays, with the folders above it.
 */
int ttf_io_remove_tree(struct ttf_io *io, const char *path);

#endif
