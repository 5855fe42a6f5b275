/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/config/daemon_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decode.h"
#include "paths.h"
#include "ttf/base/time.h"
#include "ttf/config/plan_file.h"

#define D(member) offsetof(struct read, c.member)

#define NAME_MAX_BYTES 64 /* of a dataset: what can be asked for by HTTP */

/* As it is read: the dataset's name before it is a path. */
struct read {
    struct ttf_daemon_config c;
    char name[128];
};

/* set: {sim.clock: real}: keys of the board and YAML of their values, as --set has them. */
static int read_sets(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    struct ttf_daemon_config *config = &((struct read *)at)->c;

    if (node->kind != YAML_MAP || node->n > TTF_DAEMON_SETS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d keys is meant",
                         TTF_DAEMON_SETS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, config->n_sets++) {
        const char *text = cfg_scalar(c, field->meant, err);

        c->used = true;
        if (!text)
            return -EINVAL;
        if (!*c->key || strlen(c->key) >= sizeof config->set[0].path)
            return cfg_error_at_key(c, err, field->meant, "no key of a board");
        if (strlen(text) >= sizeof config->set[0].value)
            return cfg_error(c, err, "at most 255 letters", "too long");
        memcpy(config->set[config->n_sets].path, c->key, strlen(c->key) + 1);
        memcpy(config->set[config->n_sets].value, text, strlen(text) + 1);
    }
    return 0;
}

/* Somebody else's: ttfbox-alertd reads it, and a mistake in it is no reason not to capture. */
static int pass_over(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    (void)field;
    (void)at;
    (void)err;
    node->used = true;
    return 0;
}

/* A list of texts: "- 127.0.0.1:8417". */
static int read_list(const struct cfg_field *field, struct yaml_node *node, char (*ret)[128],
                     unsigned max, unsigned *ret_n, struct ttf_err *err)
{
    *ret_n = 0;
    if (node->kind != YAML_LIST)
        return cfg_error(node, err, field->meant, "a list is meant");
    for (struct yaml_node *c = node->child; c; c = c->next) {
        const char *text = cfg_scalar(c, field->meant, err);

        c->used = true;
        if (!text)
            return -EINVAL;
        if (*ret_n == max)
            return cfg_error(c, err, field->meant, "more than %u", max);
        if (!*text || strlen(text) >= sizeof ret[0])
            return cfg_error(c, err, field->meant, "a text of 1 to 127 letters is meant");
        memcpy(ret[(*ret_n)++], text, strlen(text) + 1);
    }
    return 0;
}

static int read_listen(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    struct ttf_daemon_config *config = &((struct read *)at)->c;

    config->listen_as_ever = false;
    return read_list(field, node, config->listen, TTF_DAEMON_LISTEN_MAX, &config->n_listen, err);
}

static int read_names(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_daemon_config *config = &((struct read *)at)->c;

    return read_list(field, node, config->names, TTF_DAEMON_NAMES_MAX, &config->n_names, err);
}

#define BOARD                                                                                     \
    {                                                                                             \
        "board", cfg_path512, D(board), 0, 0, "a board's name or file, as 'board: rpi4'", 0, true \
    }
#define SET                                                                           \
    {                                                                                 \
        "set", read_sets, 0, 0, 0, "changes of the board, as {sim.clock: real}", 0, 0 \
    }

static const struct cfg_field DAEMON[] = {
    BOARD,
    {"plan", cfg_path512, D(plan), 0, 0, "the plan's file, as 'plan: plan.yaml'", 0, 0},
    {"data", cfg_path512, D(data), 0, 0, "the folder of datasets, as 'data: /var/lib/ttfbox'", 0,
     true},
    {"dataset", cfg_text128, offsetof(struct read, name), 0, 0, "the dataset's name, as grass", 0,
     0},
    {"calibration", cfg_path512, D(calibration), 0, 0, "the folder of a calibration", 0, 0},
    {"zone", cfg_text64, D(zone), 0, 0, "the box's time zone, as Europe/Berlin", 0, 0},
    {"threads", cfg_u32, D(threads), 0, 1024, "threads that develop; 0: all processors", 0, 0},
    {"retry", cfg_i64_time, D(retry_ns), 1e8, 3.6e12,
     "how long to wait before what failed is tried again, as 5s", 0, 0},
    {"alerts", pass_over, 0, 0, 0, "who is told of what", 0, 0},
    {"state", cfg_path512, D(state), 0, 0, "a folder for what is to outlive a restart", 0, 0},
    {"token_file", cfg_path512, D(token_file), 0, 0, "the file of the token", 0, 0},
    {"listen", read_listen, 0, 0, 0,
     "a list of ADDRESS:PORT, INTERFACE:PORT and unix:PATH, as [127.0.0.1:8417]", 0, 0},
    {"names", read_names, 0, 0, 0, "a list of the box's names in the network", 0, 0},
    SET,
    {0}};

static const struct cfg_field BOARD_ONLY[] = {BOARD, SET, {0}};

static void find_board(const char *file, struct ttf_daemon_config *c)
{
    if (strchr(c->board, '/'))
        cfg_from_folder_of(file, c->board);
}

static int finish(struct read *read, const char *file, const struct yaml_node *root,
                  struct ttf_err *err)
{
    struct ttf_daemon_config *c = &read->c;
    const struct yaml_node *named = yaml_child(root, "dataset");
    int offset_s;

