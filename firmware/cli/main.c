/* SPDX-License-Identifier: Apache-2.0 */
/* main.c: which command, its options through argp, how it ends. */
#include <argp.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "help.h"
#include "run.h"

#define KEY(option) (0x1000 + (int)(option)) /* long options of argp: beyond all letters */

/* What argp needs to know of one command, made from the tables. */
struct parse {
    struct cli *cli;
    struct argp_option options[CLI_COMMAND_OPTIONS_MAX + 2];
    char doc[4096];
    const char **args;
    unsigned n_args;
    int error;
};

static error_t take(int key, char *value, struct argp_state *state)
{
    struct parse *parse = state->input;
    const struct cli_command *command = parse->cli->command;
    enum cli_option option = OPT_END;

    if (key == ARGP_KEY_ARG) {
        parse->args[parse->n_args++] = value;
        return 0;
    }
    if (key == ARGP_KEY_END) {
        if (parse->n_args < command->min_args)
            argp_error(state, "%s is missing", command->args); /* NOLINT(concurrency-mt-unsafe) */
        if (parse->n_args > command->max_args)
            /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
            argp_error(state, "'%s' is one too many", parse->args[command->max_args]);
        return 0;
    }
    if (key == 'h') {
        /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
        argp_state_help(state, stdout, ARGP_HELP_STD_HELP);
        return 0;
    }
    for (const struct cli_command_option *o = command->options; o->option != OPT_END; o++)
        if (KEY(o->option) == key || cli_option_def(o->option)->letter == key)
            option = o->option;
    if (option == OPT_END)
        return ARGP_ERR_UNKNOWN;
    parse->error = cli_option_take(&parse->cli->opt, option, value, &parse->cli->err);
    return parse->error < 0 ? EINVAL : 0;
}

static void make_doc(struct parse *parse, const struct cli_command *c)
{
    size_t n = (size_t)snprintf(parse->doc, sizeof parse->doc, "%c%s.\n\n\v%s\n\nExamples:\n",
                                c->summary[0] - 'a' + 'A', c->summary + 1, c->text);

    for (unsigned i = 0; i < CLI_EXAMPLES_MAX && c->examples[i].line && n < sizeof parse->doc; i++)
        n += (size_t)snprintf(parse->doc + n, sizeof parse->doc - n, "  %s%s%s%s\n",
                              c->examples[i].line, c->examples[i].text ? "\n      (" : "",
                              c->examples[i].text ? c->examples[i].text : "",
                              c->examples[i].text ? ")" : "");
}

/* Reads argv[0..argc-1], argv[0] being "ttfbox COMMAND". 0, or a negative errno with cli->err. */
static int parse_options(struct cli *cli, int argc, char **argv)
{
    const struct cli_command *c = cli->command;
    struct parse *parse = calloc(1, sizeof *parse);
    struct argp argp = {0};
    unsigned n = 0;
    error_t r;

    if (!parse)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    parse->cli = cli;
    parse->args = calloc((size_t)argc + 1, sizeof *parse->args);
    if (!parse->args) {
        free(parse);
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    }
    for (const struct cli_command_option *o = c->options; o->option != OPT_END; o++) {
        const struct cli_option_def *def = cli_option_def(o->option);

        if (o->option == OPT_GROUP) { /* argp takes an entry without name and key for a head */
            parse->options[n++] = (struct argp_option){.doc = o->text};
            continue;
        }
        parse->options[n++] =
            (struct argp_option){.name = def->name,
                                 .key = def->letter ? def->letter : KEY(o->option),
                                 .arg = def->arg,
                                 .doc = o->text ? o->text : def->text};
    }
    parse->options[n] = (struct argp_option){.name = NULL, .key = 'h', .flags = OPTION_HIDDEN};
    make_doc(parse, c);
    argp.options = parse->options;
    argp.parser = take;
    argp.args_doc = c->args;
    argp.doc = parse->doc;
    cli_options_defaults(&cli->opt);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs yet */
    r = argp_parse(&argp, argc, argv, 0, NULL, parse);
    cli->opt.args = parse->args;
    cli->opt.n_args = parse->n_args;
    free(parse);
    if (r && cli->err.code == 0)
        return ttf_err_set(&cli->err, -EINVAL, NULL, "%s", strerrordesc_np(r));
    return r ? cli->err.code : 0;
}

