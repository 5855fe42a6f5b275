/* SPDX-License-Identifier: Apache-2.0 */
/*
 * shelf.h: the data folder as it was opened, with what is remembered of it. Another one is opened when its path leads to
 * another folder: a disk that came late, or went and came back. Who has taken one keeps it: what is
 * answered is of one folder. Any thread.
 */
#ifndef HTTP_SHELF_H
#define HTTP_SHELF_H

#include <stdbool.h>
#include <sys/types.h>

#include "derived.h"
#include "folder.h"
#include "summaries.h"

struct shelf {
    struct folder folder;
    struct summaries *summaries;
    struct derived *derived;
    dev_t device; /* with inode, which folder it is */
    ino_t inode;
    unsigned users; /* those who took it, and the shelves while it is the newest */
};

struct shelves;

/* -ENOENT, -ENOTDIR, ...; -ENOMEM. */
TTF_MUST_USE int shelves_create(const char *path, struct shelves **ret, struct ttf_err *err);

/* Nobody has one of them any more. NULL allowed. */
void shelves_destroy(struct shelves *shelves);

/* The folder that the path leads to now; the one of before, where it leads to none or that cannot be opened. Give it back. */
struct shelf *shelves_take(struct shelves *shelves);
void shelves_give(struct shelves *shelves, struct shelf *shelf);

/* Whether the path leads to another folder than this one. */
bool shelves_other(const struct shelves *shelves, const struct shelf *shelf);

#endif
