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

struct capture_script {
    struct ttf_control *control;
    const char *path; /* borrowed */
    unsigned n;
    struct {
        int64_t ask; /* its number */
        unsigned line;
    } asked[TTF_ASKS_MAX];
};

/* What does not fit is refused, as `ttfbox note` and the box's interface do. */
static int take_text(const char *value, char *ret, size_t size, struct ttf_err *err)
{
    if (strlen(value) >= size)
        return ttf_err_set(err, -EINVAL, NULL, "a text of at most %zu bytes is meant", size - 1);
    memcpy(ret, value, strlen(value) + 1);
    return 0;
}

/* The plan file that an ask borrows its words from, for as long as it is asked. */
static int take_plan(const char *path, struct ttf_ask *ask, struct ttf_plan_file **ret,
                     struct ttf_err *err)
{
    int r = ttf_plan_file_load(path, ret, err);

    if (r < 0) {
        if (err && !strchr(err->where, ':'))
            (void)snprintf(err->where, sizeof err->where, "plan: %.200s", path);
        return r;
    }
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
    } WORDS[] = {{"pause", TTF_ASK_PAUSE, 0}, {"continue", TTF_ASK_CONTINUE, -1},
                 {"stop", TTF_ASK_STOP, -1},  {"count", TTF_ASK_COUNT, 1},
                 {"until", TTF_ASK_UNTIL, 1}, {"interval", TTF_ASK_INTERVAL, 1},
                 {"plan", TTF_ASK_PLAN, 1},   {"note", TTF_ASK_NOTE, 1}};
    unsigned i = 0;

    while (i < TTF_COUNT_OF(WORDS) && strcmp(WORDS[i].word, word) != 0)
        i++;
    if (i == TTF_COUNT_OF(WORDS) || (WORDS[i].needs_value > 0 && !*value) ||
        (WORDS[i].needs_value < 0 && *value)) {
        if (i == TTF_COUNT_OF(WORDS) && *word)
            ttf_err_set(err, -EINVAL, NULL, "there is no word '%.40s'", word);
        else if (!*word)
            ttf_err_set(err, -EINVAL, NULL, "a word is missing behind the slot");
        else
            ttf_err_set(err, -EINVAL, NULL, "%s %s", word,
                        *value ? "takes nothing behind it" : "needs something behind it");
        ttf_err_hint(err, "SLOT and one of pause [REASON], continue, stop, count N, until INSTANT, "
                          "interval TIME, plan FILE, note TEXT");
        return -EINVAL;
    }
    ask->kind = WORDS[i].kind;
    switch (ask->kind) {
    case TTF_ASK_PAUSE:
        return take_text(value, ask->reason, sizeof ask->reason, err);
    case TTF_ASK_COUNT:
        return ttf_integer_parse(value, &ask->count, err);
    case TTF_ASK_UNTIL:
        return ttf_utc_parse(value, &ask->until_utc_ns, err);
    case TTF_ASK_INTERVAL:
        return ttf_unit_parse(TTF_UNIT_TIME, value, &ask->interval_ns, err);
    case TTF_ASK_PLAN:
        return take_plan(value, ask, ret_plan, err);
    case TTF_ASK_NOTE:
        ask->note.utc_ns = TTF_NS_UNKNOWN;
        return take_text(value, ask->note.text, sizeof ask->note.text, err);
    default:
        return 0;
    }
}

/* One line, which is written into. */
static int ask_line(char *line, int64_t next_index, struct capture_script *script, unsigned number,
                    struct ttf_err *err)
{
    struct ttf_plan_file *plan = NULL;
    struct ttf_ask *ask;
    char *rest = NULL;
    char *slot = strtok_r(line, " \t\r", &rest);
    char *word = strtok_r(NULL, " \t\r", &rest);
    bool heard;
    int r;