/* Of a disk that takes no more, whoever wrote a file's bytes has no path: it is the output's. */
static void name_the_disk(struct cli *cli)
{
    int code = cli->err.code;

    if (*cli->err.where || !cli->opt.output || (code != -ENOSPC && code != -EDQUOT))
        return;
    (void)snprintf(cli->err.where, sizeof cli->err.where, "%s", cli->opt.output);
    ttf_err_hint(&cli->err, "make room there, or give another -o");
}

/* What went wrong: on standard error; and, where it was asked for, as the result. */
static void report_error(struct cli *cli, int code)
{
    char text[900];

    name_the_disk(cli);
    cli_warn("ttfbox %s: %s", cli->command->name, ttf_err_text(&cli->err, text, sizeof text));
    ttf_json_free(&cli->out);
    ttf_json_init(&cli->out, false);
    ttf_json_object(&cli->out);
    ttf_json_kint(&cli->out, "exit", code);
    ttf_json_kstring(&cli->out, "error", cli->err.what);
    ttf_json_kstring(&cli->out, "where", cli->err.where);
    ttf_json_kstring(&cli->out, "hint", cli->err.hint);
}

/* Runs the command, unless its options were wrong already (code < 0). Returns the exit code. */
static int run(struct cli *cli, int code)
{
    const char *line;
    size_t bytes;

    ttf_json_init(&cli->out, false);
    ttf_json_object(&cli->out);
    /* Every command's -o is where it writes. */
    if (code == 0 && cli->opt.output)
        code = cli_refuse_inside_dataset(cli, cli->opt.output);
    if (code == 0)
        code = cli->command->run(cli);
    if (code < 0) {
        if (cli->err.code == 0)
            ttf_err_set(&cli->err, code, NULL, "%s", strerrordesc_np(-code));
        code = run_exit_code(code);
        report_error(cli, code);
    }
    ttf_json_object_end(&cli->out);
    if (cli->opt.json && ttf_json_finish(&cli->out, &line, &bytes) == 0)
        (void)puts(line);
    ttf_json_free(&cli->out);
    if (fflush(stdout) != 0 && code == CLI_DONE) {
        cli_warn("ttfbox: standard output cannot be written");
        code = CLI_FAILED;
    }
    return code;
}

/* No command by that name: what there is instead. */
static int no_command(int argc, char **argv, bool group)
{
    const char *word = argc > 1 ? argv[1] : NULL;

    if (!word) {
        help_overview(stderr, NULL);
        return CLI_WRONG_INPUT;
    }
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "-?") == 0) {
        help_overview(stdout, NULL);
        return CLI_DONE;
    }
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
        (void)puts("ttfbox " TTFBOX_VERSION);
        return CLI_DONE;
    }
    if (group && argc > 2 && (strcmp(argv[2], "--help") == 0 || strcmp(argv[2], "-h") == 0)) {
        help_overview(stdout, word);
        return CLI_DONE;
    }
    if (group && argc > 2)
        cli_warn("ttfbox: there is no command '%s %s'", word, argv[2]);
    else if (group)
        cli_warn("ttfbox: '%s' needs a second word", word);
    else
        cli_warn("ttfbox: there is no command '%s'", word);
    help_overview(stderr, group ? word : NULL);
    return CLI_WRONG_INPUT;
}

/* Before options are read, which changes them. NULL: no memory. */
static char **copy_words(int argc, char *const *argv)
{
    char **words = calloc((size_t)argc + 1, sizeof *words);

    if (words)
        memcpy(words, argv, (size_t)argc * sizeof *words);
    return words;
}

int main(int argc, char **argv)
{
    struct cli cli = {.io = ttf_io_posix()};
    char name[64], **given;
    bool group = false;
    int words = 0, code;

    argp_err_exit_status = CLI_WRONG_INPUT;
    (void)signal(SIGPIPE, SIG_IGN);
    cli.command = cli_command_find(argc - 1, argv + 1, &words, &group);
    if (!cli.command)
        return no_command(argc, argv, group);
    given = copy_words(argc, argv);
    cli.words = given;
    (void)snprintf(name, sizeof name, "ttfbox %s", cli.command->name);
    argv[words] = name;
    code = run(&cli, given ? parse_options(&cli, argc - words, argv + words) : -ENOMEM);
    free((void *)cli.opt.args);
    free(given);
    cli_options_free(&cli.opt);
    return code;
}
