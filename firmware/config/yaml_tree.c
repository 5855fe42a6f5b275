/* SPDX-License-Identifier: Apache-2.0 */
/* yaml_tree.c: libyaml's events into a tree; see yaml_tree.h. */
#include "yaml_tree.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

struct builder {
    const char *name;
    struct yaml_node *root;
    struct yaml_node *open; /* the map or list being filled */
    unsigned depth, nodes, documents;
    char *key; /* of the next value in a map */
    unsigned key_line, key_col;
    struct ttf_err *err;
};

static int fail(const struct builder *b, unsigned line, unsigned col, const char *what,
                const char *detail, const char *hint)
{
    char where[256];

    snprintf(where, sizeof where, "%.200s:%u:%u", b->name, line, col);
    ttf_err_set(b->err, -EINVAL, where, "%s%.100s", what, detail);
    ttf_err_hint(b->err, "%s", hint);
    return -EINVAL;
}

static void node_free(struct yaml_node *node)
{
    while (node) {
        struct yaml_node *next = node->next;

        node_free(node->child);
        free(node->text);
        free(node->key);
        free(node);
        node = next;
    }
}

static void append(struct yaml_node *parent, struct yaml_node *node)
{
    node->parent = parent;
    if (parent->last)
        parent->last->next = node;
    else
        parent->child = node;
    parent->last = node;
    parent->n++;
}

/* A key of the open map: remembered until its value comes. */
static int take_key(struct builder *b, const char *text, unsigned line, unsigned col)
{
    const struct yaml_node *twin = yaml_child(b->open, text);
    char hint[96];

    if (twin) {
        snprintf(hint, sizeof hint, "it stands on line %u already: keep one of the two",
                 twin->key_line);
        return fail(b, line, col, "doubled key ", text, hint);
    }
    b->key = strdup(text);
    if (!b->key)
        return ttf_err_set(b->err, -ENOMEM, NULL, "no memory");
    b->key_line = line;
    b->key_col = col;
    return 0;
}

static int add_node(struct builder *b, enum yaml_kind kind, const yaml_event_t *event)
{
    unsigned line = (unsigned)event->start_mark.line + 1;
    unsigned col = (unsigned)event->start_mark.column + 1;
    const char *text = kind == YAML_SCALAR ? (const char *)event->data.scalar.value : NULL;

    if (text && strlen(text) != event->data.scalar.length)
        return fail(b, line, col, "a zero byte in the text", "", "write plain text");
    if (b->open && b->open->kind == YAML_MAP && !b->key) {
        if (!text)
            return fail(b, line, col, "a key must be a word", "", "write 'key: value'");
        return take_key(b, text, line, col);
    }
    if (++b->nodes > YAML_NODES_MAX)
        return fail(b, line, col, "more values than any plan or board has", "",
                    "20,000 at most are read");
    if (!b->open && b->root)
        return fail(b, line, col, "a second value", "", "one file holds one");
    struct yaml_node *node = calloc(1, sizeof *node);

    if (!node)
        return ttf_err_set(b->err, -ENOMEM, NULL, "no memory");
    node->kind = kind;
    node->file = b->name;
    node->line = line;
    node->col = col;
    node->key = b->key;
    node->key_line = b->key_line;
    node->key_col = b->key_col;
    b->key = NULL;
    if (b->open)
        append(b->open, node);
    else
        b->root = node;
    if (text) {
        node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
        node->text = strdup(text);
        return node->text ? 0 : ttf_err_set(b->err, -ENOMEM, NULL, "no memory");
    }
    if (++b->depth > YAML_DEPTH_MAX)
        return fail(b, line, col, "nested too deeply", "", "16 levels at most are read");
    b->open = node;
    return 0;
}

/* Of a value, a map or a list; NULL: none. */
static const char *tag_of(const yaml_event_t *event)
{
    const yaml_char_t *tag =
        event->type == YAML_SCALAR_EVENT           ? event->data.scalar.tag
        : event->type == YAML_MAPPING_START_EVENT  ? event->data.mapping_start.tag
        : event->type == YAML_SEQUENCE_START_EVENT ? event->data.sequence_start.tag
                                                   : NULL;

    return (const char *)tag;
}

