/* SPDX-License-Identifier: Apache-2.0 */
/*
 * test_openapi.c: openapi.yaml says what the table of routes says, and nothing else: who may, parameters, bodies, statuses
 * and content types. What the table says is what the server does (gives.h).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/http/routes.h"
#include "yaml_tree.h"

#define WORDS_MAX 32

/* Words in any order. */
struct words {
    char text[WORDS_MAX][64];
    unsigned n;
};

static void add(struct words *words, const char *fmt, ...) __attribute__((format(printf, 2, 3)));

static void add(struct words *words, const char *fmt, ...)
{
    va_list args;

    assert_true(words->n < WORDS_MAX);
    va_start(args, fmt);
    (void)vsnprintf(words->text[words->n++], sizeof words->text[0], fmt, args);
    va_end(args);
}

static bool has(const struct words *words, const char *word)
{
    for (unsigned i = 0; i < words->n; i++)
        if (strcmp(words->text[i], word) == 0)
            return true;
    return false;
}

static void are_the_same(const struct ttf_http_route *route, const char *what,
                         const struct words *described, const struct words *table)
{
    for (unsigned i = 0; i < described->n; i++)
        if (!has(table, described->text[i]))
            fail_msg("%s %s: %s '%s' is described, and is not so", route->method, route->pattern,
                     what, described->text[i]);
    for (unsigned i = 0; i < table->n; i++)
        if (!has(described, table->text[i]))
            fail_msg("%s %s: %s '%s' is not described", route->method, route->pattern, what,
                     table->text[i]);
    assert_int_equal(described->n, table->n);
}

/* ---- the description ---- */

static struct yaml_tree tree;

static int read_it(void **state)
{
    size_t bytes;
    char *text;
    int r;

    (void)state;
    if (yaml_read_file(OPENAPI, &text, &bytes, NULL) < 0)
        return -1;
    r = yaml_tree_parse("openapi.yaml", "", text, bytes, &tree, NULL);
    free(text);
    return r;
}

static int forget_it(void **state)
{
    (void)state;
    yaml_tree_free(&tree);
    return 0;
}

/* The node itself, or what it refers to. NULL allowed, and where there is none. */
static const struct yaml_node *meant(const struct yaml_node *node)
{
    const struct yaml_node *ref = node ? yaml_child(node, "$ref") : NULL;
    char path[256];

    if (!ref)
        return node;
    assert_int_equal(strncmp(ref->text, "#/", 2), 0);
    (void)snprintf(path, sizeof path, "%s", ref->text + 2);
    node = tree.root;
    for (char *at = path, *part; node && (part = strsep(&at, "/"));)
        node = yaml_child(node, part);
    if (!node)
        fail_msg("%s is not there", ref->text);
    return node;
}

static const struct yaml_node *child(const struct yaml_node *node, const char *key)
{
    node = meant(node);
    return node ? meant(yaml_child(node, key)) : NULL;
}

static const char *text_of(const struct yaml_node *node, const char *key)
{
    node = child(node, key);
    return node && node->text ? node->text : "";
}

static const struct yaml_node *described(const struct ttf_http_route *route)
{
    const struct yaml_node *node = child(child(tree.root, "paths"), route->pattern);
    char method[16] = "";

    for (unsigned i = 0; route->method[i]; i++)
        method[i] = (char)(route->method[i] | 0x20);
    node = child(node, method);
    if (!node)
        fail_msg("%s %s is not described", route->method, route->pattern);
    return node;
}

static void add_keys(struct words *words, const struct yaml_node *map)
{
    for (const struct yaml_node *n = map ? map->child : NULL; n; n = n->next)
        add(words, "%s", n->key);
}

/* Of errors any may be told besides, as the one that each can have is. */
static bool is_error(const char *status)
{
    return (*status == '4' && strcmp(status, "416") != 0) || *status == '5';
}

static void add_parameters(struct words *words, const struct yaml_node *node)
{
    const struct yaml_node *list = child(node, "parameters");

    for (const struct yaml_node *n = list ? list->child : NULL; n; n = n->next)
        add(words, "%s %s", text_of(n, "in"), text_of(n, "name"));
}

/* ---- */

static void each_route_is_described_and_nothing_else(void **state)
{
    const struct ttf_http_route *route;
    size_t n = 0, there = 0;

    (void)state;
    for (; (route = ttf_http_route(there)); there++)
        (void)described(route);
    for (const struct yaml_node *p = child(tree.root, "paths")->child; p; p = p->next)
        for (const struct yaml_node *m = p->child; m; m = m->next)
            n += strcmp(m->key, "parameters") != 0;
    assert_int_equal(n, there);
}

