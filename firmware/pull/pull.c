/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/pull/pull.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crew.h"
#include "one.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/json_parse.h"
#include "wire.h"

#define LIST_MAX       ((size_t)16 << 20)
#define NAMES_MAX      10000 /* datasets of a box; more is none that means well */
#define SUMMARY_MAX    ((size_t)1 << 20)
#define TRIES          5 /* in a row that bring nothing */
/* More than a try takes that brings nothing: what is asked for at the beginning of each. */
#define PROGRESS_BYTES 16384
#define POLL_NS        TTF_NS_PER_S
#define WAIT_MOST      (30 * TTF_NS_PER_S)
#define LOOK_NS        (100 * TTF_NS_PER_MS)

static bool told_to_stop(const struct ttf_pull_config *config)
{
    return config->stop && *config->stop != 0;
}

static void pause_ns(const struct ttf_pull_config *config, int64_t for_ns)
{
    int64_t until = ttf_clock_now_ns(config->clock) + for_ns;
    int64_t now;

    while ((now = ttf_clock_now_ns(config->clock)) < until && !told_to_stop(config))
        (void)ttf_clock_wait_until(config->clock, until - now < LOOK_NS ? until : now + LOOK_NS);
}

static void say(const struct ttf_pull_config *config, const struct wire *wire, const char *name,
                const char *text)
{
    const struct ttf_pull_progress p = {.dataset = name,
                                        .bytes = pull_wire_bytes(wire),
                                        .now_ns = ttf_clock_now_ns(config->clock),
                                        .text = text};

    if (config->progress)
        config->progress(config->progress_ctx, &p);
}

/* ---- which ---- */

struct item {
    char name[65];
    char *summary; /* as the box gave it before it was pulled last; NULL: it was not */
    struct one_result last;
    bool done; /* nothing more will come */
};

struct names {
    struct item *items;
    size_t n;
};

static void free_names(struct names *names)
{
    for (size_t i = 0; i < names->n; i++)
        free(names->items[i].summary);
    free(names->items);
}

/* The answer's names; those that no dataset has are a server's that means harm, and are passed over. */
static int take_names(const json_t *list, struct names *ret)
{
    const json_t *item;
    size_t i;

    if (json_array_size(list) > NAMES_MAX)
        return -EFBIG;
    ret->items = calloc(json_array_size(list) + 1, sizeof *ret->items);
    if (!ret->items)
        return -ENOMEM;
    json_array_foreach(list, i, item)
    {
        const char *name = json_string_value(json_object_get(item, "name"));

        if (name && ttf_name_ok(name) && name[0] != '.')
            (void)snprintf(ret->items[ret->n++].name, sizeof ret->items->name, "%s", name);
    }
    return 0;
}

static int ask_names(struct wire *wire, struct names *ret, struct ttf_err *err)
{
    char *text = NULL;
    json_t *json;
    size_t n;
    int r = pull_wire_get_text(wire, "/datasets", 0, -1, LIST_MAX, &text, &n, err);

    if (r < 0)
        return r;
    r = ttf_json_parse(text, n, &json, NULL);
    free(text);
    if (r < 0)
        return ttf_err_set(err, r == -EINVAL ? -EPROTO : r, "/datasets",
                           "the box's answer is no JSON");
    r = take_names(json_object_get(json, "datasets"), ret);
    json_decref(json);
    if (r == -EFBIG)
        return ttf_err_set(err, r, "/datasets", "the box says that it has more than %d datasets",
                           NAMES_MAX);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory") : 0;
}

static int given_names(const struct ttf_pull_config *config, struct names *ret, struct ttf_err *err)
{
    size_t n = 0;

    while (config->names[n])
        n++;
    ret->items = calloc(n + 1, sizeof *ret->items);
    if (!ret->items)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    for (; ret->n < n; ret->n++) {
        const char *name = config->names[ret->n];

        if (!ttf_name_ok(name) || name[0] == '.')
            return ttf_err_set(err, -EINVAL, name, "is no dataset's name");
        (void)snprintf(ret->items[ret->n].name, sizeof ret->items->name, "%s", name);
    }
    return 0;
}

