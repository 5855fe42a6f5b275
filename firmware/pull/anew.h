/* SPDX-License-Identifier: Apache-2.0 */
/*
 * anew.h: what is here written once more. Behind a sync that failed, and behind a program that was killed before it could clear up, a file can be
 * seen whole and never reach the disk: its pages pass for clean, and the next sync says that all is well. Until the machine starts anew
 * nobody can tell. So a mark lies in the dataset's folder as long as a pull writes there.
 */
#ifndef PULL_ANEW_H
#define PULL_ANEW_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

/* Is there a mark, of a pull that did not end well? */
bool anew_is_marked(struct ttf_io *io, const char *folder);

TTF_MUST_USE int anew_mark(struct ttf_io *io, const char *folder, struct ttf_err *err);

void anew_unmark(struct ttf_io *io, const char *folder);

/* The file's bytes in a new file of the same name; synced with its folder, if asked for. ret_sha256, of them: NULL allowed. -ENOENT: it is not there. */
TTF_MUST_USE int anew_write(struct ttf_io *io, const char *path, bool synced, char ret_sha256[65],
                            struct ttf_err *err);

#endif
