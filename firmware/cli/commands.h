/* SPDX-License-Identifier: Apache-2.0 */
/*
 * commands.h: the table of commands. Help (--help) and manual pages are both made
 * from it, so neither can say what the other does not.
 */
#ifndef CLI_COMMANDS_H
#define CLI_COMMANDS_H

#include "cli.h"

#define CLI_COMMAND_OPTIONS_MAX 80
#define CLI_EXAMPLES_MAX        5

/* An option a command takes; text NULL: the option's own. OPT_GROUP: a head over those that follow. */
struct cli_command_option {
    enum cli_option option;
    const char *text;
};

struct cli_example {
    const char *line, *text;
};

struct cli_command {
    const char *name;    /* "plan check" */
    const char *args;    /* as shown behind the options, "PLAN" */
    const char *summary; /* without a full stop */
    const char *text;    /* paragraphs, apart by empty lines */
    unsigned min_args, max_args;
    int (*run)(struct cli *cli); /* 0, a positive exit code, or a negative errno with cli->err */
    struct cli_command_option options[CLI_COMMAND_OPTIONS_MAX];
    struct cli_example examples[CLI_EXAMPLES_MAX];
};

/* The i-th command, or NULL. */
const struct cli_command *cli_command(unsigned i);

/*
 * The command that the first words name; *ret_words: how many of them its name takes.
 * NULL if none; then *ret_group says whether words[0] begins some command's name.
 */
const struct cli_command *cli_command_find(int n, char *const *words, int *ret_words,
                                           bool *ret_group);

int cmd_board_probe(struct cli *cli);
int cmd_board_show(struct cli *cli);
int cmd_calibrate_dark(struct cli *cli);
int cmd_calibrate_flat(struct cli *cli);
int cmd_calibrate_chart(struct cli *cli);
int cmd_calibrate_geometry(struct cli *cli);
int cmd_calibrate_flicker(struct cli *cli);
int cmd_calibrate_report(struct cli *cli);
int cmd_capture(struct cli *cli);
int cmd_develop(struct cli *cli);
int cmd_export(struct cli *cli);
int cmd_help(struct cli *cli);
int cmd_import(struct cli *cli);
int cmd_info(struct cli *cli);
int cmd_note(struct cli *cli);
int cmd_sample(struct cli *cli);
int cmd_plan_check(struct cli *cli);
int cmd_pull(struct cli *cli);
int cmd_serve(struct cli *cli);
int cmd_synth_composite(struct cli *cli);
int cmd_synth_quilt(struct cli *cli);
int cmd_token(struct cli *cli);
int cmd_synth_rank(struct cli *cli);
int cmd_usb(struct cli *cli);
int cmd_usb_list(struct cli *cli);
int cmd_usb_token(struct cli *cli);
int cmd_verify(struct cli *cli);
int cmd_view(struct cli *cli);

#endif
