/* SPDX-License-Identifier: Apache-2.0 */
/* library.h: plans that were put in place. Names are those of files without ".yaml", and checked. Any thread. */
#ifndef DAEMON_LIBRARY_H
#define DAEMON_LIBRARY_H

#include "parts.h"

/* As JSON (openapi.yaml); by malloc. */
TTF_MUST_USE int library_plans(struct daemon *d, char **ret_json, struct ttf_err *err);

/* A plan's text, by malloc. -ENOENT. */
TTF_MUST_USE int library_plan(struct daemon *d, const char *name, char **ret_yaml,
                              struct ttf_err *err);
/* -EPERM: it is the configuration's own; -ENOENT; errors of the disk. */
TTF_MUST_USE int library_put(struct daemon *d, const char *name, const char *yaml, size_t bytes,
                             struct ttf_err *err);
TTF_MUST_USE int library_delete(struct daemon *d, const char *name, struct ttf_err *err);

/*
 * May a run of this plan be started into the dataset of this name? 0: it is new, or it is unsealed and one of its plans is this
 * text. -EEXIST: it is sealed, or of another plan; -EBUSY: it is new, and its start means nothing to this box's clock; errors of reading it. Takes as long as reading its records.
 */
TTF_MUST_USE int library_may_start(struct daemon *d, const char *dataset, const char *yaml,
                                   struct ttf_err *err);

#endif
