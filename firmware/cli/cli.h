/* SPDX-License-Identifier: Apache-2.0 */
/*
 * cli.h: what every command has at hand: its options, how it speaks, how it ends.
 *
 * Results go to standard output (people's text, or one line of JSON), progress
 * and errors to standard error. Exit codes: 0 done, 1 failed, 2 wrong input, 3
 * damaged data.
 */
#ifndef CLI_CLI_H
#define CLI_CLI_H

#include <stdbool.h>
#include <stdint.h>

#include "lock.h"
#include "options.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/sequence.h"

enum {
    CLI_DONE = 0,
    CLI_FAILED = 1,
    CLI_WRONG_INPUT = 2,
    CLI_DAMAGED = 3
};

struct cli_command;

struct cli {
    const struct cli_command *command;
    char *const *words; /* as typed, the program's name first, NULL behind the last */
    struct cli_options opt;
    struct ttf_io *io;
    struct ttf_err err;  /* what a command that returns an error leaves */
    struct ttf_json out; /* the result for --json; opened and closed by main */
};

/* ---- speaking ---- */

/* A line for people on standard output; silent with --json. */
void cli_say(const struct cli *cli, const char *fmt, ...) TTF_PRINTF(2, 3);

/* With --json one line now, of a command that goes on: {"listening":WHERE}, and "free_to_read" if that is not NULL. */
void cli_say_listening(const struct cli *cli, const char *where, const bool *free_to_read);

/* A line on standard error, always. */
void cli_warn(const char *fmt, ...) TTF_PRINTF(1, 2);

/* ---- progress: a bar on standard error if that is a terminal ---- */

struct cli_progress {
    bool shown;
    bool drawn;
    const char *label;
    int percent;
};

void cli_progress_begin(struct cli_progress *p, const struct cli *cli, const char *label);
/* done of total with a text behind; total 0: only the number. */
void cli_progress_at(struct cli_progress *p, int64_t done, int64_t total, const char *text);
/* Takes the bar away, so that lines may follow. */
void cli_progress_end(struct cli_progress *p);

/* ---- ending ---- */

/* Becomes non-zero at SIGINT or SIGTERM, once cli_stop_catch was called. */
void cli_stop_catch(void);
const volatile int *cli_stop_flag(void);

/* ---- what many commands need ---- */

/* -EINVAL with the hint if the option was not given. */
int cli_need(struct cli *cli, const char *value, const char *option, const char *hint);

/* Which images --stream, --bracket and --with-excluded ask for. */
struct ttf_sequence_choice cli_choice(const struct cli *cli);

/* -EEXIST if there is something at path (other than an empty folder): it is never overwritten. */
int cli_refuse_existing(struct cli *cli, const char *path);

/*
 * An error that came by an option, on its way up: where it names a field of the library, it names the
 * option instead; a file (path, if it may be without a slash) keeps its place. Returns code.
 */
int cli_by_option(struct cli *cli, int code, const char *option, const char *path);

/*
 * -EINVAL if path lies inside of a dataset: a sealed one would no longer be what its digest says,
 * and one that grows would be taken for damaged. The dataset's own folder is not inside.
 */
int cli_refuse_inside_dataset(struct cli *cli, const char *path);

/* The folders in which boards are looked for, NULL-ended; texts live as long as the program. */
const char *const *cli_board_folders(void);

/* Reads the board that --board, --set, --scene and --seed describe. */
int cli_load_board(struct cli *cli, struct ttf_board *ret);

/* The same in words, with what was said otherwise (run_describe). */
void cli_describe_board(struct cli *cli, const struct ttf_board *board, char ret[256]);

/* The board's box is this command's until box_lock_drop. -EBUSY, saying who owns it. */
int cli_own_box(struct cli *cli, const struct ttf_board *board, struct box_lock *ret);

/* Now on the clock given (a struct ttf_clock), in the shape that reports of times want. */
int64_t cli_now_ns(void *clock);

#endif
