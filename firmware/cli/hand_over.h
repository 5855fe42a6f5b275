/* SPDX-License-Identifier: Apache-2.0 */
/*
 * hand_over.h: two programs, one table of commands. What few commands need (curl, an HTTP server, libusb, archives, and some forty libraries behind
 * them) takes most of the time that a program takes to start, and memory besides. So `ttfbox` is linked without, and hands those commands over to
 * `ttfbox-full`, which is linked with everything and can do all of them.
 */
#ifndef CLI_HAND_OVER_H
#define CLI_HAND_OVER_H

#include "cli.h"
#include "ttf/base/attr.h"

/* Is this program linked with everything? */
bool cli_is_full(void);

/*
 * Runs ttfbox-full in this process's place with the words that were typed: it returns only if that cannot be. -ENOPKG with its
 * reason. Of ttfbox-full itself: -ENOTSUP.
 */
TTF_MUST_USE int cli_hand_over(struct cli *cli);

#endif
