/* SPDX-License-Identifier: Apache-2.0 */
/* board_scene.c: `sim.scene:` and `sim.faults:` of a board. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"

#define C(member) offsetof(struct ttf_board_scene, member)
#define F(member) offsetof(struct ttf_fault, member)

#define SCENES_MAX 32

/* Refuses a name that no procedural scene has. */
static int check_name(const struct yaml_node *node, const char *name, struct ttf_err *err)
{
    const char *names[SCENES_MAX + 1];
    char hint[200] = "known: ";
    const char *near;
    unsigned n = 0;

    for (const char *s; n < SCENES_MAX && (s = ttf_scene_name(n)); n++)
        names[n] = s;
    names[n] = NULL;
    for (unsigned i = 0; names[i]; i++) {
        if (strcmp(names[i], name) == 0)
            return 0;
        snprintf(hint + strlen(hint), sizeof hint - strlen(hint), "%s%s", i ? ", " : "", names[i]);
    }
    near = cfg_nearest(name, names);
    if (near)
        snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return cfg_error(node, err, hint, "there is no scene '%.40s'", name);
}

static const struct cfg_field SCENE[] = {
    {"name", cfg_name32, C(name), 0, 0, "a procedural sample, as grass", 0, 0},
    {"images", cfg_path512, C(images), 0, 0, "a folder of pictures", 0, 0},
    {"dataset", cfg_path512, C(dataset), 0, 0, "a dataset's folder", 0, 0},
    {"span", cfg_i64_time, C(span_ns), 1e6, 36600.0 * (double)TTF_NS_PER_DAY,
     "the time from its first to its last state, as 7d", 0, 0},
    {0}};

int board_read_scene(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    struct ttf_board_scene *scene = &((struct ttf_board *)at)->scene;
    struct ttf_board_scene read = {.span_ns = scene->span_ns};
    unsigned given;
    int r;

    (void)field;
    if (node->kind == YAML_SCALAR)
        r = cfg_name32(&SCENE[0], node, read.name, err);
    else
        r = cfg_map(SCENE, node, &read, err);
    if (r < 0)
        return r;
    given = !!*read.name + !!*read.images + !!*read.dataset;
    if (given == 0) /* only a span */
        memcpy(read.name, scene->name, sizeof read.name);
    if (given > 1)
        return cfg_error(node, err, "keep one of name, images and dataset",
                         "more than one thing to look at");
    if (*read.name) {
        const struct yaml_node *name = yaml_child(node, "name");

        r = check_name(name ? name : node, read.name, err);
    }
    if (r == 0)
        *scene = read;
    return r;
}

static int read_kind(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    const char *names[TTF_FAULT_KIND_COUNT + 1];
    const char *text = cfg_scalar(node, field->meant, err);
    char hint[256] = "known: ";
    const char *near;
    int kind;

    if (!text)
        return -EINVAL;
    kind = ttf_fault_find(text);
    if (kind >= 0) {
        *(enum ttf_fault_kind *)at = (enum ttf_fault_kind)kind;
        return 0;
    }
    for (int i = 0; i < TTF_FAULT_KIND_COUNT; i++) {
        names[i] = ttf_fault_name((enum ttf_fault_kind)i);
        snprintf(hint + strlen(hint), sizeof hint - strlen(hint), "%s%s", i ? ", " : "", names[i]);
    }
    names[TTF_FAULT_KIND_COUNT] = NULL;
    near = cfg_nearest(text, names);
    if (near)
        snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return cfg_error(node, err, hint, "there is no fault '%.40s'", text);
}

#define LONG (36600.0 * (double)TTF_NS_PER_DAY)

static const struct cfg_field FAULT[] = {
    {"kind", read_kind, F(kind), 0, 0, "a fault by name, as frame-missing", 0, true},
    {"at", cfg_i64_time, F(at_ns), 0, LONG, "when, since the first power-on, as 3h", 0, 0},
    {"for", cfg_i64_time, F(duration_ns), 0, LONG, "how long, as 10min", 0, 0},
    {"rate", cfg_u32_ppm, F(rate_per_million), 1, 1e6, "share of chances, as 100ppm", 0, 0},
    {"amount", cfg_i64, F(amount), -1e9, 1e9, "how much, see the fault", 0, 0},
    {"target", cfg_name32, F(target), 0, 0, "the lamp's or sensor's name", 0, 0},
    {0}};

int board_read_faults(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_sim_config *sim = at;
    unsigned n = 0;

    if (node->kind == YAML_SCALAR && (!*node->text || strcmp(node->text, "none") == 0)) {
        sim->n_faults = 0;
        return 0;
    }
    if (node->kind != YAML_LIST || node->n > TTF_SIM_FAULTS_MAX)
        return cfg_error(node, err, field->meant, "a list of at most %d faults is meant",
                         TTF_SIM_FAULTS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        memset(&sim->faults[n], 0, sizeof sim->faults[n]);
        int r = cfg_map(FAULT, c, &sim->faults[n], err);

        if (r < 0)
            return r;
        if (yaml_child(c, "at") && yaml_child(c, "rate"))
            return cfg_error(c, err, "keep one of the two", "'at' and 'rate' exclude each other");
        if (!yaml_child(c, "at") && !yaml_child(c, "rate"))
            return cfg_error(c, err, "write at: 3h or rate: 100ppm", "says not when it strikes");
    }
    sim->n_faults = n;
    return 0;
}