/* ---- one after another ---- */

/* The wire failed at a file. At the same one for the third time, without any other having come: it is left out. */
static void note_stuck(const struct one_result *one, char last[192], unsigned *times,
                       struct one_skips *skips)
{
    if (!*one->stuck || strcmp(one->stuck, last) != 0)
        *times = 0;
    (void)snprintf(last, 192, "%s", one->stuck);
    if (*one->stuck && ++*times == 3 && skips->n < ONE_SKIPS_MAX)
        (void)snprintf(skips->paths[skips->n++], sizeof skips->paths[0], "%s", one->stuck);
}

/* Bytes of a file that are here so far. */
static int64_t landed(const struct ttf_pull_config *config, const char *name, const char *path)
{
    struct ttf_io_stat st = {0};
    char temporary[600];

    (void)snprintf(temporary, sizeof temporary, "%s/%s/%s.tmp", config->dest, name, path);
    return config->io->ops->stat(config->io, temporary, &st) < 0 ? 0 : st.bytes;
}

/* Until it is here as far as the box has it now: cut off, it goes on. */
static int persist(const struct ttf_pull_config *config, struct wire *wire, struct crew *crew,
                   const char *name, struct one_result *ret, struct ttf_err *err)
{
    struct one_skips skips = {0};
    char stuck[192] = "";
    int64_t files = 0, wait_ns = POLL_NS, had = 0, here;
    unsigned tries = 0, times = 0;

    for (;;) {
        int64_t before = pull_wire_bytes(wire), files_before = files;
        char text[700];
        int r;

        memset(err, 0, sizeof *err);
        r = one_pull(config, wire, crew, name, &skips, ret, err);
        files += ret->files;
        ret->files = files;
        if (!pull_wire_may_pass(r) || told_to_stop(config))
            return r;
        if (files > files_before || pull_wire_bytes(wire) > before + PROGRESS_BYTES) {
            tries = 0;
            wait_ns = POLL_NS;
        }
        here = landed(config, name, ret->stuck);
        if (here > had) /* the wire is bad, not the file: a cable that is pulled again and again */
            times = 0;
        had = here;
        note_stuck(ret, stuck, &times, &skips);
        if (++tries >= TRIES && !config->follow)
            return r;
        ttf_err_hint(err, "it is asked again");
        (void)ttf_err_text(err, text, sizeof text);
        say(config, wire, name, text);
        pause_ns(config, tries <= 1 ? POLL_NS / 5 : wait_ns);
        if (tries > 1)
            wait_ns = 2 * wait_ns < WAIT_MOST ? 2 * wait_ns : WAIT_MOST;
    }
}

/* One dataset, unless the box says just what it said before. */
static int pull_item(const struct ttf_pull_config *config, struct wire *wire, struct crew *crew,
                     struct item *item, struct ttf_err *err)
{
    char url[128], *summary = NULL;
    size_t n;
    int r;

    (void)snprintf(url, sizeof url, "/datasets/%s", item->name);
    if (pull_wire_get_text(wire, url, 0, -1, SUMMARY_MAX, &summary, &n, NULL) < 0)
        summary = NULL;
    if (summary && item->summary && strcmp(summary, item->summary) == 0) {
        free(summary);
        return 0;
    }
    r = persist(config, wire, crew, item->name, &item->last, err);
    free(item->summary);
    item->summary = r == 0 ? summary : NULL;
    if (r < 0)
        free(summary);
    item->done = r == 0 && item->last.box_sealed && (item->last.sealed || item->last.damaged > 0);
    return r;
}

static void add_up(const struct item *item, bool pulled, struct ttf_pull_result *ret)
{
    const struct one_result *one = &item->last;

    ret->slots += one->slots;
    if (one->damaged > 0 && ret->damaged == 0)
        (void)snprintf(ret->first_damaged, sizeof ret->first_damaged, "%s", one->first_damaged);
    ret->damaged += one->damaged;
    ret->datasets += pulled;
    ret->sealed += one->sealed;
}

