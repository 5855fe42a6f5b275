/* SPDX-License-Identifier: Apache-2.0 */
#include "boards.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check_board.h"
#include "listing.h"
#include "ttf/config/plan_file.h"

#define BOARDS_MAX 128
#define SENT_MAX   64 /* that lie here, sent by somebody */

/* Whose a board is. */
enum board_from {
    FROM_NOBODY = 0,
    FROM_BOX,    /* its own */
    FROM_SYSTEM, /* it came with the box */
    FROM_PERSON  /* it was sent */
};

static const char *sent_folder(const struct daemon *d, char ret[600])
{
    (void)snprintf(ret, 600, "%s/boards", d->config.state);
    return ret;
}

static const char *sent_path(const struct daemon *d, const char *name, char ret[700])
{
    char folder[600];

    (void)snprintf(ret, 700, "%s/%s" LISTING_SUFFIX, sent_folder(d, folder), name);
    return ret;
}

/* A board that was sent lies here; others may hide it. */
static bool is_sent(const struct daemon *d, const char *name, char ret_path[700])
{
    struct ttf_io_stat st;

    return d->io->ops->stat(d->io, sent_path(d, name, ret_path), &st) == 0 && st.is_regular;
}

/* The folder of a board of this name, in which its plans are; of one that was sent there is none. */
static enum board_from find_board(struct daemon *d, const char *name, char ret[600])
{
    char path[700];
    struct ttf_io_stat st;

    *ret = '\0';

    if (strcmp(name, d->board.name) == 0) {
        const char *slash = strrchr(d->board.path, '/');

        (void)snprintf(ret, 600, "%.*s", slash ? (int)(slash - d->board.path) : 1,
                       slash ? d->board.path : ".");
        return FROM_BOX;
    }
    for (const char *const *folder = ttf_daemon_board_folders(); *folder; folder++) {
        (void)snprintf(path, sizeof path, "%s/%s/board.yaml", *folder, name);
        if (d->io->ops->stat(d->io, path, &st) < 0 || !st.is_regular)
            continue;
        (void)snprintf(ret, 600, "%s/%s", *folder, name);
        return FROM_SYSTEM;
    }
    return is_sent(d, name, path) ? FROM_PERSON : FROM_NOBODY;
}

int boards_show(struct daemon *d, const char *name, const char *plan, char **ret_yaml,
                struct ttf_err *err)
{
    char folder[600], path[700];
    enum board_from from = find_board(d, name, folder);

    if (from == FROM_NOBODY)
        return ttf_err_set(err, -ENOENT, NULL, "there is no board of this name");
    if (from == FROM_PERSON && plan)
        return ttf_err_set(err, -ENOENT, NULL, "no plan comes with this board");
    if (from == FROM_PERSON)
        return listing_text(d->io, sent_path(d, name, path), "board", ret_yaml, err);
    if (!plan && from == FROM_BOX)
        return listing_text(d->io, d->board.path, "board", ret_yaml, err);
    (void)snprintf(path, sizeof path, "%s/%s%s" LISTING_SUFFIX, folder, plan ? "plans/" : "",
                   plan ? plan : "board");
    return listing_text(d->io, path, plan ? "plan" : "board", ret_yaml, err);
}

/* Does this file read as a plan? */
static bool is_plan(const char *folder, const char *name)
{
    struct ttf_plan_file *file = NULL;
    char path[700];
    bool is;

    (void)snprintf(path, sizeof path, "%s/%s" LISTING_SUFFIX, folder, name);
    is = ttf_plan_file_load(path, &file, NULL) == 0;
    ttf_plan_file_free(file);
    return is;
}

static void put_plans(struct daemon *d, const char *folder, struct ttf_json *json)
{
    struct listing names = {0};
    char plans[620];

    (void)snprintf(plans, sizeof plans, "%s/plans", folder);
    if (listing_read(d->io, plans, LISTING_PLANS_MAX, false, &names) == 0)
        for (unsigned i = 0; i < names.n; i++)
            if (is_plan(plans, names.name[i]))
                ttf_json_string(json, names.name[i]);
    free(names.name);
}

/* from, folder: as find_board found it. */
static void put_board(struct daemon *d, const char *name, enum board_from from, const char *folder,
                      struct ttf_json *json)
{
    ttf_json_object(json);
    ttf_json_kstring(json, "name", name);
    ttf_json_kbool(json, "sent", from == FROM_PERSON);
    ttf_json_key(json, "plans");
    ttf_json_array(json);
    if (*folder)
        put_plans(d, folder, json);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
}

/* Those of a folder, but for those that a board before them hides by its name. */
static int put_boards(struct daemon *d, const char *folder, bool sent, struct ttf_json *json)
{
    struct listing names;
    char where[600];
    int r = listing_read(d->io, folder, BOARDS_MAX, !sent, &names);

    for (unsigned i = 0; r == 0 && i < names.n; i++) {
        enum board_from from = find_board(d, names.name[i], where);

        if (from == (sent ? FROM_PERSON : FROM_SYSTEM))
            put_board(d, names.name[i], from, where, json);
    }
    free(names.name);
    return r;
}

