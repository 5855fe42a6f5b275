/* SPDX-License-Identifier: Apache-2.0 */
/* help.c: see help.h. */
#include "help.h"

#include <string.h>

static const char *const EXITS[][2] = {{"0", "done"},
                                       {"1", "failed, or stopped before it was done"},
                                       {"2", "wrong input: an option, a plan, a board, a path"},
                                       {"3", "damaged data, named by file and slot"}};

#define ABOUT                                                                                      \
    "ttfbox photographs a sample at fixed intervals for minutes to weeks, keeps the frames as a "  \
    "calibrated dataset, and synthesizes larger time-varying textures from it. Without hardware, " \
    "everything runs in a simulated box."

void help_overview(FILE *out, const char *group)
{
    const struct cli_command *c;
    size_t n = group ? strlen(group) : 0;

    if (group)
        (void)fprintf(out, "Usage: ttfbox %s COMMAND [OPTION...]\n\nCommands:\n", group);
    else
        (void)fprintf(out,
                      "Usage: ttfbox COMMAND [OPTION...]\n\n"
                      "Photographs samples for weeks, keeps calibrated datasets of time-varying\n"
                      "textures, synthesizes larger ones.\n\nCommands:\n");
    for (unsigned i = 0; (c = cli_command(i)); i++)
        if (!group || (strncmp(c->name, group, n) == 0 && c->name[n] == ' '))
            (void)fprintf(out, "  %-18s %s\n", c->name, c->summary);
    (void)fputs("\n'ttfbox COMMAND --help' explains one. Exit codes:", out);
    for (unsigned i = 0; i < TTF_COUNT_OF(EXITS); i++)
        (void)fprintf(out, "%s %s %.12s", i ? "," : "", EXITS[i][0],
                      i == 1   ? "failed"
                      : i == 2 ? "wrong input"
                      : i == 3 ? "damaged data"
                               : "done");
    (void)fputs(".\n", out);
}

const char *help_page_name(const struct cli_command *command, char *buf, size_t size)
{
    (void)snprintf(buf, size, "ttfbox-%s", command->name);
    for (char *p = buf; *p; p++)
        if (*p == ' ')
            *p = '-';
    return buf;
}

/* Text as troff takes it: no request by accident, dashes as they are typed. */
static void troff(FILE *out, const char *text)
{
    bool start = true;

    for (; *text; text++) {
        if (start && (*text == '.' || *text == '\''))
            (void)fputs("\\&", out);
        start = *text == '\n';
        if (*text == '\\')
            (void)fputs("\\e", out);
        else if (*text == '-')
            (void)fputs("\\-", out);
        else if (*text == '\n' && text[1] == '\n') {
            (void)fputs("\n.PP", out);
        } else
            (void)fputc(*text, out);
    }
    (void)fputc('\n', out);
}

static void head(FILE *out, const char *page, const char *summary)
{
    char upper[64];
    size_t i;

    for (i = 0; page[i] && i + 1 < sizeof upper; i++)
        upper[i] = (char)(page[i] >= 'a' && page[i] <= 'z' ? page[i] - 'a' + 'A' : page[i]);
    upper[i] = '\0';
    (void)fprintf(out, ".\\\" Made from the program's table of commands: 'ttfbox help --man'.\n"
                       ".TH \"");
    for (i = 0; upper[i]; i++)
        (void)fprintf(out, upper[i] == '-' ? "\\-" : "%c", upper[i]);
    (void)fprintf(out, "\" 1 \"\" \"ttfbox %s\" \"ttfbox\"\n.SH NAME\n", TTFBOX_VERSION);
    for (; *page; page++)
        (void)fprintf(out, *page == '-' ? "\\-" : "%c", *page);
    (void)fputs(" \\- ", out);
    troff(out, summary);
}

static void exits(FILE *out)
{
    (void)fputs(".SH EXIT STATUS\n", out);
    for (unsigned i = 0; i < TTF_COUNT_OF(EXITS); i++) {
        (void)fprintf(out, ".TP\n%s\n", EXITS[i][0]);
        troff(out, EXITS[i][1]);
    }
}

void help_man_overview(FILE *out)
{
    const struct cli_command *c;
    char page[64];

    head(out, "ttfbox", "capture, keep and synthesize time-varying textures");
    (void)fputs(".SH SYNOPSIS\n.B ttfbox\n.I COMMAND\n[\\fIOPTION\\fR...]\n.SH DESCRIPTION\n", out);
    troff(out, ABOUT);
    (void)fputs(".SH COMMANDS\n", out);
    for (unsigned i = 0; (c = cli_command(i)); i++) {
        (void)fprintf(out, ".TP\n.B %s\n", c->name);
        troff(out, c->summary);
    }
    exits(out);
    (void)fputs(".SH SEE ALSO\n", out);
    for (unsigned i = 0; (c = cli_command(i)); i++) {
        (void)fprintf(out, "%s.BR ", i ? ",\n" : "");
        for (const char *p = help_page_name(c, page, sizeof page); *p; p++)
            (void)fprintf(out, *p == '-' ? "\\-" : "%c", *p);
        (void)fputs(" (1)", out);
    }
    (void)fputc('\n', out);
}

static void man_options(FILE *out, const struct cli_command *c)
{
    (void)fputs(".SH OPTIONS\n", out);
    for (const struct cli_command_option *o = c->options; o->option != OPT_END; o++) {
        const struct cli_option_def *def = cli_option_def(o->option);

        if (o->option == OPT_GROUP) {
            (void)fputs(".SS ", out);
            troff(out, o->text);
            continue;
        }
        (void)fputs(".TP\n", out);
        if (def->letter)
            (void)fprintf(out, "\\fB\\-%c\\fR, ", def->letter);
        (void)fputs("\\fB\\-\\-", out);
        for (const char *p = def->name; *p; p++)
            (void)fprintf(out, *p == '-' ? "\\-" : "%c", *p);
        (void)fputs("\\fR", out);
        if (def->arg)
            (void)fprintf(out, "=\\fI%s\\fR", def->arg);
        (void)fputc('\n', out);
        troff(out, o->text ? o->text : def->text);
    }
    (void)fputs(".TP\n\\fB\\-\\-help\\fR\nthis explanation, shorter\n", out);
}

void help_man_command(FILE *out, const struct cli_command *c)
{
    char page[64];

    head(out, help_page_name(c, page, sizeof page), c->summary);
    (void)fprintf(out, ".SH SYNOPSIS\n.B ttfbox %s\n[\\fIOPTION\\fR...]", c->name);
    (void)fprintf(out, *c->args ? " \\fI%s\\fR\n" : "\n%s", c->args);
    (void)fputs(".SH DESCRIPTION\n", out);
    troff(out, c->text);
    man_options(out, c);
    exits(out);
    (void)fputs(".SH EXAMPLES\n", out);
    for (unsigned i = 0; i < CLI_EXAMPLES_MAX && c->examples[i].line; i++) {
        (void)fputs(".PP\n", out);
        if (c->examples[i].text) {
            troff(out, c->examples[i].text);
        }
        (void)fputs(".RS\n.nf\n", out);
        troff(out, c->examples[i].line);
        (void)fputs(".fi\n.RE\n", out);
    }
    (void)fputs(".SH SEE ALSO\n.BR ttfbox (1)\n", out);
}
