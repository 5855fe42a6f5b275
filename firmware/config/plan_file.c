/* SPDX-License-Identifier: Apache-2.0 */
/* plan_file.c: the plan language's tables; see README.md. */
#include "ttf/config/plan_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decode.h"
#include "lamp_levels.h"
#include "ttf/base/time.h"
#include "ttf/dataset/copy.h"

struct ttf_plan_file {
    struct yaml_tree tree;
    char *text;
    struct ttf_plan plan;
};

#define P(member) offsetof(struct ttf_plan, member)
#define S(member) offsetof(struct ttf_plan_shot, member)
#define E(member) offsetof(struct ttf_exposure, member)
#define R(member) offsetof(struct ttf_region, member)

#define DAY ((double)TTF_NS_PER_DAY)

static const struct cfg_name MODES[] = {{"none", TTF_LAMPS_NONE},
                                        {"continuous", TTF_LAMPS_CONTINUOUS},
                                        {"capture-only", TTF_LAMPS_CAPTURE_ONLY},
                                        {"photoperiod", TTF_LAMPS_PHOTOPERIOD},
                                        {NULL, 0}};
static const struct cfg_name KEEPS[] = {{"default", TTF_KEEP_DEFAULT},
                                        {"raw", TTF_KEEP_RAW},
                                        {"developed", TTF_KEEP_DEVELOPED},
                                        {"both", TTF_KEEP_BOTH},
                                        {NULL, 0}};

/* "now" or an instant. */
static int read_start(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    if (node->kind == YAML_SCALAR && strcmp(node->text, "now") == 0) {
        *(int64_t *)at = 0;
        return 0;
    }
    int r = cfg_i64_utc(field, node, at, err);

    if (r == 0 && *(int64_t *)at == 0)
        *(int64_t *)at = 1; /* 1970, which has passed: 0 is now */
    return r;
}

/* "06:30" of local time, in seconds of the day. */
static int read_day_start(const struct cfg_field *field, struct yaml_node *node, void *at,
                          struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);

    if (!text)
        return -EINVAL;
    if (strlen(text) != 5 || text[2] != ':' || strspn(text, "0123456789:") != 5 ||
        strchr(text, ':') != text + 2 || strrchr(text, ':') != text + 2 ||
        (text[0] - '0') * 10 + text[1] - '0' > 23 || text[3] > '5')
        return cfg_error(node, err, field->meant, "'%.40s' is no time of day", text);
    *(int *)at =
        ((text[0] - '0') * 10 + text[1] - '0') * 3600 + ((text[3] - '0') * 10 + text[4] - '0') * 60;
    return 0;
}

static int read_brackets(const struct cfg_field *field, struct yaml_node *node, void *at,
                         struct ttf_err *err)
{
    struct ttf_plan_shot *shot = at;
    unsigned n = 0;

    if (node->kind != YAML_LIST || node->n > TTF_PLAN_BRACKETS_MAX)
        return cfg_error(node, err, field->meant, "a list of at most %d numbers is meant",
                         TTF_PLAN_BRACKETS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next) {
        int r = cfg_double(field, c, &shot->brackets[n], err);

        if (r < 0)
            return r;
        n++;
    }
    shot->n_brackets = n;
    return 0;
}

static int read_shot_levels(const struct cfg_field *field, struct yaml_node *node, void *at,
                            struct ttf_err *err)
{
    struct ttf_plan_shot *shot = at;

    return cfg_lamp_levels(field, node, shot->levels, &shot->n_levels, err);
}

static int read_day_levels(const struct cfg_field *field, struct yaml_node *node, void *at,
                           struct ttf_err *err)
{
    struct ttf_plan *plan = at;

    return cfg_lamp_levels(field, node, plan->day_levels, &plan->n_day_levels, err);
}

/* A dataset's name. */
static int read_group(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_plan *plan = at;
    const char *text = cfg_scalar(node, field->meant, err);

    if (!text)
        return -EINVAL;
    if (!ttf_name_ok(text))
        return cfg_error(node, err, field->meant, "'%.40s' is no name of a dataset", text);
    (void)snprintf(plan->group, sizeof plan->group, "%s", text);
    return 0;
}

static const struct cfg_field STORAGE[] = {{"second", cfg_path512,
                                            offsetof(struct ttf_plan, second_storage), 0, 0,
                                            "a folder on another disk, as /mnt/usb", 0, 0},
                                           {0}};

