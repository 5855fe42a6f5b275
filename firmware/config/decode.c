/* SPDX-License-Identifier: Apache-2.0 */
/* decode.c: maps by tables, errors with their place, did-you-mean. */
#include "decode.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

TTF_PRINTF(5, 0)
static int set_error(const struct yaml_node *node, bool at_key, struct ttf_err *err,
                     const char *hint, const char *fmt, va_list args)
{
    char where[256], path[128], text[200];

    snprintf(where, sizeof where, "%.200s:%u:%u", node->file, at_key ? node->key_line : node->line,
             at_key ? node->key_col : node->col);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): its callers began it */
    vsnprintf(text, sizeof text, fmt, args);
    yaml_path(node, path, sizeof path);
    ttf_err_set(err, -EINVAL, where, "%s%s%s", path, *path ? ": " : "", text);
    if (hint)
        ttf_err_hint(err, "%s", hint);
    return -EINVAL;
}

int cfg_error(const struct yaml_node *node, struct ttf_err *err, const char *hint, const char *fmt,
              ...)
{
    va_list args;

    va_start(args, fmt);
    set_error(node, false, err, hint, fmt, args);
    va_end(args);
    return -EINVAL;
}

int cfg_error_at_key(const struct yaml_node *node, struct ttf_err *err, const char *hint,
                     const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    set_error(node, node->key != NULL, err, hint, fmt, args);
    va_end(args);
    return -EINVAL;
}

/* Edits (insert, drop, replace, swap of neighbours) from a to b; words beyond 40 letters are far. */
unsigned cfg_distance(const char *a, const char *b)
{
    unsigned row[3][42];
    size_t n = strlen(a), m = strlen(b);

    if (n > 40 || m > 40)
        return 1000;
    for (unsigned j = 0; j <= m; j++)
        row[0][j] = j;
    memcpy(row[2], row[0], sizeof row[2]);
    for (unsigned i = 1; i <= n; i++) {
        unsigned *now = row[i % 3], *up = row[(i + 2) % 3], *up2 = row[(i + 1) % 3];

        now[0] = i;
        for (unsigned j = 1; j <= m; j++) {
            unsigned best = up[j - 1] + (a[i - 1] != b[j - 1]);

            if (up[j] + 1 < best)
                best = up[j] + 1;
            if (now[j - 1] + 1 < best)
                best = now[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                up2[j - 2] + 1 < best)
                best = up2[j - 2] + 1;
            now[j] = best;
        }
    }
    return row[n % 3][m];
}

const char *cfg_nearest(const char *text, const char *const *names)
{
    const char *nearest = NULL;
    unsigned best = (unsigned)strlen(text) / 3 + 2;

    for (; *names; names++) {
        unsigned d = cfg_distance(text, *names);

        if (d < best) {
            best = d;
            nearest = *names;
        }
    }
    return nearest;
}

#define NAMES_MAX 64

/* "did you mean 'a'?" or "known here: a, b, c". */
static void suggest(const char *text, const char *const *names, char *buf, size_t size)
{
    const char *nearest = cfg_nearest(text, names);
    size_t used;

    if (nearest) {
        snprintf(buf, size, "did you mean '%s'?", nearest);
        return;
    }
    used = (size_t)snprintf(buf, size, "known here: ");
    for (unsigned i = 0; names[i] && used < size; i++)
        used += (size_t)snprintf(buf + used, size - used, "%s%s", i ? ", " : "", names[i]);
}

static int unknown_key(const struct cfg_field *fields, const struct yaml_node *node,
                       struct ttf_err *err)
{
    const char *names[NAMES_MAX + 1];
    char hint[256];
    unsigned n = 0;

    for (; fields[n].key && n < NAMES_MAX; n++)
        names[n] = fields[n].key;
    names[n] = NULL;
    suggest(node->key, names, hint, sizeof hint);
    return cfg_error_at_key(node, err, hint, "unknown key");
}

int cfg_map(const struct cfg_field *fields, struct yaml_node *map, void *base, struct ttf_err *err)
{
    if (map->kind == YAML_SCALAR && !map->quoted && !*map->text)
        return 0; /* `sim:` with nothing below it: an empty section */
    if (map->kind != YAML_MAP)
        return cfg_error(map, err, "write 'key: value' lines below it", "holds keys, not %s",
                         map->kind == YAML_LIST ? "a list" : "one value");
    /* Unknown keys first: a misspelt key is a better message than the missing one. */
    for (struct yaml_node *c = map->child; c; c = c->next) {
        for (const struct cfg_field *f = fields; f->key && !c->used; f++)
            c->used = strcmp(f->key, c->key) == 0;
        if (!c->used)
            return unknown_key(fields, c, err);
    }
    for (const struct cfg_field *f = fields; f->key; f++) {
        struct yaml_node *c = yaml_child(map, f->key);

        if (!c && f->required)
            return cfg_error(map, err, f->meant, "'%s' is missing", f->key);
        if (c && f->read) {
            int r = f->read(f, c, (char *)base + f->offset, err);

            if (r < 0)
                return r;
        }
    }
    return 0;
}

const char *cfg_scalar(struct yaml_node *node, const char *meant, struct ttf_err *err)
{
    if (node->kind != YAML_SCALAR) {
        cfg_error(node, err, meant, "one value is meant, not %s",
                  node->kind == YAML_LIST ? "a list" : "a map");
        return NULL;
    }
    if (!*node->text && !node->quoted) {
        cfg_error_at_key(node, err, meant, "has no value");
        return NULL;
    }
    return node->text;
}

int cfg_enum(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    const struct cfg_name *list = field->extra;
    const char *text = cfg_scalar(node, field->meant, err);
    const char *names[NAMES_MAX + 1];
    char hint[256];
    unsigned n = 0;

    if (!text)
        return -EINVAL;
    for (; list[n].name && n < NAMES_MAX; n++) {
        if (strcmp(list[n].name, text) == 0) {
            *(int *)at = list[n].value;
            return 0;
        }
        names[n] = list[n].name;
    }
    names[n] = NULL;
    suggest(text, names, hint, sizeof hint);
    return cfg_error(node, err, hint, "'%.60s' is none of its words", text);
}

int cfg_section(const struct cfg_field *field, struct yaml_node *node, void *at,
                struct ttf_err *err)
{
    return cfg_map(field->extra, node, at, err);
}
