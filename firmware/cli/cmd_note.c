/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_note.c: `ttfbox note`: a line in a dataset's notes.jsonl, while it is captured or after. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "ttf/base/time.h"
#include "ttf/capture/note.h"
#include "ttf/config/units.h"
#include "ttf/dataset/reader.h"
#include "ttf/hal/clock.h"

/* "12-20", "12"; several with commas. */
static int take_slots(const char *text, struct ttf_note *note, struct ttf_err *err)
{
    while (*text) {
        size_t n = strcspn(text, ",");
        char part[48];
        char *dash;
        int64_t *range = note->slots[note->n_slots];

        if (n >= sizeof part || note->n_slots == TTF_NOTE_SLOTS_MAX)
            return ttf_err_set(err, -EINVAL, "--slots", "too much is named");
        memcpy(part, text, n);
        part[n] = '\0';
        dash = strchr(part, '-');
        if (dash)
            *dash = '\0';
        if (ttf_integer_parse(part, &range[0], err) < 0 ||
            ttf_integer_parse(dash ? dash + 1 : part, &range[1], err) < 0) {
            ttf_err_set(err, -EINVAL, "--slots", "'%.40s' is no range of slots", text);
            ttf_err_hint(err, "write 12-20, or 12, several with commas");
            return -EINVAL;
        }
        note->n_slots++;
        text += n + (text[n] == ',');
    }
    return 0;
}

static int take_tags(const char *text, struct ttf_note *note, struct ttf_err *err)
{
    while (*text) {
        size_t n = strcspn(text, ",");

        if (n >= sizeof note->tags[0] || note->n_tags == TTF_NOTE_TAGS_MAX)
            return ttf_err_set(err, -EINVAL, "--tag", "a tag has at most %zu letters; at most %d",
                               sizeof note->tags[0] - 1, TTF_NOTE_TAGS_MAX);
        memcpy(note->tags[note->n_tags++], text, n);
        text += n + (text[n] == ',');
    }
    return 0;
}

/* Slots that a finished dataset will never have are a slip of the pen. */
static int check_slots(struct cli *cli, const char *path, const struct ttf_note *note)
{
    struct ttf_reader *reader;
    const struct ttf_reader_summary *summary;
    int64_t last;
    bool sealed;

    if (note->n_slots == 0 || ttf_reader_open(cli->io, path, &reader, NULL) < 0)
        return 0; /* what is damaged may be noted on too */
    summary = ttf_reader_summary(reader);
    last = summary->slots ? summary->last_index : -1;
    sealed = summary->sealed;
    ttf_reader_close(reader);
    for (unsigned i = 0; sealed && i < note->n_slots; i++)
        if (note->slots[i][1] > last)
            return ttf_err_set(&cli->err, -EINVAL, "--slots",
                               "the dataset is complete and its last slot is %" PRId64, last);
    return 0;
}

/* With the time of now, where the machine knows it. */
static int add(struct cli *cli, const char *path, struct ttf_note *note)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_utc utc;
    int r;

    if (!clock)
        return ttf_err_set(&cli->err, -ENOMEM, path, "no memory");
    ttf_clock_utc(clock, &utc);
    if (utc.trust != TTF_TRUST_NONE)
        note->utc_ns = utc.utc_ns;
    r = ttf_note_add(clock, cli->io, path, note, &cli->err);
    ttf_clock_destroy(clock);
    return r;
}

int cmd_note(struct cli *cli)
{
    const char *path = cli->opt.args[0];
    const char *text = cli->opt.n_args > 1 ? cli->opt.args[1] : "";
    struct ttf_note note = {.utc_ns = TTF_NS_UNKNOWN};
    int r = 0;

    if (cli->opt.author && strlen(cli->opt.author) >= sizeof note.author)
        return ttf_err_set(&cli->err, -EINVAL, "--author", "a name has at most %zu bytes",
                           sizeof note.author - 1);
    if (strlen(text) >= sizeof note.text)
        return ttf_err_set(&cli->err, -EINVAL, path, "a note's text has at most %zu bytes",
                           sizeof note.text - 1);
    memcpy(note.text, text, strlen(text) + 1);
    if (cli->opt.author)
        memcpy(note.author, cli->opt.author, strlen(cli->opt.author) + 1);
    if (cli->opt.slots)
        r = take_slots(cli->opt.slots, &note, &cli->err);
    if (r == 0 && cli->opt.tag)
        r = take_tags(cli->opt.tag, &note, &cli->err);
    if (r == 0)
        r = check_slots(cli, path, &note);
    if (r == 0)
        r = add(cli, path, &note);
    if (r == 0) {
        cli_say(cli, "noted             %s/notes.jsonl", path);
        ttf_json_kstring(&cli->out, "dataset", path);
    }
    return r;
}
