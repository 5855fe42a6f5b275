/* SPDX-License-Identifier: Apache-2.0 */
/* board_file.c: the board language's top level; see README.md. */
#include "board_file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "paths.h"

static const char *const DEVICE_KEYS[TTF_DEVICE_KIND_COUNT] = {
    [TTF_DEVICE_CAMERA] = "cameras", [TTF_DEVICE_CLOCK] = "clock",
    [TTF_DEVICE_LAMPS] = "lamps",    [TTF_DEVICE_SENSORS] = "sensors",
    [TTF_DEVICE_PANEL] = "panel",    [TTF_DEVICE_WATCHDOG] = "watchdog"};

int board_backend(struct yaml_node *map, enum ttf_device_kind kind,
                  const struct ttf_backend_entry **ret, struct ttf_err *err)
{
    struct yaml_node *node = yaml_child(map, "backend");
    const struct ttf_backend_entry *entry;
    char hint[200] = "known: ";
    const char *text;

    for (unsigned i = 0; (entry = ttf_backend_entry(i)); i++)
        if (entry->devices & 1u << kind)
            snprintf(hint + strlen(hint), sizeof hint - strlen(hint), "%s%s", i ? ", " : "",
                     entry->name);
    if (!node)
        return cfg_error(map, err, hint, "'backend' is missing: what drives it");
    node->used = true;
    text = cfg_scalar(node, hint, err);
    if (!text)
        return -EINVAL;
    entry = ttf_backend_find(text);
    if (!entry)
        return cfg_error(node, err, hint, "there is no back-end '%.40s'", text);
    if (!(entry->devices & 1u << kind))
        return cfg_error(node, err, hint, "back-end '%.40s' drives no %s", text, DEVICE_KEYS[kind]);
    *ret = entry;
    return 0;
}

#define B(member) offsetof(struct ttf_board, member)

static const struct cfg_field BOARD[] = {
    {"board", cfg_text64, B(name), 0, 0, "the board's name, as 'board: sim'", 0, true},
    {"title", cfg_text128, B(title), 0, 0, "a line for people", 0, 0},
    {"serial", cfg_text64, B(serial), 0, 0, "the box's serial number", 0, 0},
    {"cameras", board_read_cameras, 0, 0, 0, "a map, as 'cameras: {main: {backend: sim}}'", 0,
     true},
    {"clock", board_read_device, 0, TTF_DEVICE_CLOCK, 0, "the clock's back-end", 0, true},
    {"lamps", board_read_lamps, 0, 0, 0, "a map of lamps, or none", 0, 0},
    {"sensors", board_read_sensors, 0, 0, 0, "a map of sensors, or none", 0, 0},
    {"guardian", board_read_guardian, 0, 0, 0, "the lamp guardian's socket, door and temperature",
     0, 0},
    {"panel", board_read_panel, 0, 0, 0, "light, button and door, or none", 0, 0},
    {"watchdog", board_read_device, 0, TTF_DEVICE_WATCHDOG, 0, "the watchdog's back-end, or none",
     0, 0},
    {"machine", board_read_machine, 0, 0, 0, "what the computer in the box is", 0, 0},
    {"units", board_read_units, 0, 0, 0,
     "a list of the services that it runs: ttfbox-lampd, ttfboxd, ttfbox-preview, ttfbox-alertd, "
     "ttfbox-gadget, ttfbox-usbd",
     0, 0},
    {"gadget", board_read_gadget, 0, 0, 0, "what it is on the bus, as {functions: [streams]}", 0,
     0},
    {"lock", cfg_path512, B(lock), 0, 0, "the file that says who owns the box, or none", 0, 0},
    {"sim", board_read_sim, 0, 0, 0, "the simulated box's model", 0, 0},
    {0}};

/*
 * Simulated devices may stand beside real ones, to try out a box: whatever such a box yields says SIMULATED. Real ones
 * live in real time.
 */
static int finish_mixture(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err)
{
    bool machine = strcmp(board->device[TTF_DEVICE_CLOCK]->name, "machine") == 0;
    struct yaml_node *clock = yaml_child(root, "clock"), *sim = yaml_child(root, "sim");
    const char *real = NULL;

    for (int i = 0; i < TTF_DEVICE_KIND_COUNT; i++) {
        bool simulated = board->device[i] && strcmp(board->device[i]->name, "sim") == 0;

        for (unsigned c = 0; i == TTF_DEVICE_CAMERA && c < board->n_cameras; c++)
            if (strcmp(board->cameras[c].backend->name, "sim") == 0)
                simulated = true;
            else
                real = DEVICE_KEYS[i];
        board->simulated |= simulated;
        if (board->device[i] && !simulated && i != TTF_DEVICE_CLOCK)
            real = DEVICE_KEYS[i];
    }
    board->real = real != NULL;
    if (machine && sim && sim->kind == YAML_MAP && yaml_child(sim, "clock") &&
        !board->sim.real_time)
        return cfg_error(yaml_child(sim, "clock"), err, "leave it out, or write clock: real",
                         "a virtual clock beside the machine's");
    board->sim.real_time |= machine;
    if (real && !board->sim.real_time)
        return cfg_error(clock, err, "write clock: {backend: machine}",
                         "the clock is virtual, and '%s' lives in real time", real);
    return 0;
}

