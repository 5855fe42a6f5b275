/* SPDX-License-Identifier: Apache-2.0 */
/* test_routes.c: the table of what can be asked for. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
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

/* A thread of connections that does would hold up all of its connections: half of the socket's. */
static void no_thread_of_connections_reads_a_whole_dataset(void **state)
{
    static const char *const URLS[] = {"/api/v1/datasets",
                                       "/api/v1/datasets/grass",
                                       "/api/v1/datasets/grass/tar",
                                       "/api/v1/datasets/grass/charts",
                                       "/api/v1/datasets/grass/thumbs/1",
                                       NULL};
    struct ttf_http_match m;

    (void)state;
    for (unsigned i = 0; URLS[i]; i++) {
        assert_int_equal(ttf_http_route_find("GET", URLS[i], &m), 0);
        if (m.route->lane == TTF_HTTP_AT_ONCE)
            fail_msg("%s does", m.route->pattern);
    }
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_path_names_its_route_and_parts),
        cmocka_unit_test(what_no_pattern_has_is_not_there),
        cmocka_unit_test(no_thread_of_connections_reads_a_whole_dataset),
        cmocka_unit_test(a_dataset_cannot_be_changed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