static const struct cfg_field WHITE_BALANCE[] = {
    {"red", cfg_u32_milli, E(wb_r_milli), 0.1, 16, "red gain relative to green, as 1.8", 0, 0},
    {"blue", cfg_u32_milli, E(wb_b_milli), 0.1, 16, "blue gain relative to green, as 1.5", 0, 0},
    {0}};

static const struct cfg_field SHOT[] = {
    {"stream", cfg_name32, S(stream), 0, 0, "the stream its images form, as 'main'", 0, 0},
    {"camera", cfg_name32, S(camera), 0, 0, "a camera of the board, as 'main'", 0, 0},
    {"channel", cfg_name32, S(channel), 0, 0, "a name for this light, as 'white'", 0, 0},
    {"lamps", read_shot_levels, 0, 0, 1000, "levels of lamps, as {left: 100%}", 0, 0},
    {"exposure", cfg_i64_time, S(exposure.exposure_ns), 1000, 1e12, "the exposure time, as 20ms", 0,
     0},
    {"gain", cfg_u32_milli, S(exposure.gain_milli), 0.1, 1000, "the gain, 1 = unity", 0, 0},
    {"white_balance", cfg_section, S(exposure), 0, 0, "camera's own {red: 1.8, blue: 1.5}",
     WHITE_BALANCE, 0},
    {"lens", cfg_u32_lens, S(exposure.lens_mdpt), 0, 100000, "the lens position, as 2.5dpt", 0, 0},
    {"brackets", read_brackets, 0, 0.001, 1000, "relative exposures, as [0.25, 1, 4]", 0, 0},
    {"average", cfg_u32, S(average), 1, TTF_PLAN_AVERAGE_MAX, "frames averaged per image", 0, 0},
    {0}};

static int read_shot(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    struct ttf_plan *plan = at;

    (void)field;
    return cfg_map(SHOT, node, &plan->shots[0], err);
}

/* The list: every shot begins as the default one, with a stream name of its own to be given. */
static int read_shots(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_plan *plan = at;
    const struct ttf_plan_shot start = plan->shots[0];
    unsigned n = 0;

    if (node->parent && yaml_child(node->parent, "shot"))
        return cfg_error_at_key(node, err, "keep one of the two", "stands beside 'shot'");
    if (node->kind != YAML_LIST || node->n == 0)
        return cfg_error(node, err, field->meant, "a list with '-' per shot is meant");
    if (node->n > TTF_PLAN_SHOTS_MAX)
        return cfg_error(node, err, field->meant, "%u shots are more than %d", node->n,
                         TTF_PLAN_SHOTS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        plan->shots[n] = start;
        int r = cfg_map(SHOT, c, &plan->shots[n], err);

        if (r < 0)
            return r;
    }
    plan->n_shots = n;
    return 0;
}

static const struct cfg_field LAMPS[] = {
    {"mode", cfg_enum, P(lamps), 0, 0, "none, continuous, capture-only or photoperiod", MODES, 0},
    {"settle", cfg_i64_time, P(settle_ns), 0, DAY, "time lamps burn before a shot, as 20s", 0, 0},
    {"day", cfg_i64_time, P(day_ns), 1e9, 366 * DAY, "length of the light phase, as 16h", 0, 0},
    {"period", cfg_i64_time, P(period_ns), 1e9, 366 * DAY, "day and night together, as 24h", 0, 0},
    {"phase", cfg_i64_time, P(phase_ns), 0, 366 * DAY, "when the first day begins, as 0s", 0, 0},
    {"day_start", read_day_start, P(day_start_s), 0, 0, "local time of day, as \"06:00\"", 0, 0},
    {"day_levels", read_day_levels, 0, 0, 1000, "growth light, as {top: 80%}", 0, 0},
    {0}};

static const struct cfg_field REGION[] = {
    {"x", cfg_u32_px, R(x), 0, 65535, "left edge, pixels", 0, 0},
    {"y", cfg_u32_px, R(y), 0, 65535, "top edge, pixels", 0, 0},
    {"width", cfg_u32_px, R(width), 1, 65535, "width, pixels", 0, true},
    {"height", cfg_u32_px, R(height), 1, 65535, "height, pixels", 0, true},
    {0}};

