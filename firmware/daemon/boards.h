/* SPDX-License-Identifier: Apache-2.0 */
/*
 * boards.h: boards that this box knows: its own, those that came with it, with their plans, and those that somebody sent. One that is sent
 * lies in the folder `boards` of the state's, as NAME.yaml, and is kept, no more: which board the box is, its configuration says alone. It hides
 * none that was there before, is never written over, and is not taken away while the configuration names it. Any thread.
 */
#ifndef DAEMON_BOARDS_H
#define DAEMON_BOARDS_H

#include "parts.h"

/* As JSON (openapi.yaml); by malloc. */
TTF_MUST_USE int boards_list(struct daemon *d, char **ret_json, struct ttf_err *err);

/* A board's description, or with a name that of one of its plans; by malloc. -ENOENT. */
TTF_MUST_USE int boards_show(struct daemon *d, const char *name, const char *plan, char **ret_yaml,
                             struct ttf_err *err);

/* What was found in it, as check_board has it. -EINVAL: it is none, or calls itself otherwise; -EPERM: it is the box's own, or came with it; -EEXIST; errors of the disk. */
TTF_MUST_USE int boards_put(struct daemon *d, const char *name, const char *yaml, size_t bytes,
                            char **ret_json, struct ttf_err *err);

/* -EPERM: as above, or the configuration names it; -ENOENT; errors of the disk. */
TTF_MUST_USE int boards_delete(struct daemon *d, const char *name, struct ttf_err *err);

#endif
