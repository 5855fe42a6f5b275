/* SPDX-License-Identifier: Apache-2.0 */
/* board_file.c: the board language's top level; see README.md. */
#include "board_file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

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

#define C(member) offsetof(struct ttf_board_camera, member)

static const struct cfg_field CAMERA[] = {
    {"backend", NULL, 0, 0, 0, NULL, 0, 0},
    {"width", cfg_u32_px, C(mode.width), 16, 65535, "width of the mode asked for", 0, 0},
    {"height", cfg_u32_px, C(mode.height), 16, 65535, "height of the mode asked for", 0, 0},
    {0}};

static int read_cameras(const struct cfg_field *field, struct yaml_node *node, void *at,
                        struct ttf_err *err)
{
    struct ttf_board *board = at;
    unsigned n = 0;

    if (node->kind != YAML_MAP || node->n == 0)
        return cfg_error(node, err, field->meant, "a map of cameras is meant");
    if (node->n > TTF_BOX_CAMERAS_MAX)
        return cfg_error(node, err, field->meant, "more than %d cameras", TTF_BOX_CAMERAS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        struct ttf_board_camera *camera = &board->cameras[n];
        int r;

        c->used = true;
        if (strlen(c->key) >= sizeof camera->name || !*c->key)
            return cfg_error_at_key(c, err, "1 to 31 letters", "no name of a camera");
        memcpy(camera->name, c->key, strlen(c->key) + 1);
        if (c->kind != YAML_MAP)
            return cfg_error(c, err, "write {backend: sim}", "a camera's description is meant");
        r = board_backend(c, TTF_DEVICE_CAMERA, &camera->backend, err);
        if (r == 0)
            r = cfg_map(CAMERA, c, camera, err);
        if (r < 0)
            return r;
    }
    board->n_cameras = n;
    board->device[TTF_DEVICE_CAMERA] = board->cameras[0].backend;
    return 0;
}

static const struct cfg_field DEVICE[] = {{"backend", NULL, 0, 0, 0, NULL, 0, 0}, {0}};

/* `clock:` and `watchdog:`. The field's lo is the kind of device. */
static int read_device(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    enum ttf_device_kind kind = (enum ttf_device_kind)(int)field->lo;
    struct ttf_board *board = at;
    int r;

    if (node->kind == YAML_SCALAR && strcmp(node->text, "none") == 0 && kind != TTF_DEVICE_CLOCK) {
        board->device[kind] = NULL;
        return 0;
    }
    if (node->kind != YAML_MAP)
        return cfg_error(node, err, "write {backend: sim}", "a device's description is meant");
    r = board_backend(node, kind, &board->device[kind], err);
    return r < 0 ? r : cfg_map(DEVICE, node, board, err);
}

static const struct cfg_field PANEL[] = {{"backend", NULL, 0, 0, 0, NULL, 0, 0},
                                         {"door_switch", cfg_bool,
                                          offsetof(struct ttf_board, sim.door_switch), 0, 0,
                                          "whether the box feels its door, true or false", 0, 0},
                                         {0}};

static int read_panel(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_board *board = at;
    int r;

    (void)field;
    if (node->kind == YAML_SCALAR && strcmp(node->text, "none") == 0) {
        board->device[TTF_DEVICE_PANEL] = NULL;
        return 0;
    }
    if (node->kind != YAML_MAP)
        return cfg_error(node, err, "write {backend: sim}", "a device's description is meant");
    r = board_backend(node, TTF_DEVICE_PANEL, &board->device[TTF_DEVICE_PANEL], err);
    return r < 0 ? r : cfg_map(PANEL, node, board, err);
}

#define B(member) offsetof(struct ttf_board, member)

static const struct cfg_field BOARD[] = {
    {"board", cfg_text64, B(name), 0, 0, "the board's name, as 'board: sim'", 0, true},
    {"title", cfg_text128, B(title), 0, 0, "a line for people", 0, 0},
    {"serial", cfg_text64, B(serial), 0, 0, "the box's serial number", 0, 0},
    {"cameras", read_cameras, 0, 0, 0, "a map, as 'cameras: {main: {backend: sim}}'", 0, true},
    {"clock", read_device, 0, TTF_DEVICE_CLOCK, 0, "the clock's back-end", 0, true},
    {"lamps", board_read_lamps, 0, 0, 0, "a map of lamps, or none", 0, 0},
    {"sensors", board_read_sensors, 0, 0, 0, "a map of sensors, or none", 0, 0},
    {"guardian", board_read_guardian, 0, 0, 0, "the lamp guardian's socket, door and temperature",
     0, 0},
    {"panel", read_panel, 0, 0, 0, "light, button and door, or none", 0, 0},
    {"watchdog", read_device, 0, TTF_DEVICE_WATCHDOG, 0, "the watchdog's back-end, or none", 0, 0},
    {"sim", board_read_sim, 0, 0, 0, "the simulated box's model", 0, 0},
    {0}};

/* Paths in a board count from the board's own folder. */
static void from_folder_of(const char *file, char path[512])
{
    const char *slash = strrchr(file, '/');
    char whole[PATH_MAX];

    if (!*path || *path == '/' || !slash)
        return;
    snprintf(whole, sizeof whole, "%.*s/%s", (int)(slash - file), file, path);
    if (strlen(whole) < 512)
        memcpy(path, whole, strlen(whole) + 1);
}

static int decode_board(struct yaml_node *root, struct ttf_board *board, struct ttf_err *err)
{
    int r;

    ttf_sim_config_defaults(&board->sim);
    snprintf(board->scene.name, sizeof board->scene.name, "grass");
    board->scene.span_ns = 7 * TTF_NS_PER_DAY;
    snprintf(board->serial, sizeof board->serial, "SIM-0001");
    if (root->kind != YAML_MAP)
        return cfg_error(root, err, "write 'board: NAME', 'cameras:' and 'clock:'",
                         "a board's description holds keys");
    board->guardian.door = -1;
    r = cfg_map(BOARD, root, board, err);
    if (r == 0)
        r = board_finish_guardian(board, root, err);
    if (r < 0)
        return r;
    for (int i = 0; i < TTF_DEVICE_KIND_COUNT; i++)
        board->simulated |= board->device[i] && strcmp(board->device[i]->name, "sim") == 0;
    from_folder_of(board->path, board->scene.images);
    from_folder_of(board->path, board->scene.dataset);
    from_folder_of(board->path, board->guardian.file);
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
