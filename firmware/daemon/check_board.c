/* SPDX-License-Identifier: Apache-2.0 */
#include "check_board.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "ttf/config/board_file.h"
#include "ttf/dataset/json_writer.h"

static void put_names(struct ttf_json *j, const struct ttf_board *board)
{
    ttf_json_key(j, "cameras");
    ttf_json_array(j);
    for (unsigned i = 0; i < board->n_cameras; i++)
        ttf_json_string(j, board->cameras[i].name);
    ttf_json_array_end(j);
    ttf_json_key(j, "lamps");
    ttf_json_array(j);
    for (unsigned i = 0; i < board->sim.n_lamps; i++) {
        const struct ttf_lamp_info *info = &board->sim.lamps[i].info;

        ttf_json_object(j);
        ttf_json_kstring(j, "name", info->name);
        ttf_json_kint(j, "max_on_ns", info->max_on_ns);
        ttf_json_kint(j, "max_duty_permille", info->max_duty_permille);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
    ttf_json_key(j, "sensors");
    ttf_json_array(j);
    for (unsigned i = 0; i < board->sim.n_sensors; i++)
        ttf_json_string(j, board->sim.sensors[i].name);
    ttf_json_array_end(j);
}

static void put_board(struct ttf_json *j, const struct ttf_board *board)
{
    ttf_json_key(j, "board");
    ttf_json_object(j);
    ttf_json_kstring(j, "name", board->name);
    ttf_json_kstring(j, "title", board->title);
    ttf_json_kbool(j, "simulated", board->simulated);
    put_names(j, board);
    ttf_json_object_end(j);
}

int check_board(const char *yaml, size_t bytes, const char *name, char **ret_json,
                struct ttf_err *err)
{
    struct ttf_board *board = malloc(sizeof *board);
    struct ttf_err wrong = {0};
    struct ttf_json j;
    int r = board ? ttf_board_parse("board", yaml, bytes, NULL, 0, board, &wrong) : -ENOMEM;

    if (r == 0 && name && strcmp(name, board->name) != 0)
        r = ttf_err_set(&wrong, -EINVAL, "board", "it calls itself '%s', not '%s'", board->name,
                        name);
    if (r == -ENOMEM || (r < 0 && name)) {
        free(board);
        if (r == -ENOMEM)
            return ttf_err_set(err, r, NULL, "no memory");
        *err = wrong;
        return err->code = -EINVAL;
    }
    ttf_json_init(&j, false);
    ttf_json_object(&j);
    ttf_json_kbool(&j, "ok", r == 0);
    ttf_json_key(&j, "findings");
    ttf_json_array(&j);
    if (r < 0)
        check_put_finding(&j, "error", &wrong);
    ttf_json_array_end(&j);
    if (r == 0)
        put_board(&j, board);
    ttf_json_object_end(&j);
    free(board);
    return daemon_give(&j, ret_json, err);
}
