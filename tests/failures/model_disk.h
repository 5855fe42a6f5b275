/* SPDX-License-Identifier: Apache-2.0 */
/*
 * model_disk.h: a disk in memory that keeps no more than it promised.
 *
 * What programs see is the page cache; what is on the disk is kept beside it. A sync brings over the
 * bytes written since the last one; a folder's sync brings over its names. A sync that FAILS drops
 * them: they are still to be seen, are clean, and no later sync brings them over unless they are
 * written again (so with Linux after a failed write-back); but a folder's own name stays to be brought
 * over: it could only be made again with all that is in it. A sync of all does the same with all that there is. Losing power leaves what was
 * brought over.
 *
 * One operation can be made to fail, by its number; every operation of the table counts.
 * Thread-safe. Its own memory is nobody's business: it pauses the allocation hook.
 */
#ifndef TTF_TESTS_MODEL_DISK_H
#define TTF_TESTS_MODEL_DISK_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/dataset/io.h"

enum model_op {
    OP_OPEN,
    OP_PREAD,
    OP_PWRITE,
    OP_APPEND,
    OP_SIZE,
    OP_TRUNCATE,
    OP_SYNC,
    OP_CLOSE,
    OP_RENAME,
    OP_UNLINK,
    OP_MKDIR,
    OP_SYNC_DIR,
    OP_STAT,
    OP_LIST,
    OP_SPACE,
    OP_LOCK,
    OP_SYNC_ALL,
    OP_COUNT
};

const char *model_op_name(enum model_op op);

enum model_how {
    FAIL_BEFORE,     /* it fails and has done nothing */
    FAIL_AFTER,      /* it fails and has been done all the same (an answer that was lost) */
    SHORT_ONCE,      /* it moves fewer bytes than asked for */
    SHORT_TWICE,     /* and the next of its kind, too */
    SHORT_THEN_ERROR /* and the next of its kind fails */
};

struct model_fault {
    long at;    /* the number of the operation, from 1; 0: none */
    bool of_op; /* at counts operations of this kind alone */
    enum model_op op;
    long lasts; /* how many operations on end; LONG_MAX: the storage is gone */
    int error;  /* positive errno */
    enum model_how how;
};

/* One operation, as it came. */
struct model_call {
    enum model_op op;
    bool changes; /* something on the disk; of open: unless it is for reading */
    size_t n;     /* bytes asked for, of pread, pwrite, append */
    char path[200];
};

struct model_inode {
    bool is_dir, locked;
    bool hollow; /* has a length and reads as zeros: noise that nobody reads */
    unsigned char *seen, *kept, *dirty; /* room bytes each */
    size_t room, seen_bytes, kept_bytes;
    bool size_dirty;
};

struct model_name {
    char path[200];
    int seen, kept; /* inodes; -1: not there */
    bool dirty;
};

struct model_handle {
    bool used, locks;
    int inode;
    int name;
};

struct model_disk {
    struct ttf_io io; /* first */
    pthread_mutex_t mutex;
    struct model_inode *inodes;
    int n_inodes;
    struct model_name *names;
    int n_names;
    struct model_handle handles[64];
    struct model_fault fault;
    int64_t capacity_bytes; /* of all files that are seen; 0: endless. More is ENOSPC */
    uint64_t device;        /* as stat says it; 0: not known */
    long n;                 /* operations so far */
    long n_of_op, from; /* of fault.of_op: so many came; the number of the one that was meant, 0 */
    long n_failed;
    struct model_call failed; /* the first that did */
    enum model_op after_short;
    int short_left;
    struct model_call *log; /* room for log_room, or NULL */
    long log_room;
};

/* Empty but for the folder "/m". */
void model_disk_init(struct model_disk *disk);
void model_disk_free(struct model_disk *disk);

/* Another disk with the same on it, seen and kept. No handles, no fault. */
void model_disk_copy(struct model_disk *to, struct model_disk *from);

/* The power goes and comes back: only what was kept is seen. */
void model_disk_lose_power(struct model_disk *disk);

/* What lies in a folder of this machine, under another name and kept; the folder above is there. */
void model_disk_take(struct model_disk *disk, const char *folder, const char *as);

/* From the next operation on, which is number 1. */
void model_disk_fail(struct model_disk *disk, struct model_fault fault);

unsigned model_disk_open_handles(struct model_disk *disk);

/* All handles are closed, locks with them: the process is gone. */
void model_disk_kill(struct model_disk *disk);

/* What all files that are seen take. */
int64_t model_disk_used(const struct model_disk *disk);

/* Whether a file or folder is seen. */
bool model_disk_has(struct model_disk *disk, const char *path);

#endif