static void who_may_is_described(void **state)
{
    const struct ttf_http_route *route;

    (void)state;
    for (size_t i = 0; (route = ttf_http_route(i)); i++) {
        const struct yaml_node *security = yaml_child(described(route), "security");
        bool no_token = security && security->kind == YAML_LIST && security->n == 0;

        if (no_token != (route->access == TTF_HTTP_OPEN || route->access == TTF_HTTP_CABLE))
            fail_msg("%s %s: 'security: []' is wrong", route->method, route->pattern);
    }
}

static void parameters_are_those_that_are_read(void **state)
{
    const struct ttf_http_route *route;

    (void)state;
    for (size_t i = 0; (route = ttf_http_route(i)); i++) {
        const struct ttf_http_gives *gives = route->gives;
        struct words text = {0}, table = {0};

        if (strstr(route->pattern, "{name}"))
            add(&table, "path name");
        if (strstr(route->pattern, "{path}"))
            add(&table, "path path");
        if (gives->ranges)
            add(&table, "header Range");
        if (gives->resumes)
            add(&table, "header Last-Event-ID");
        if (route->access == TTF_HTTP_CABLE)
            add(&table, "header X-Ttfbox");
        for (const char *const *q = gives->query; q && *q; q++)
            add(&table, "query %s", *q);
        add_parameters(&text, child(child(tree.root, "paths"), route->pattern));
        add_parameters(&text, described(route));
        are_the_same(route, "parameter", &text, &table);
    }
}

static void bodies_are_those_that_are_taken(void **state)
{
    static const char *const TYPES[] = {[TTF_HTTP_JSON] = "application/json",
                                        [TTF_HTTP_JSON_MAYBE] = "application/json",
                                        [TTF_HTTP_YAML] = "application/yaml"};
    const struct ttf_http_route *route;

    (void)state;
    for (size_t i = 0; (route = ttf_http_route(i)); i++) {
        const struct yaml_node *body = child(described(route), "requestBody");
        struct words text = {0}, table = {0};

        if (route->body != TTF_HTTP_NO_BODY) {
            add(&table, "%s", TYPES[route->body]);
            add(&table, "required: %s", route->body == TTF_HTTP_JSON_MAYBE ? "false" : "true");
        }
        add_keys(&text, child(body, "content"));
        if (body)
            add(&text, "required: %s", text_of(body, "required"));
        are_the_same(route, "body", &text, &table);
    }
}

static void statuses_are_those_that_are_given(void **state)
{
    const struct ttf_http_route *route;

    (void)state;
    for (size_t i = 0; (route = ttf_http_route(i)); i++) {
        const struct ttf_http_gives *gives = route->gives;
        struct words text = {0}, table = {0};

        add(&table, "%u", gives->status);
        if (gives->none)
            add(&table, "204");
        if (gives->tagged)
            add(&table, "304");
        if (gives->ranges)
            add(&table, "206");
        if (gives->ranges)
            add(&table, "416");
        add(&table, "default");
        for (const struct yaml_node *n = child(described(route), "responses")->child; n;
             n = n->next)
            if (!is_error(n->key))
                add(&text, "%s", n->key);
        are_the_same(route, "status", &text, &table);
    }
}

static void types_are(const struct ttf_http_route *route, const char *status,
                      const struct words *table)
{
    const struct yaml_node *answer = child(child(described(route), "responses"), status);
    struct words text = {0};

    add_keys(&text, child(answer, "content"));
    are_the_same(route, "type", &text, table);
}

static void content_types_are_those_that_are_sent(void **state)
{
    const struct ttf_http_route *route;

    (void)state;
    for (size_t i = 0; (route = ttf_http_route(i)); i++) {
        struct words table = {0}, of_errors = {0};
        char status[16], type[64];

        for (const struct ttf_http_type *t = route->gives->types; t->end; t++) {
            (void)snprintf(type, sizeof type, "%.*s", (int)strcspn(t->type, ";"), t->type);
            if (!has(&table, type))
                add(&table, "%s", type);
        }
        add(&of_errors, "application/json");
        (void)snprintf(status, sizeof status, "%u", route->gives->status);
        types_are(route, status, &table);
        if (route->gives->ranges)
            types_are(route, "206", &table);
        for (const struct yaml_node *n = child(described(route), "responses")->child; n;
             n = n->next)
            if (is_error(n->key) || strcmp(n->key, "default") == 0)
                types_are(route, n->key, &of_errors);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_route_is_described_and_nothing_else),
        cmocka_unit_test(who_may_is_described),
        cmocka_unit_test(parameters_are_those_that_are_read),
        cmocka_unit_test(bodies_are_those_that_are_taken),
        cmocka_unit_test(statuses_are_those_that_are_given),
        cmocka_unit_test(content_types_are_those_that_are_sent),
    };

    return cmocka_run_group_tests(tests, read_it, forget_it);
}
