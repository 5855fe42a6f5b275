/* SPDX-License-Identifier: Apache-2.0 */
/*
 * run.h: one run of a plan on a box into a dataset, as the command line and the daemon both have it: what lies there
 * already, the box made, the plan checked against it, the session, and, of a simulated box, its reboots.
 */
#ifndef FIRMWARE_RUN_H
#define FIRMWARE_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "box.h"
#include "ttf/base/err.h"
#include "ttf/capture/session.h"
#include "ttf/config/board_file.h"
#include "ttf/config/plan_file.h"
#include "ttf/dataset/io.h"

/* Zeroed, then given; all borrowed until the run has ended. */
struct run {
    /* given */
    struct ttf_io *io;
    struct ttf_board *board; /* of a simulated one the time of its boot is set */
    const struct box_host *host;
    struct ttf_plan_file *file;
    char description[256]; /* of the board, see run_describe */
    /* Since when it is wanted, on this boot's clock; 0: just now. Its start is to come as of then: what keeps it from
     * beginning on time costs the slots of that time, and not the run. */
    int64_t wanted_ns;
    /* path, calibration_folder, threads, progress, stop, control and the choices; the rest is filled in */
    struct ttf_session_config session;
    /* A simulated box lost power and is back so long after its first start. NULL allowed. */
    void (*power_back)(void *ctx, int64_t back_ns);
    void *power_back_ctx;
    /* The box of a run is made, and the plan fits it. NULL allowed. */
    void (*box_ready)(void *ctx, const struct ttf_box *box, const struct ttf_plan *plan,
                      const struct ttf_plan_figures *figures);
    void *box_ready_ctx;

    /* found by run_look */
    bool exists;        /* there is a dataset to go on with */
    int64_t next_index; /* the first slot without a record */
    char dataset[4096]; /* where it is gone on with: as given, or in the second storage */
    char digest[65];    /* of what was sealed before; empty if nothing was */

    /* of run_boots */
    unsigned boots;
    struct ttf_session_result result;
};

/* What lies at session.path. -EEXIST, -EINVAL: nothing that this box may go on with; errors of reading it. */
TTF_MUST_USE int run_look(struct run *run, struct ttf_err *err);

/*
 * Runs until the plan is done (sealed) or a stop was asked for; 0 for both. A simulated box that loses power comes back
 * by itself. Errors of box_create, of the plan (placed in its file), of ttf_session_run.
 */
TTF_MUST_USE int run_boots(struct run *run, struct ttf_err *err);

/* What a board was, beyond its file: keys that were set otherwise. */
struct run_choices {
    const char *scene; /* NULL: the board's */
    const struct ttf_board_set *sets;
    unsigned n_sets;
    bool has_seed;
};

/*
 * A board in words, for a box made from it: its name and the beginning of its file's sha256, then what
 * was said otherwise. What is too long for ret is cut, with the beginning of the whole text's sha256 at its end.
 */
void run_describe(struct ttf_io *io, const struct ttf_board *board,
                  const struct run_choices *choices, char ret[256]);

/* How a program ends by an error: 0 done, 1 failed, 2 wrong input, 3 damaged data. */
int run_exit_code(int error);

#endif
