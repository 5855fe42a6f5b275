/* SPDX-License-Identifier: Apache-2.0 */
/*
 * capture_script.h: what is asked of a living run, from a file: a line each, SLOT WORD [VALUE], heard when that slot is
 * the next one. Words: pause [REASON], continue, stop, count N, until INSTANT, interval TIME, plan FILE, note TEXT. Empty
 * lines and lines that begin with # say nothing.
 */
#ifndef CLI_CAPTURE_SCRIPT_H
#define CLI_CAPTURE_SCRIPT_H

#include "cli.h"
#include "ttf/capture/control.h"

struct capture_script;

/*
 * Asks all of it that is for slots from next_index on: what was before has been heard, and a stop at
 * next_index too, if that is not 0. -EINVAL naming file and line.
 */
TTF_MUST_USE int capture_script_ask(struct cli *cli, const char *path, int64_t next_index,
                                    struct capture_script **ret);

/* What is asked, for the session. */
struct ttf_control *capture_script_control(struct capture_script *script);

/* After the run: a warning for each line that was refused, or whose slot never came. How many. */
unsigned capture_script_tell(struct capture_script *script);

void capture_script_free(struct capture_script *script); /* NULL allowed */

#endif
