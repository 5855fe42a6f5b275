/* SPDX-License-Identifier: Apache-2.0 */
/* board_text.h: boards as text: how the least ones begin, and reading one as a file that is dir/b.yaml. */
#ifndef CONFIG_BOARD_TEXT_H
#define CONFIG_BOARD_TEXT_H

#include <string.h>

#include "ttf/config/board_file.h"

/* Of a simulated box; of one with devices; lamps of the first. */
#define HEAD                            \
    "board: t\n"                        \
    "cameras: {main: {backend: sim}}\n" \
    "clock: {backend: sim}\n"
#define REAL                            \
    "board: t\n"                        \
    "cameras: {main: {backend: sim}}\n" \
    "clock: {backend: machine}\n"
#define LAMPS "lamps: {left: {backend: sim}, right: {backend: sim}}\n"

static inline int board_text(const char *text, const struct ttf_board_set *sets, unsigned n,
                             struct ttf_board *ret, struct ttf_err *err)
{
    memset(err, 0, sizeof *err);
    return ttf_board_parse("dir/b.yaml", text, strlen(text), sets, n, ret, err);
}

#endif
