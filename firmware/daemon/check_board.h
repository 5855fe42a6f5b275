/* SPDX-License-Identifier: Apache-2.0 */
/* check_board.h: can a board be described so? Nothing of the box is asked or changed. Any thread. */
#ifndef DAEMON_CHECK_BOARD_H
#define DAEMON_CHECK_BOARD_H

#include <stddef.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

/*
 * Findings, and what the description says, as JSON, by malloc. Without a name it fails only where that cannot be said; with one also,
 * -EINVAL, where the description would not do or calls itself otherwise: *err says why.
 */
TTF_MUST_USE int check_board(const char *yaml, size_t bytes, const char *name, char **ret_json,
                             struct ttf_err *err);

#endif