static const struct cfg_field PLAN[] = {
    {"title", cfg_text128, P(title), 0, 0, "a line for people", 0, 0},
    {"interval", cfg_i64_time, P(interval_ns), 1e8, 366 * DAY,
     "the time from slot to slot, as 'interval: 10min'", 0, true},
    {"count", cfg_i64, P(count), 1, 1e9, "the number of slots, as 'count: 1008'", 0, 0},
    {"until", NULL, 0, 0, 0, NULL, 0, 0}, /* needs interval and start: after the others */
    {"start", read_start, P(start_utc_ns), 0, 0, "now, or an instant as 2026-03-01T08:00:00Z", 0,
     0},
    {"zone", cfg_text64, P(zone), 0, 0, "a time zone, as Europe/Berlin", 0, 0},
    {"lamps", cfg_section, 0, 0, 0, "the lamp programme, as {mode: capture-only, settle: 20s}",
     LAMPS, 0},
    {"shot", read_shot, 0, 0, 0, "one shot", 0, 0},
    {"shots", read_shots, 0, 0, 0, "the exposures of a slot, at most 8", 0, 0},
    {"mains", cfg_double_mains, P(mains_hz), 0, 0, "50Hz, 60Hz or none", 0, 0},
    {"region", cfg_section, P(region), 0, 0, "part of the frame that is kept", REGION, 0},
    {"reference", cfg_section, P(reference), 0, 0, "patch whose level is watched", REGION, 0},
    {"keep", cfg_enum, P(keep), 0, 0, "raw, developed, both or default", KEEPS, 0},
    {"mm_per_px", cfg_double, P(mm_per_px), 1e-6, 1e3, "millimetres per pixel, as 0.05", 0, 0},
    {"storage", cfg_section, 0, 0, 0, "where it goes on, as {second: /mnt/usb}", STORAGE, 0},
    {"group", read_group, 0, 0, 0, "the name of a dataset beside this one, as 'grass'", 0, 0},
    {"reserve", cfg_i64_bytes, P(reserve_bytes), 0, 1e15, "disk kept free, as 256MiB", 0, 0},
    {0}};

/* `until: 7d` or an instant: kept, and the number of slots before it as long as all goes to plan. */
static int read_until(struct yaml_node *root, struct ttf_plan *plan, struct ttf_err *err)
{
    struct yaml_node *node = yaml_child(root, "until");
    const struct cfg_field span = {
        "until", cfg_i64_time, 0, 1, 36600 * DAY, "the whole run's length as 7d, or an instant", 0,
        0};
    int64_t length = 0, end = 0;
    int r;

    if (!node) {
        if (plan->count == 0)
            return cfg_error(root, err, "write 'count: 1008' or 'until: 7d'",
                             "neither 'count' nor 'until' says when it ends");
        return 0;
    }
    if (plan->count)
        return cfg_error_at_key(node, err, "keep one of the two", "stands beside 'count'");
    if (node->kind == YAML_SCALAR && strchr(node->text, 'T') && strchr(node->text, '-')) {
        if (plan->start_utc_ns == 0)
            return cfg_error(node, err, "give 'start' as an instant too, or 'until: 7d'",
                             "an instant needs a 'start'");
        r = cfg_i64_utc(&span, node, &end, err);
        length = end - plan->start_utc_ns;
        if (r == 0 && length <= 0)
            return cfg_error(node, err, "the end comes after the start", "is before 'start'");
        plan->end = TTF_END_UNTIL;
        plan->until_utc_ns = end;
    } else {
        r = cfg_i64_time(&span, node, &length, err);
        plan->end = TTF_END_LENGTH;
        plan->length_ns = length;
    }
    if (r < 0)
        return r;
    plan->count = (length - 1) / plan->interval_ns + 1;
    return 0;
}

static int decode_plan(struct ttf_plan_file *file, struct ttf_err *err)
{
    struct yaml_node *root = file->tree.root;
    struct yaml_node *lamps;
    int r;

    ttf_plan_defaults(&file->plan);
    if (root->kind != YAML_MAP)
        return cfg_error(root, err, "write 'interval: 10min' and 'count: 1008', a line each",
                         "a plan holds keys");
    r = cfg_map(PLAN, root, &file->plan, err);
    if (r == 0)
        r = read_until(root, &file->plan, err);
    if (r < 0)
        return r;
    lamps = yaml_child(root, "lamps");
    file->plan.photoperiod_local = lamps && yaml_child(lamps, "day_start");
    if (file->plan.photoperiod_local && yaml_child(lamps, "phase"))
        return cfg_error_at_key(yaml_child(lamps, "phase"), err, "keep one of the two",
                                "stands beside 'day_start'");
    return 0;
}

int ttf_plan_file_parse(const char *name, const char *text, size_t bytes,
                        struct ttf_plan_file **ret, struct ttf_err *err)
{
    struct ttf_plan_file *file = calloc(1, sizeof *file);
    int r;

