/* SPDX-License-Identifier: Apache-2.0 */
/* A board's YAML; bytes behind a zero are an override of it, as --set gives them. */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "ttf/config/board_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *zero = memchr(data, '\0', size);
    size_t n = zero ? (size_t)(zero - data) : size;
    char *value = zero ? strndup((const char *)zero + 1, size - n - 1) : NULL;
    const struct ttf_board_set set = {.path = "sim.seed", .value = value};
    struct ttf_board *board = calloc(1, sizeof *board);
    struct ttf_err err = {0};

    if (board)
        (void)!ttf_board_parse("board.yaml", (const char *)data, n, &set, value ? 1 : 0, board,
                               &err);
    free(board);
    free(value);
    return 0;
}
