/* SPDX-License-Identifier: Apache-2.0 */
/*
 * yaml_tree.h: a YAML text as a tree of nodes that know their line and column.
 *
 * A deliberately small YAML: one document, maps, lists and scalars. Every scalar
 * stays text. Aliases (the way to make 10 lines mean 10 billion nodes), tags and
 * doubled keys are refused; size, depth and number of nodes are bounded.
 */
#ifndef CONFIG_YAML_TREE_H
#define CONFIG_YAML_TREE_H

#include <stdbool.h>
#include <stddef.h>

#include "ttf/base/err.h"

#define YAML_TEXT_MAX  (1u << 20) /* bytes */
#define YAML_DEPTH_MAX 16
#define YAML_NODES_MAX 20000
#define YAML_SETS_MAX  64

enum yaml_kind {
    YAML_SCALAR = 0,
    YAML_MAP,
    YAML_LIST
};

struct yaml_node {
    enum yaml_kind kind;
    char *text;         /* of a scalar */
    bool quoted;        /* scalar in quotes: never a bare null */
    unsigned line, col; /* from 1, where the value stands */
    char *key;          /* within a map; else NULL */
    unsigned key_line, key_col;
    const char *file; /* where line and col count; belongs to the tree */
    struct yaml_node *parent, *child, *last, *next;
    unsigned n; /* children */
    bool used;  /* the decoder knows this key */
};

struct yaml_tree {
    char *name; /* as in messages */
    struct yaml_node *root;
    char *set_names[YAML_SETS_MAX]; /* what nodes that were set point to as their file */
    unsigned n_sets;
};

/*
 * Parses; *ret is to be freed with yaml_tree_free. -EINVAL with err->where
 * "name:line:col"; -ENOMEM. An empty text is -EINVAL; `meant` says what it should hold.
 */
int yaml_tree_parse(const char *name, const char *meant, const char *text, size_t bytes,
                    struct yaml_tree *ret, struct ttf_err *err);
void yaml_tree_free(struct yaml_tree *tree);

/* Reads a file of at most YAML_TEXT_MAX bytes, zero-terminated; free(). */
int yaml_read_file(const char *path, char **ret_text, size_t *ret_bytes, struct ttf_err *err);

/* The child of that key, or NULL. Does not mark it used. */
struct yaml_node *yaml_child(const struct yaml_node *map, const char *key);

/* Writes the node's path, as "shots[1].exposure"; "" for the root. Returns buf. */
const char *yaml_path(const struct yaml_node *node, char *buf, size_t size);

/* The node at a path, or the deepest of its ancestors that exists; the root at least. */
const struct yaml_node *yaml_locate(const struct yaml_tree *tree, const char *path);

/*
 * Puts `text` (YAML of one value) at `path` of maps, making maps on the way and
 * replacing what was there: an override from the command line. -EINVAL, -ENOMEM.
 */
int yaml_tree_set(struct yaml_tree *tree, const char *path, const char *text, struct ttf_err *err);

#endif