/* Two programs must not have one box. A box without real devices is nobody's. */
static void finish_lock(struct ttf_board *board)
{
    if (strcmp(board->lock, "none") == 0)
        board->lock[0] = '\0';
    else if (board->lock[0] == '\0' && board->real)
        (void)snprintf(board->lock, sizeof board->lock, "%s", TTF_BOARD_LOCK);
}

static int decode_board(struct yaml_node *root, struct ttf_board *board, struct ttf_err *err)
{
    int r;

    ttf_sim_config_defaults(&board->sim);
    snprintf(board->scene.name, sizeof board->scene.name, "grass");
    board->scene.span_ns = 7 * TTF_NS_PER_DAY;
    if (root->kind != YAML_MAP)
        return cfg_error(root, err, "write 'board: NAME', 'cameras:' and 'clock:'",
                         "a board's description holds keys");
    board->guardian.door = -1;
    r = cfg_map(BOARD, root, board, err);
    if (r == 0)
        r = board_finish_guardian(board, root, err);
    if (r < 0)
        return r;
    r = finish_mixture(board, root, err);
    if (r < 0)
        return r;
    r = board_finish_machine(board, root, err);
    if (r == 0)
        r = board_finish_services(board, root, err);
    if (r < 0)
        return r;
    finish_lock(board);
    if (board->simulated && board->serial[0] == '\0')
        snprintf(board->serial, sizeof board->serial, "SIM-0001");
    cfg_from_folder_of(board->path, board->lock);
    cfg_from_folder_of(board->path, board->panel.file);
    cfg_from_folder_of(board->path, board->scene.images);
    cfg_from_folder_of(board->path, board->scene.dataset);
    cfg_from_folder_of(board->path, board->guardian.file);
    if (!board->device[TTF_DEVICE_LAMPS] && !yaml_child(root, "lamps"))
        board->sim.n_lamps = 0;
    if (!board->device[TTF_DEVICE_SENSORS] && !yaml_child(root, "sensors"))
        board->sim.n_sensors = 0;
    return 0;
}

int ttf_board_parse(const char *name, const char *text, size_t bytes,
                    const struct ttf_board_set *sets, unsigned n_sets, struct ttf_board *ret,
                    struct ttf_err *err)
{
    struct ttf_board *board = calloc(1, sizeof *board);
    struct yaml_tree tree;
    int r;

    if (!board)
        return ttf_err_set(err, -ENOMEM, name, "no memory");
    snprintf(board->path, sizeof board->path, "%s", name);
    r = yaml_tree_parse(name, "a board needs at least 'board', 'cameras' and 'clock'", text, bytes,
                        &tree, err);
    if (r < 0) {
        free(board);
        return r;
    }
    for (unsigned i = 0; r == 0 && i < n_sets; i++)
        r = yaml_tree_set(&tree, sets[i].path, sets[i].value, err);
    if (r == 0)
        r = decode_board(tree.root, board, err);
    if (r == 0 && board->simulated) {
        r = ttf_sim_config_check(&board->sim, err);
        if (r < 0 && err && !strchr(err->where, ':')) {
            char field[128];
            const struct yaml_node *node;

            snprintf(field, sizeof field, "sim.%.120s", err->where);
            node = yaml_locate(&tree, field);
            ttf_err_prefix(err, "%.120s", err->where);
            snprintf(err->where, sizeof err->where, "%.200s:%u:%u", node->file, node->line,
                     node->col);
        }
    }
    if (r == 0)
        *ret = *board;
    yaml_tree_free(&tree);
    free(board);
    return r;
}

int ttf_board_load(const char *path, const struct ttf_board_set *sets, unsigned n_sets,
                   struct ttf_board *ret, struct ttf_err *err)
{
    char *text = NULL;
    size_t bytes = 0;
    int r = yaml_read_file(path, &text, &bytes, err);

    if (r < 0)
        return r;
    r = ttf_board_parse(path, text, bytes, sets, n_sets, ret, err);
    free(text);
    return r;
}

static bool is_kind(const char *path, mode_t kind)
{
    struct stat st;

    return stat(path, &st) == 0 && (st.st_mode & S_IFMT) == kind;
}

int ttf_board_locate(const char *name, const char *const *folders, char *ret_path, size_t size,
                     struct ttf_err *err)
{
    char path[PATH_MAX], tried[200] = "";

    if (is_kind(name, S_IFREG)) {
        snprintf(ret_path, size, "%s", name);
        return 0;
    }
    snprintf(path, sizeof path, "%s/board.yaml", name);
    if (strchr(name, '/') && is_kind(path, S_IFREG)) {
        snprintf(ret_path, size, "%s", path);
        return 0;
    }
    for (; *folders && !strchr(name, '/'); folders++) {
        snprintf(path, sizeof path, "%s/%s/board.yaml", *folders, name);
        if (is_kind(path, S_IFREG)) {
            snprintf(ret_path, size, "%s", path);
            return 0;
        }
        /* Where the program was built or installed says nothing to whoever runs it. */
        if (**folders != '/')
            snprintf(tried + strlen(tried), sizeof tried - strlen(tried), " in %s/ or", *folders);
    }
    ttf_err_set(err, -ENOENT, name, "there is no such board");
    ttf_err_hint(err,
                 "give a board.yaml, or a name found%s among the boards that came with "
                 "the program",
                 tried);
    return -ENOENT;
}
