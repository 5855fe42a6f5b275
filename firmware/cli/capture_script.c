/* SPDX-License-Identifier: Apache-2.0 */
/* capture_script.c: see capture_script.h. */
#include "capture_script.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/config/plan_file.h"
#include "ttf/config/units.h"

#define SCRIPT_MAX_BYTES ((size_t)1 << 20)

/* The plan file that an ask borrows its words from, for as long as it is asked. */
static int take_plan(const char *path, struct ttf_ask *ask, struct ttf_plan_file **ret,
                     struct ttf_err *err)
{
    int r = ttf_plan_file_load(path, ret, err);

    if (r < 0)
        return r;
    ask->plan = *ttf_plan_file_plan(*ret);
    ask->plan_yaml = ttf_plan_file_text(*ret);
    return 0;
}

static int take_word(const char *word, const char *value, struct ttf_ask *ask,
                     struct ttf_plan_file **ret_plan, struct ttf_err *err)
{
    static const struct {
        const char *word;
        enum ttf_ask_kind kind;
        int needs_value; /* -1: has none; 0: may have one */
    } WORDS[] = {{"pause", TTF_ASK_PAUSE, 0},       {"continue", TTF_ASK_CONTINUE, -1},
                 {"stop", TTF_ASK_STOP, -1},        {"count", TTF_ASK_COUNT, 1},
                 {"interval", TTF_ASK_INTERVAL, 1}, {"plan", TTF_ASK_PLAN, 1},
                 {"note", TTF_ASK_NOTE, 1}};
    unsigned i = 0;

    while (i < TTF_COUNT_OF(WORDS) && strcmp(WORDS[i].word, word) != 0)
        i++;
    if (i == TTF_COUNT_OF(WORDS) || (WORDS[i].needs_value > 0 && !*value) ||
        (WORDS[i].needs_value < 0 && *value)) {
        ttf_err_set(err, -EINVAL, NULL, "'%.40s %.40s' asks for nothing", word, value);
        ttf_err_hint(err, "SLOT and one of pause [REASON], continue, stop, count N, interval TIME, "
                          "plan FILE, note TEXT");
        return -EINVAL;
    }
    ask->kind = WORDS[i].kind;
    switch (ask->kind) {
    case TTF_ASK_PAUSE:
        (void)snprintf(ask->reason, sizeof ask->reason, "%s", value);
        return 0;
    case TTF_ASK_COUNT:
        return ttf_integer_parse(value, &ask->count, err);
    case TTF_ASK_INTERVAL:
        return ttf_unit_parse(TTF_UNIT_TIME, value, &ask->interval_ns, err);
    case TTF_ASK_PLAN:
        return take_plan(value, ask, ret_plan, err);
    case TTF_ASK_NOTE:
        ask->note.utc_ns = TTF_NS_UNKNOWN;
        (void)snprintf(ask->note.text, sizeof ask->note.text, "%s", value);
        return 0;
    default:
        return 0;
    }
}

/* One line, which is written into. */
static int ask_line(char *line, int64_t next_index, struct ttf_control *control,
                    struct ttf_err *err)
{
    struct ttf_plan_file *plan = NULL;
    struct ttf_ask *ask;
    char *rest = NULL;
    char *slot = strtok_r(line, " \t", &rest);
    char *word = strtok_r(NULL, " \t", &rest);
    int r;

    if (!slot || slot[0] == '#')
        return 0;
    ask = calloc(1, sizeof *ask);
    if (!ask)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = ttf_integer_parse(slot, &ask->from_index, err);
    if (r == 0)
        r = take_word(word ? word : "", rest ? rest + strspn(rest, " \t") : "", ask, &plan, err);
    if (r == 0 && ask->from_index >= next_index && ttf_control_ask(control, ask) < 0)
        r = ttf_err_set(err, -EINVAL, NULL, "more than %d lines", TTF_ASKS_MAX);
    ttf_plan_file_free(plan);
    free(ask);
    return r;
}

int capture_script_ask(struct cli *cli, const char *path, int64_t next_index,
                       struct ttf_control **ret)
{
    struct ttf_control *control = ttf_control_create();
    char *text = NULL;
    char *next;
    size_t bytes;
    unsigned number = 0;
    int r = control ? ttf_io_slurp(cli->io, path, SCRIPT_MAX_BYTES, &text, &bytes, &cli->err)
                    : ttf_err_set(&cli->err, -ENOMEM, path, "no memory");

    for (char *line = text; r == 0 && line; line = next) {
        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        number++;
        r = ask_line(line, next_index, control, &cli->err);
        if (r < 0 && !strchr(cli->err.where, ':'))
            (void)snprintf(cli->err.where, sizeof cli->err.where, "%.200s:%u", path, number);
    }
    free(text);
    if (r < 0) {
        ttf_control_destroy(control);
        return r;
    }
    *ret = control;
    return 0;
}