    if (!*c->plan && named)
        return cfg_error(named, err, "name the plan too", "a dataset without a plan");
    if (*c->plan && !*read->name)
        cfg_dataset_of_plan(c->plan, read->name);
    if (*c->plan && (strchr(read->name, '/') || read->name[0] == '.' || !*read->name ||
                     strlen(read->name) > NAME_MAX_BYTES))
        return cfg_error(named ? named : yaml_child(root, "plan"), err,
                         "as 'dataset: grass', of at most 64 letters", "'%s' is no dataset's name",
                         read->name);
    find_board(file, c);
    cfg_from_folder_of(file, c->plan);
    cfg_from_folder_of(file, c->data);
    cfg_from_folder_of(file, c->calibration);
    cfg_from_folder_of(file, c->state);
    cfg_from_folder_of(file, c->token_file);
    /* What is not said lies in the data folder, which is found already. */
    if (!*c->state &&
        snprintf(c->state, sizeof c->state, "%s/.ttfbox", c->data) >= (int)sizeof c->state)
        return cfg_error(yaml_child(root, "data"), err, "a shorter path", "is too long");
    if (!*c->token_file && snprintf(c->token_file, sizeof c->token_file, "%s/token", c->state) >=
                               (int)sizeof c->token_file)
        return cfg_error(yaml_child(root, "data"), err, "a shorter path", "is too long");
    if (ttf_zone_offset(c->zone, 0, &offset_s, err) < 0)
        return cfg_error(yaml_child(root, "zone"), err, "UTC, or a name as Europe/Berlin",
                         "this machine knows no time zone '%s'", c->zone);
    if (*c->plan && snprintf(c->dataset, sizeof c->dataset, "%s/%s", c->data, read->name) >=
                        (int)sizeof c->dataset)
        return cfg_error(yaml_child(root, "data"), err, "a shorter path", "is too long");
    return 0;
}

static int read_all(struct read *read, const char *file, struct yaml_node *root,
                    struct ttf_err *err)
{
    int r;

    read->c.retry_ns = 5 * TTF_NS_PER_S;
    read->c.n_listen = 3;
    read->c.listen_as_ever = true;
    (void)snprintf(read->c.listen[0], sizeof read->c.listen[0], "%s", TTF_DAEMON_LISTEN_TCP);
    (void)snprintf(read->c.listen[1], sizeof read->c.listen[1], "%s", TTF_DAEMON_LISTEN_UNIX);
    (void)snprintf(read->c.listen[2], sizeof read->c.listen[2], "%s", TTF_DAEMON_LISTEN_USB);
    r = cfg_map(DAEMON, root, read, err);
    return r < 0 ? r : finish(read, file, root, err);
}

static int read_board(struct read *read, const char *file, struct yaml_node *root,
                      struct ttf_err *err)
{
    int r;

    for (struct yaml_node *c = root->child; c; c = c->next)
        c->used = strcmp(c->key, "board") != 0 && strcmp(c->key, "set") != 0;
    r = cfg_map(BOARD_ONLY, root, read, err);
    if (r == 0)
        find_board(file, &read->c);
    return r;
}

typedef int read_fn(struct read *read, const char *file, struct yaml_node *root,
                    struct ttf_err *err);

static int parse(const char *name, const char *text, size_t bytes, const char *needs, read_fn *fn,
                 struct ttf_daemon_config *ret, struct ttf_err *err)
{
    struct read *read = calloc(1, sizeof *read);
    struct yaml_tree tree;
    int r;

    if (!read)
        return ttf_err_set(err, -ENOMEM, name, "no memory");
    r = yaml_tree_parse(name, needs, text, bytes, &tree, err);
    if (r < 0) {
        free(read);
        return r;
    }
    r = tree.root->kind != YAML_MAP ? cfg_error(tree.root, err, "write 'board: NAME' and so on",
                                                "a configuration holds keys")
                                    : fn(read, name, tree.root, err);
    if (r == 0)
        *ret = read->c;
    yaml_tree_free(&tree);
    free(read);
    return r;
}

int ttf_daemon_file_parse(const char *name, const char *text, size_t bytes,
                          struct ttf_daemon_config *ret, struct ttf_err *err)
{
    return parse(name, text, bytes, "a configuration needs 'board' and 'data'", read_all, ret, err);
}

int ttf_daemon_file_parse_board(const char *name, const char *text, size_t bytes,
                                struct ttf_daemon_config *ret, struct ttf_err *err)
{
    return parse(name, text, bytes, "a configuration needs a 'board'", read_board, ret, err);
}

typedef int parse_fn(const char *name, const char *text, size_t bytes,
                     struct ttf_daemon_config *ret, struct ttf_err *err);

static int load(const char *path, parse_fn *fn, struct ttf_daemon_config *ret, struct ttf_err *err)
{
    char *text = NULL;
    size_t bytes = 0;
    int r = yaml_read_file(path, &text, &bytes, err);

    if (r < 0)
        return r;
    r = fn(path, text, bytes, ret, err);
    free(text);
    return r;
}

const char *const *ttf_daemon_board_folders(void)
{
    static const char *const FOLDERS[] = {"/etc/ttfbox/boards", "boards", TTFBOX_INSTALLED_BOARDS,
                                          NULL};

    return FOLDERS;
}

int ttf_daemon_file_load(const char *path, struct ttf_daemon_config *ret, struct ttf_err *err)
{
    return load(path, ttf_daemon_file_parse, ret, err);
}

int ttf_daemon_file_load_board(const char *path, struct ttf_daemon_config *ret, struct ttf_err *err)
{
    return load(path, ttf_daemon_file_parse_board, ret, err);
}