    if (!file)
        return ttf_err_set(err, -ENOMEM, name, "no memory");
    r = yaml_tree_parse(name, "a plan needs at least 'interval: 10min' and 'count: 1008'", text,
                        bytes, &file->tree, err);
    if (r < 0)
        goto fail;
    file->text = strndup(text, bytes);
    if (!file->text) {
        r = ttf_err_set(err, -ENOMEM, name, "no memory");
        goto fail;
    }
    r = decode_plan(file, err);
    if (r < 0)
        goto fail;
    *ret = file;
    return 0;
fail:
    ttf_plan_file_free(file);
    return r;
}

int ttf_plan_file_load(const char *path, struct ttf_plan_file **ret, struct ttf_err *err)
{
    char *text = NULL;
    size_t bytes = 0;
    int r = yaml_read_file(path, &text, &bytes, err);

    if (r < 0)
        return r;
    r = ttf_plan_file_parse(path, text, bytes, ret, err);
    free(text);
    return r;
}

void ttf_plan_file_free(struct ttf_plan_file *file)
{
    if (!file)
        return;
    yaml_tree_free(&file->tree);
    free(file->text);
    free(file);
}

const struct ttf_plan *ttf_plan_file_plan(const struct ttf_plan_file *file)
{
    return &file->plan;
}

const char *ttf_plan_file_text(const struct ttf_plan_file *file)
{
    return file->text;
}

void ttf_plan_file_default_zone(struct ttf_plan_file *file, const char *zone)
{
    if (*zone && !yaml_child(file->tree.root, "zone"))
        (void)snprintf(file->plan.zone, sizeof file->plan.zone, "%s", zone);
}

int ttf_plan_file_resolve(struct ttf_plan_file *file, int64_t now_utc_ns, struct ttf_err *err)
{
    int64_t at = file->plan.start_utc_ns ? file->plan.start_utc_ns : now_utc_ns;
    int r = ttf_zone_offset(file->plan.zone, at, &file->plan.zone_offset_s, err);

    if (r < 0 && err) {
        snprintf(err->where, sizeof err->where, "zone");
        ttf_plan_file_place(file, err);
    }
    return r < 0 ? -EINVAL : 0;
}

/* Whether a path as "shots[1].exposure" begins with a key of plans: other errors name files. */
static bool is_plan_field(const char *path)
{
    size_t n = strcspn(path, ".[");

    for (const struct cfg_field *f = PLAN; f->key; f++)
        if (strlen(f->key) == n && strncmp(f->key, path, n) == 0)
            return true;
    return false;
}

void ttf_plan_file_place(const struct ttf_plan_file *file, struct ttf_err *err)
{
    const struct yaml_node *node;
    char field[256];

    if (!err || !is_plan_field(err->where))
        return;
    snprintf(field, sizeof field, "%s", err->where);
    node = yaml_locate(&file->tree, field);
    snprintf(err->where, sizeof err->where, "%.200s:%u:%u", node->file, node->line, node->col);
    ttf_err_prefix(err, "%s", field);
}

int ttf_plan_file_check_start(const struct ttf_plan_file *file, const struct ttf_utc *now,
                              struct ttf_err *err)
{
    int64_t start = file->plan.start_utc_ns, late = now->utc_ns - start;
    char begin[64], clock[64];

    if (start == 0 || now->trust == TTF_TRUST_NONE)
        return 0;
    if (now->uncertainty_ns != TTF_NS_UNKNOWN)
        late -= now->uncertainty_ns;
    if (late <= 0)
        return 0;
    ttf_err_set(err, -EINVAL, "start", "%s has passed: the box's clock says %s",
                ttf_utc_format(start, begin, sizeof begin),
                ttf_utc_format(now->utc_ns, clock, sizeof clock));
    ttf_err_hint(err, "give a time to come, or leave start out to begin as soon as it is ready");
    ttf_plan_file_place(file, err);
    return -EINVAL;
}

int ttf_plan_file_check_clock(const struct ttf_plan_file *file, const struct ttf_utc *now,
                              struct ttf_err *err)
{
    if (file->plan.start_utc_ns == 0 || now->trust != TTF_TRUST_NONE)
        return 0;
    ttf_err_set(err, -EBUSY, "start",
                "nobody vouches for the box's clock yet, so nobody knows when that is");
    ttf_err_hint(err, "let it be set first (by a PC or the network), or leave start out");
    ttf_plan_file_place(file, err);
    return -EBUSY;
}