    if (!slot || slot[0] == '#')
        return 0;
    if (rest)
        rest[strcspn(rest, "\r")] = '\0';
    ask = calloc(1, sizeof *ask);
    if (!ask)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = ttf_integer_parse(slot, &ask->from_index, err);
    if (r == 0 && ask->from_index < 0)
        r = ttf_err_set(err, -EINVAL, NULL, "slots count from 0");
    if (r == 0)
        r = take_word(word ? word : "", rest ? rest + strspn(rest, " \t") : "", ask, &plan, err);
    /* The slot that a stop was for is the first one of the run that goes on. */
    heard = ask->from_index < next_index ||
            (ask->kind == TTF_ASK_STOP && next_index > 0 && ask->from_index == next_index);
    if (r == 0 && !heard) {
        int64_t asked = script->n < TTF_ASKS_MAX ? ttf_control_ask(script->control, ask) : -EAGAIN;

        if (asked > 0) {
            script->asked[script->n].ask = asked;
            script->asked[script->n++].line = number;
        } else {
            r = ttf_err_set(err, -EINVAL, NULL, "more than %d lines", TTF_ASKS_MAX);
        }
    }
    ttf_plan_file_free(plan);
    free(ask);
    return r;
}

static int take_lines(struct capture_script *script, char *text, int64_t next_index,
                      struct ttf_err *err)
{
    unsigned number = 0;
    char *next;
    int r = 0;

    for (char *line = text; r == 0 && line; line = next) {
        char where[sizeof err->where];

        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        number++;
        r = ask_line(line, next_index, script, number, err);
        if (r == 0)
            continue;
        (void)snprintf(where, sizeof where, "%.100s:%u%s%.100s", script->path, number,
                       err->where[0] ? ": " : "", err->where);
        memcpy(err->where, where, sizeof where);
    }
    return r;
}

int capture_script_ask(struct cli *cli, const char *path, int64_t next_index,
                       struct capture_script **ret)
{
    struct capture_script *script = calloc(1, sizeof *script);
    char *text = NULL;
    struct ttf_io_stat st;
    size_t bytes;
    int r = 0;

    if (!script)
        return ttf_err_set(&cli->err, -ENOMEM, path, "no memory");
    script->path = path;
    script->control = ttf_control_create();
    if (!script->control)
        r = ttf_err_set(&cli->err, -ENOMEM, path, "no memory");
    if (r == 0 && cli->io->ops->stat(cli->io, path, &st) == 0 && !st.is_regular) {
        r = ttf_err_set(&cli->err, -EINVAL, path, "is no plain file");
        ttf_err_hint(&cli->err, "write the lines into a file");
    }
    if (r == 0)
        r = ttf_io_slurp(cli->io, path, SCRIPT_MAX_BYTES, &text, &bytes, &cli->err);
    if (r == 0)
        r = take_lines(script, text, next_index, &cli->err);
    free(text);
    if (r < 0) {
        capture_script_free(script);
        return r;
    }
    *ret = script;
    return 0;
}

struct ttf_control *capture_script_control(struct capture_script *script)
{
    return script->control;
}

unsigned capture_script_tell(struct capture_script *script)
{
    unsigned told = 0;

    for (unsigned i = 0; i < script->n; i++) {
        struct ttf_err err = {0};
        int r = ttf_control_answer(script->control, script->asked[i].ask, &err);

        if (r == 0)
            continue;
        told++;
        if (r == -EAGAIN || r == -ECANCELED)
            cli_warn("ttfbox capture: %s:%u: the run ended before it was heard", script->path,
                     script->asked[i].line);
        else
            cli_warn("ttfbox capture: %s:%u: refused: %s%s%s", script->path, script->asked[i].line,
                     err.what, err.hint[0] ? ": " : "", err.hint);
    }
    return told;
}

void capture_script_free(struct capture_script *script)
{
    if (!script)
        return;
    ttf_control_destroy(script->control);
    free(script);
}
