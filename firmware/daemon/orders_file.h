/* SPDX-License-Identifier: Apache-2.0 */
/* orders_file.h: the file in which what was decided outlives a boot. */
#ifndef DAEMON_ORDERS_FILE_H
#define DAEMON_ORDERS_FILE_H

#include "orders.h"

struct orders_file {
    struct ttf_io *io;
    char folder[512], path[528];
    char configuration[1040]; /* under which is decided now */
};

/* run.json in the folder, under a configuration's plan and the dataset it makes (its path), "" and "": none. io is borrowed. */
void orders_file_name(struct orders_file *ret, struct ttf_io *io, const char *folder,
                      const char *plan, const char *dataset);

/*
 * 1: *ret is what holds, to be freed. 0: it says nothing for this configuration. -ENOENT: there is none. -EINVAL: it cannot be
 * understood, whoever reads it and whenever; else errors of the disk and of memory.
 */
TTF_MUST_USE int orders_file_read(const struct orders_file *file, struct order *ret,
                                  struct ttf_err *err);

/* On a full disk it takes the room of the reserve. */
TTF_MUST_USE int orders_file_write(const struct orders_file *file, const struct order *order,
                                   struct ttf_err *err);

/* Keeps room for the next decision beside it, as run.json.reserve, if it is not there and can be had. */
void orders_file_reserve(const struct orders_file *file);

/* To where it is in nobody's way, for a person to look at: beside it, as run.json.unreadable. */
TTF_MUST_USE int orders_file_put_aside(const struct orders_file *file);

#endif