static int take_event(struct builder *b, const yaml_event_t *event)
{
    unsigned line = (unsigned)event->start_mark.line + 1;
    unsigned col = (unsigned)event->start_mark.column + 1;
    const char *tag = tag_of(event);

    if (tag)
        return fail(b, line, col, "tags are not read: ", tag,
                    "leave it out: units say what a value is");
    switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
        if (++b->documents > 1)
            return fail(b, line, col, "a second document", "", "one file holds one: remove '---'");
        return 0;
    case YAML_ALIAS_EVENT:
        return fail(b, line, col, "aliases are not read: *", (const char *)event->data.alias.anchor,
                    "write the value out");
    case YAML_SCALAR_EVENT:
        return add_node(b, YAML_SCALAR, event);
    case YAML_MAPPING_START_EVENT:
        return add_node(b, YAML_MAP, event);
    case YAML_SEQUENCE_START_EVENT:
        return add_node(b, YAML_LIST, event);
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
        b->depth--;
        b->open = b->open ? b->open->parent : NULL;
        return 0;
    default:
        return 0;
    }
}

/* What libyaml found wrong, in one line of ours. */
static int malformed(const struct builder *b, const yaml_parser_t *parser)
{
    char what[200];

    if (parser->error == YAML_MEMORY_ERROR)
        return ttf_err_set(b->err, -ENOMEM, NULL, "no memory");
    snprintf(what, sizeof what, "%s%s%s", parser->context ? parser->context : "",
             parser->context ? ": " : "", parser->problem ? parser->problem : "unreadable text");
    unsigned line = (unsigned)parser->problem_mark.line + 1;
    unsigned col = (unsigned)parser->problem_mark.column + 1;

    if (parser->error == YAML_READER_ERROR) {
        line = 1;
        col = 1;
    }
    return fail(b, line, col, "this is not YAML: ", what,
                "write 'key: value' lines, indented by spaces, lists as '- value'");
}

/* Nothing, or nothing but a null. */
static bool is_empty(const struct yaml_node *root)
{
    return !root || (root->kind == YAML_SCALAR && !root->quoted && (!root->text || !*root->text));
}

static bool is_utf16(const char *text, size_t bytes)
{
    return bytes >= 2 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0);
}

int yaml_tree_parse(const char *name, const char *meant, const char *text, size_t bytes,
                    struct yaml_tree *ret, struct ttf_err *err)
{
    struct yaml_tree tree = {.name = strdup(name)};
    struct builder b = {.name = tree.name, .err = err};
    yaml_parser_t parser;
    int r = 0;

    if (!tree.name)
        return ttf_err_set(err, -ENOMEM, name, "no memory");
    if (is_utf16(text,
                 bytes)) { /* which libyaml would read, and whoever keeps the text would not */
        r = fail(&b, 1, 1, "the text is UTF-16", "", "save it as UTF-8");
        free(tree.name);
        return r;
    }
    if (!yaml_parser_initialize(&parser)) {
        free(tree.name);
        return ttf_err_set(err, -ENOMEM, name, "no memory");
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, bytes);
    for (bool end = false; r == 0 && !end;) {
        yaml_event_t event;

        if (!yaml_parser_parse(&parser, &event)) {
            r = malformed(&b, &parser);
            break;
        }
        end = event.type == YAML_STREAM_END_EVENT;
        r = take_event(&b, &event);
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    free(b.key);
    if (r == 0 && is_empty(b.root))
        r = fail(&b, 1, 1, "the file is empty", "", meant);
    tree.root = b.root;
    if (r < 0) {
        yaml_tree_free(&tree);
        return r;
    }
    *ret = tree;
    return 0;
}

void yaml_tree_free(struct yaml_tree *tree)
{
    node_free(tree->root);
    free(tree->name);
    for (unsigned i = 0; i < tree->n_sets; i++)
        free(tree->set_names[i]);
    memset(tree, 0, sizeof *tree);
}

int yaml_read_file(const char *path, char **ret_text, size_t *ret_bytes, struct ttf_err *err)
{
    FILE *f = fopen(path, "rbe");
    char *text = NULL;
    size_t n = 0;
    int r;

    if (!f) {
        r = -errno;
        return ttf_err_set(err, r, path, "cannot be opened: %s", strerrordesc_np(-r));
    }
    text = malloc(YAML_TEXT_MAX + 2);
    if (!text) {
        r = ttf_err_set(err, -ENOMEM, path, "no memory");
        goto out;
    }
    n = fread(text, 1, YAML_TEXT_MAX + 1, f);
    if (ferror(f)) {
        r = ttf_err_set(err, -EINVAL, path, "cannot be read");
        ttf_err_hint(err, "a YAML file is meant");
        goto out;
    }
    if (n > YAML_TEXT_MAX) {
        r = ttf_err_set(err, -EINVAL, path, "is larger than 1 MiB");
        ttf_err_hint(err, "a plan or board of a few lines is meant");
        goto out;
    }
    text[n] = '\0';
    *ret_text = text;
    *ret_bytes = n;
    text = NULL;
    r = 0;
out:
    free(text);
    (void)fclose(f);
    return r;
}

struct yaml_node *yaml_child(const struct yaml_node *map, const char *key)
{
    if (map->kind == YAML_MAP)
        for (struct yaml_node *c = map->child; c; c = c->next)
            if (strcmp(c->key, key) == 0)
                return c;
    return NULL;
}

static unsigned position(const struct yaml_node *node)
{
    unsigned i = 0;

    for (const struct yaml_node *c = node->parent->child; c != node; c = c->next)
        i++;
    return i;
}

const char *yaml_path(const struct yaml_node *node, char *buf, size_t size)
{
    size_t used = 0;

    buf[0] = '\0';
    if (!node->parent)
        return buf;
    yaml_path(node->parent, buf, size);
    used = strlen(buf);
    if (node->key)
        snprintf(buf + used, size - used, "%s%.60s", used ? "." : "", node->key);
    else
        snprintf(buf + used, size - used, "[%u]", position(node));
    return buf;
}

const struct yaml_node *yaml_locate(const struct yaml_tree *tree, const char *path)
{
    const struct yaml_node *at = tree->root;

    while (*path) {
        const struct yaml_node *next = NULL;
        char name[96];
        size_t n;

        if (*path == '[') {
            unsigned long i = strtoul(path + 1, NULL, 10);

            if (at->kind == YAML_LIST)
                for (next = at->child; next && i; i--)
                    next = next->next;
            else if (i == 0)
                next = at; /* a single map where a list is allowed */
            path += strcspn(path, "]");
            path += *path == ']';
        } else {
            path += *path == '.';
            n = strcspn(path, ".[");
            if (n == 0 || n >= sizeof name)
                break;
            memcpy(name, path, n);
            name[n] = '\0';
            path += n;
            next = yaml_child(at, name);
            /* `shot:` is short for `shots:` with one entry. */
            if (!next && n > 1 && name[n - 1] == 's') {
                name[n - 1] = '\0';
                next = yaml_child(at, name);
            }
        }
        if (!next)
            break;
        at = next;
    }
    return at;
}

/* The child of that key, made (a map) where it is missing. NULL: no memory. */
static struct yaml_node *child_or_new(struct yaml_node *map, const char *key)
{
    struct yaml_node *node = yaml_child(map, key);

