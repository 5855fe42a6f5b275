/* SPDX-License-Identifier: Apache-2.0 */
/* board_findings.h: what `board probe` finds wrong with the machine around a box (probe/). */
#ifndef CLI_BOARD_FINDINGS_H
#define CLI_BOARD_FINDINGS_H

#include "cli.h"
#include "ttf/config/board_file.h"
#include "ttf/hal/clock.h"

/*
 * Looks, says, and puts them into the JSON. How many are problems. clock: NULL where the machine is another one's
 * files; no_camera: a back-end was asked and found none.
 */
unsigned board_findings(struct cli *cli, const struct ttf_board *board, struct ttf_clock *clock,
                        bool no_camera);

/* --bundle: with what the JSON says so far. */
int board_bundle(struct cli *cli, const struct ttf_board *board);

#endif