int boards_list(struct daemon *d, char **ret_json, struct ttf_err *err)
{
    struct ttf_json json;
    char folder[600];
    enum board_from from = find_board(d, d->board.name, folder);
    int r = 0;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "own", d->board.name);
    ttf_json_key(&json, "boards");
    ttf_json_array(&json);
    put_board(d, d->board.name, from, folder, &json);
    for (const char *const *f = ttf_daemon_board_folders(); *f && r == 0; f++)
        r = put_boards(d, *f, false, &json);
    if (r == 0)
        r = put_boards(d, sent_folder(d, folder), true, &json);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    return listing_give(&json, r, ret_json, err);
}

/* ---- boards that are sent ---- */

static bool is_same_file(struct daemon *d, const char *a, const char *b)
{
    struct ttf_io_stat of_a, of_b;

    return d->io->ops->stat(d->io, a, &of_a) == 0 && d->io->ops->stat(d->io, b, &of_b) == 0 &&
           of_a.inode == of_b.inode && of_a.device == of_b.device;
}

/*
 * Does the configuration, as it is now, name this file, which is there? What it names holds the limits of lamps at the next start, of the guardian's
 * too, and is nobody's to change from a network. A configuration that cannot be read names whatever it likes.
 */
static bool is_configured(struct daemon *d, const char *path)
{
    struct ttf_daemon_config *config = malloc(sizeof *config);
    char named[512];
    bool is = true;

    if (config && ttf_daemon_file_load_board(d->options->config, config, NULL) == 0)
        is = ttf_board_locate(config->board, ttf_daemon_board_folders(), named, sizeof named,
                              NULL) == 0 &&
             is_same_file(d, path, named);
    free(config);
    return is;
}

static int not_yours(enum board_from from, struct ttf_err *err)
{
    return ttf_err_set(err, -EPERM, NULL, "%s",
                       from == FROM_BOX ? "this is the board of the box itself"
                                        : "this board came with the box");
}

/* Room for one more, and none of this name. */
static int may_send(struct daemon *d, const char *name, struct ttf_err *err)
{
    char folder[600];
    enum board_from from = find_board(d, name, folder);
    struct listing names;
    int r;

    if (from == FROM_PERSON) {
        ttf_err_set(err, -EEXIST, NULL, "a board of this name was sent before");
        ttf_err_hint(err, "take it away first, or take another name");
        return -EEXIST;
    }
    if (from != FROM_NOBODY) {
        r = not_yours(from, err);
        ttf_err_hint(err, "take another name");
        return r;
    }
    r = listing_read(d->io, sent_folder(d, folder), SENT_MAX, false, &names);
    if (r == 0 && names.n == SENT_MAX)
        r = -EEXIST;
    free(names.name);
    if (r == -EEXIST)
        return ttf_err_set(err, r, NULL, "%u boards were sent already: take one away first",
                           SENT_MAX);
    return r < 0 ? ttf_err_set(err, r, folder, "%s", strerrordesc_np(-r)) : 0;
}

int boards_put(struct daemon *d, const char *name, const char *yaml, size_t bytes, char **ret_json,
               struct ttf_err *err)
{
    char *json = NULL, folder[600], path[700];
    int r = check_board(yaml, bytes, name, &json, err);

    if (r < 0)
        return r;
    (void)pthread_mutex_lock(&d->plans);
    r = may_send(d, name, err);
    if (r == 0)
        r = ttf_io_mkdirs(d->io, sent_folder(d, folder), err);
    if (r == 0)
        r = ttf_io_write_file(d->io, sent_path(d, name, path), yaml, bytes, err);
    (void)pthread_mutex_unlock(&d->plans);
    if (r == 0)
        *ret_json = json;
    else
        free(json);
    return r;
}

/* What was sent, even where a board of the same name, which came later, hides it: it takes the place of another that could be sent. */
static int take_away(struct daemon *d, const char *name, struct ttf_err *err)
{
    char folder[600], path[700];
    enum board_from from;

    if (is_sent(d, name, path)) {
        if (is_same_file(d, path, d->board.path))
            return not_yours(FROM_BOX, err);
        if (is_configured(d, path))
            return ttf_err_set(err, -EPERM, NULL, "the box's configuration names this board");
        return listing_remove(d->io, sent_folder(d, folder), path, "board", err);
    }
    from = find_board(d, name, folder);
    return from == FROM_NOBODY ? ttf_err_set(err, -ENOENT, NULL, "there is no board of this name")
                               : not_yours(from, err);
}

int boards_delete(struct daemon *d, const char *name, struct ttf_err *err)
{
    int r;

    (void)pthread_mutex_lock(&d->plans);
    r = take_away(d, name, err);
    (void)pthread_mutex_unlock(&d->plans);
    return r;
}