/* Does it end the whole, or is it this dataset's own trouble, behind which others may be well? */
static bool ends_all(int error)
{
    return error == -ECANCELED || error == -ENOSPC || error == -ENOMEM || error == -EDQUOT ||
           error == -EROFS || error == -EACCES || error == -EPROTONOSUPPORT ||
           pull_wire_may_pass(error);
}

/* All of them once. *ret_open: of some, more may come. The first error, when all had their turn. */
static int round_of_all(const struct ttf_pull_config *config, struct wire *wire, struct crew *crew,
                        struct names *names, struct ttf_pull_result *ret, bool *ret_open,
                        struct ttf_err *err)
{
    struct ttf_pull_result sum = {.files = ret->files};
    int first = 0;

    *ret_open = false;
    for (size_t i = 0; i < names->n && !ends_all(first) && !told_to_stop(config); i++) {
        struct item *item = &names->items[i];
        struct ttf_err why = {0};
        char text[700];
        int r;

        if (item->done)
            continue;
        item->last.files = 0;
        r = pull_item(config, wire, crew, item, &why);
        sum.files += item->last.files;
        *ret_open |= !item->done;
        if (r < 0 && !ends_all(r))
            say(config, wire, item->name, ttf_err_text(&why, text, sizeof text));
        if (r < 0 && (first == 0 || ends_all(r))) {
            first = r;
            *err = why;
        }
    }
    for (size_t i = 0; i < names->n; i++)
        add_up(&names->items[i], names->items[i].summary != NULL, &sum);
    *ret = sum;
    return first;
}

/* What there is to pull; a box that is followed may still be starting. */
static int find_names(const struct ttf_pull_config *config, struct wire *wire, struct names *ret,
                      struct ttf_err *err)
{
    int r;

    if (config->names)
        return given_names(config, ret, err);
    while ((r = ask_names(wire, ret, err)) < 0 && config->follow && pull_wire_may_pass(r) &&
           !told_to_stop(config)) {
        char text[700];

        say(config, wire, "the box", ttf_err_text(err, text, sizeof text));
        pause_ns(config, 2 * POLL_NS);
    }
    return r;
}

static int pull_with(const struct ttf_pull_config *config, struct wire *wire,
                     struct ttf_pull_result *ret, struct ttf_err *err)
{
    struct names names = {0};
    struct crew *crew = NULL;
    bool open = false;
    int r = find_names(config, wire, &names, err);

    if (r == 0)
        r = crew_create(config, wire, &crew, err);
    if (r == 0)
        r = ttf_io_mkdirs(config->io, config->dest, err);
    while (r == 0) {
        r = round_of_all(config, wire, crew, &names, ret, &open, err);
        if (r < 0 || !config->follow || !open || told_to_stop(config))
            break;
        pause_ns(config, POLL_NS);
    }
    crew_destroy(crew);
    free_names(&names);
    if (r == -ECANCELED)
        r = 0;
    ret->stopped = told_to_stop(config);
    ret->bytes = pull_wire_bytes(wire);
    if (r == 0 && ret->damaged > 0) {
        ttf_err_set(err, -TTF_EDAMAGED, ret->first_damaged,
                    "is damaged on the box, as %lld of its files are; all else is here",
                    (long long)ret->damaged);
        r = -TTF_EDAMAGED;
    }
    return r;
}

int ttf_pull(const struct ttf_pull_config *config, struct ttf_pull_result *ret, struct ttf_err *err)
{
    struct ttf_err unwanted = {0};
    struct wire *wire;
    int r;

    *ret = (struct ttf_pull_result){0};
    if (!err)
        err = &unwanted;
    r = pull_wire_create(config, &wire, err);
    if (r < 0)
        return r;
    r = pull_with(config, wire, ret, err);
    pull_wire_destroy(wire);
    return r;
}

int ttf_pull_list(const struct ttf_pull_config *config, char **ret_text, struct ttf_err *err)
{
    struct wire *wire;
    size_t n;
    int r = pull_wire_create(config, &wire, err);

    if (r < 0)
        return r;
    r = pull_wire_get_text(wire, "/datasets", 0, -1, LIST_MAX, ret_text, &n, err);
    pull_wire_destroy(wire);
    return r;
}