    if (node)
        return node;
    node = calloc(1, sizeof *node);
    if (!node)
        return NULL;
    node->key = strdup(key);
    if (!node->key) {
        free(node);
        return NULL;
    }
    node->kind = YAML_MAP;
    node->file = map->file;
    node->line = node->key_line = map->line;
    node->col = node->key_col = map->col;
    append(map, node);
    return node;
}

/* Gives *at the value's contents; `from` is left empty. */
static void move_value(struct yaml_node *at, struct yaml_node *from)
{
    node_free(at->child);
    free(at->text);
    at->kind = from->kind;
    at->text = from->text;
    at->quoted = from->quoted;
    at->file = from->file;
    at->line = at->key_line = from->line;
    at->col = at->key_col = from->col;
    at->child = from->child;
    at->last = from->last;
    at->n = from->n;
    for (struct yaml_node *c = at->child; c; c = c->next)
        c->parent = at;
    from->text = NULL;
    from->child = NULL;
}

int yaml_tree_set(struct yaml_tree *tree, const char *path, const char *text, struct ttf_err *err)
{
    struct yaml_tree value = {0};
    struct yaml_node *at = tree->root;
    char name[96], where[200];
    int r;

    snprintf(where, sizeof where, "--set %.150s", path);
    if (tree->n_sets == YAML_SETS_MAX)
        return ttf_err_set(err, -EINVAL, where, "more than %d settings", YAML_SETS_MAX);
    r = yaml_tree_parse(where, "--set PATH=VALUE is meant", text, strlen(text), &value, err);
    if (r < 0)
        return r;
    for (const char *p = path; *p;) {
        size_t n = strcspn(p, ".");

        if (is_empty(at)) { /* as "sim:" with nothing below */
            free(at->text);
            at->text = NULL;
            at->kind = YAML_MAP;
        }
        if (n == 0 || n >= sizeof name || at->kind != YAML_MAP) {
            r = ttf_err_set(err, -EINVAL, where, "there is no such place in %s", tree->name);
            ttf_err_hint(err, "write keys with points between, as in sim.optics.blur=0px");
            goto out;
        }
        memcpy(name, p, n);
        name[n] = '\0';
        at = child_or_new(at, name);
        if (!at) {
            r = ttf_err_set(err, -ENOMEM, where, "no memory");
            goto out;
        }
        p += n + (p[n] == '.');
    }
    if (value.root)
        move_value(at, value.root);
    tree->set_names[tree->n_sets++] = value.name; /* the moved nodes' file */
    value.name = NULL;
out:
    yaml_tree_free(&value);
    return r;
}
