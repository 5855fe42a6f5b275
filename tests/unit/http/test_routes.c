/* SPDX-License-Identifier: Apache-2.0 */
/* test_routes.c: the table of what can be asked for, and openapi.yaml, which describes the same. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "ttf/http/routes.h"

static void a_path_names_its_route_and_parts(void **state)
{
    struct ttf_http_match m;

    (void)state;
    assert_int_equal(ttf_http_route_find("GET", "/api/v1/datasets/grass", &m), 0);
    assert_string_equal(m.route->pattern, "/api/v1/datasets/{name}");
    assert_string_equal(m.name, "grass");
    assert_int_equal(
        ttf_http_route_find("HEAD", "/api/v1/datasets/grass/files/frames/main/000001.tif", &m), 0);
    assert_string_equal(m.name, "grass");
    assert_string_equal(m.path, "frames/main/000001.tif");
    assert_int_equal(ttf_http_route_find("GET", "/api/v1/datasets/tar/tar", &m), 0);
    assert_string_equal(m.route->pattern, "/api/v1/datasets/{name}/tar");
}

static void what_no_pattern_has_is_not_there(void **state)
{
    static const char *const URLS[] = {"",
                                       "/x",
                                       "/web/",
                                       "/api/v1",
                                       "/api/v1/",
                                       "/api/v1/datasets/",
                                       "/api/v1/datasetss",
                                       "/api/v1/datasets//records",
                                       "/api/v1/datasets/grass/",
                                       "/api/v1/datasets/grass/files",
                                       "/api/v1/datasets/grass/files/",
                                       "/api/v1/datasets/grass/tar/x",
                                       "//api/v1/datasets",
                                       NULL};
    char url[400] = "/api/v1/datasets/";
    struct ttf_http_match m;

    (void)state;
    for (unsigned i = 0; URLS[i]; i++)
        if (ttf_http_route_find("GET", URLS[i], &m) != -ENOENT)
            fail_msg("'%s' is something", URLS[i]);
    memset(url + strlen(url), 'n', 300);
    assert_int_equal(ttf_http_route_find("GET", url, &m), -ENOENT);
}

static void a_dataset_cannot_be_changed(void **state)
{
    static const char *const METHODS[] = {"POST", "PUT",     "DELETE", "PATCH",
                                          "get",  "OPTIONS", "TRACE",  NULL};
    struct ttf_http_match m;

    (void)state;
    for (unsigned i = 0; METHODS[i]; i++)
        assert_int_equal(ttf_http_route_find(METHODS[i], "/api/v1/datasets/grass", &m), -ENOTSUP);
}

/* A path as it stands alone on a line of the description, two blanks in. */
static bool is_path(const char *line, char ret[256])
{
    size_t n = strcspn(line, "\n");

    if (strncmp(line, "  /", 3) != 0 || n < 4 || n > 250 || line[n - 1] != ':')
        return false;
    memcpy(ret, line + 2, n - 3);
    ret[n - 3] = '\0';
    return true;
}

static bool is_method(const char *line, char ret[16])
{
    static const char *const METHODS[] = {"get", "put", "post", "delete", "patch"};
    char expected[16];

    for (unsigned i = 0; i < sizeof METHODS / sizeof *METHODS; i++) {
        (void)snprintf(expected, sizeof expected, "    %s:\n", METHODS[i]);
        if (strcmp(line, expected) == 0) {
            for (unsigned c = 0; c <= strlen(METHODS[i]); c++)
                ret[c] = (char)(METHODS[i][c] & ~(METHODS[i][c] ? 0x20 : 0));
            return true;
        }
    }
    return false;
}

static bool in_table(const char *method, const char *path, bool open)
{
    const struct ttf_http_route *route;

    for (size_t i = 0; (route = ttf_http_route(i)); i++)
        if (strcmp(route->method, method) == 0 && strcmp(route->pattern, path) == 0)
            return open == (route->access == TTF_HTTP_OPEN || route->access == TTF_HTTP_CABLE);
    return false;
}

static void the_description_lists_the_table_and_nothing_else(void **state)
{
    FILE *file = fopen(OPENAPI, "re");
    char line[512], path[256] = "", method[16] = "";
    size_t described = 0, there = 0;
    bool open = false;

    (void)state;
    if (!file) {
        fail_msg("%s cannot be read", OPENAPI);
        return;
    }
    while (fgets(line, sizeof line, file)) {
        bool next_path = is_path(line, path), next_method = is_method(line, method);

        if (next_method || next_path)
            open = false;
        if (next_path)
            method[0] = '\0';
        if (strcmp(line, "      security: []\n") == 0)
            open = true;
        if (strcmp(line, "      responses:\n") != 0)
            continue;
        described++;
        if (!in_table(method, path, open))
            fail_msg("%s %s (%s) is described, but no such route is there", method, path,
                     open ? "open" : "by token");
    }
    (void)fclose(file);
    while (ttf_http_route(there))
        there++;
    assert_int_equal(described, there);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_path_names_its_route_and_parts),
        cmocka_unit_test(what_no_pattern_has_is_not_there),
        cmocka_unit_test(a_dataset_cannot_be_changed),
        cmocka_unit_test(the_description_lists_the_table_and_nothing_else),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
