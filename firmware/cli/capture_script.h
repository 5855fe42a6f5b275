/* SPDX-License-Identifier: Apache-2.0 */
/*
 * capture_script.h: what is asked of a living run, from a file: a line each, SLOT WORD [VALUE], heard when that slot is
 * the next one. Words: pause [REASON], continue, stop, count N, interval TIME, plan FILE, note TEXT. Empty
 * lines and lines that begin with # say nothing.
 */
#ifndef CLI_CAPTURE_SCRIPT_H
#define CLI_CAPTURE_SCRIPT_H

#include "cli.h"
#include "ttf/capture/control.h"

/*
 * Asks all of it that is for slots from next_index on: what was before has been heard. *ret: to be destroyed.
 * -EINVAL naming file and line.
 */
TTF_MUST_USE int capture_script_ask(struct cli *cli, const char *path, int64_t next_index,
                                    struct ttf_control **ret);

#endif
