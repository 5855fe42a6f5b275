/* SPDX-License-Identifier: Apache-2.0 */
/* dataset.json field by field: each that is not as it must be is refused by its name; what may be missing may. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store_test.h"
#include "ttf/dataset/manifest.h"

#define UUID "5ca1ab1e-0000-4000-8000-000000000001"
#define STREAM                                                                            \
    "\"id\":\"main\",\"sample_format\":\"u16\",\"quantity\":\"reflectance\",\"width\":4," \
    "\"height\":3,\"samples\":3,\"encoding\":{\"pedestal\":0,\"scale\":1}"
#define HEAD                                                                  \
    "{\"format\":{\"name\":\"ttf\",\"major\":1,\"minor\":1},\"uuid\":\"" UUID \
    "\",\"simulated\":false,"

static const char good[] = HEAD "\"title\":\"a\",\"cameras\":[{\"id\":\"top\",\"raw_width\":8}],"
                                "\"channels\":[{\"id\":\"white\"}],\"streams\":[{" STREAM
                                ",\"camera\":\"top\",\"channel\":\"white\",\"primary\":true}],"
                                "\"group\":{\"uuid\":\"" UUID "\",\"member\":\"b\"},"
                                "\"derived_from\":{\"uuid\":\"" UUID "\",\"seed\":7}}";

/* The good text with one piece of it replaced, to be freed. */
static char *with(const char *from, const char *to)
{
    const char *at = strstr(good, from);
    char *text = calloc(1, sizeof(good) + strlen(to) + 1);

    if (!at)
        fail_msg("'%s' is not in the good one", from);
    assert_non_null(text);
    if (at && text)
        sprintf(text, "%.*s%s%s", (int)(at - good), good, to, at + strlen(from));
    return text;
}

static void a_field_that_is_not_as_it_must_be_is_named(void **state)
{
    static const struct {
        const char *from, *to, *says;
        int code;
    } cases[] = {
        {"\"name\":\"ttf\"", "\"name\":\"tft\"", "format.name is \"tft\"", -EINVAL},
        {"\"name\":\"ttf\"", "\"name\":7", "format.name must be a text", -EINVAL},
        {"\"name\":\"ttf\",", "", "format.name is missing", -EINVAL},
        {"\"name\":\"ttf\"", "\"name\":\"\"", "format.name must not be empty", -EINVAL},
        {"\"name\":\"ttf\"", "\"name\":\"much longer than it may be\"", "longer than", -EINVAL},
        {"\"major\":1", "\"major\":2", "format.major is 2", -ENOTSUP},
        {"\"major\":1", "\"major\":1.0", "format.major must be a whole number", -EINVAL},
        {"\"major\":1", "\"major\":-1", "must lie in", -EINVAL},
        {"\"minor\":1", "\"minor\":null", "format.minor is missing", -EINVAL},
        {"\"minor\":1", "\"minor\":1,\"required\":7", "required must be an array", -EINVAL},
        {"\"minor\":1", "\"minor\":1,\"required\":[\"sound\"]", "names \"sound\"", -ENOTSUP},
        {"\"minor\":1", "\"minor\":1,\"required\":[7]", "names \"?\"", -ENOTSUP},
        {"{\"name\":\"ttf\",\"major\":1,\"minor\":1}", "[]", "format must be an object", -EINVAL},
        {"\"simulated\":false", "\"simulated\":0", "simulated must be true or false", -EINVAL},
        {"\"simulated\":false,", "", "simulated is missing", -EINVAL},
        {"\"uuid\":\"5ca1", "\"uuid\":\"5CA1", "uuid must be a lower-case UUID", -EINVAL},
        {"\"title\":\"a\"", "\"title\":[]", "title must be a text", -EINVAL},
        {"\"cameras\":[", "\"cameras\":[7,", "cameras[0].id is missing", -EINVAL},
        {"\"raw_width\":8", "\"raw_width\":65536", "cameras[0].raw_width is 65536", -EINVAL},
        {"\"id\":\"top\"", "\"id\":\"\"", "cameras[0].id must not be empty", -EINVAL},
        {"\"cameras\":[{", "\"cameras\":[{\"id\":\"top\"},{", "cameras[1]", -EINVAL},
        {"\"cameras\":[", "\"cameras\":[{},{},{},{},", "cameras has more than 4", -EINVAL},
        {"\"channels\":[{", "\"channels\":[{\"id\":\"white\"},{", "channels[1]", -EINVAL},
        {"\"channels\":[", "\"channels\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,", "more than 16",
         -EINVAL},
        {"\"streams\":[", "\"streams\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,", "more than 16", -EINVAL},
        {"\"streams\":[{", "\"streams\":[{" STREAM "},{", "id is there twice", -EINVAL},
        {"\"id\":\"main\"", "\"id\":\"Main\"", "streams[0].id must be of a-z", -EINVAL},
        {"\"sample_format\":\"u16\"", "\"sample_format\":\"u32\"", "which is unknown", -EINVAL},
        {"\"quantity\":\"reflectance\",", "", "streams[0].quantity is missing", -EINVAL},
        {"\"camera\":\"top\"", "\"camera\":\"side\"", "camera is not in cameras", -EINVAL},
        {"\"channel\":\"white\"", "\"channel\":\"red\"", "channel is not in channels", -EINVAL},
        {"\"width\":4", "\"width\":0", "streams[0].width is 0", -EINVAL},
        {"\"samples\":3", "\"samples\":256", "streams[0].samples is 256", -EINVAL},
        {"\"encoding\":{", "\"encoding\":7,\"x\":{", "encoding must be an object", -EINVAL},
        {"\"pedestal\":0", "\"pedestal\":\"0\"", "pedestal must be a number", -EINVAL},
        {"\"pedestal\":0,", "", "pedestal is missing", -EINVAL},
        {"\"scale\":1", "\"scale\":0", "streams[0]", -EINVAL},
        {"\"samples\":3", "\"samples\":3,\"mm_per_px\":-1", "mm_per_px must be", -EINVAL},
        {"\"primary\":true}", "\"primary\":true},{" STREAM ",\"primary\":1}", "true or false",
         -EINVAL},
        {"\"group\":{\"uuid\":\"5ca1", "\"group\":{\"uuid\":\"xca1", "group.uuid must be", -EINVAL},
        {"\"group\":{", "\"group\":{\"no\":1},\"x\":{", "group.uuid is missing", -EINVAL},
        {"\"group\":{", "\"group\":7,\"x\":{", "group must be an object", -EINVAL},
        {"\"derived_from\":{\"uuid\":\"5ca1", "\"derived_from\":{\"uuid\":\"xca1",
         "derived_from.uuid must be", -EINVAL},
        {"\"seed\":7", "\"digest\":7", "derived_from.digest must be a text", -EINVAL},
        {"\"streams\":[", "\"streams\":7,\"x\":[", "streams must be an array", -EINVAL},
        {"}}", "}", "is not JSON", -EINVAL},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        char *text = with(cases[i].from, cases[i].to);
        struct ttf_manifest manifest = {.title = "untouched"};
        struct ttf_err err = {0};
        int r = ttf_manifest_read(text, strlen(text), "dataset.json", &manifest, &err);

        if (r != cases[i].code || !strstr(err.what, cases[i].says))
            fail_msg("case %u: %d, '%s' does not say '%s'", i, r, err.what, cases[i].says);
        assert_string_equal(manifest.title, "untouched");
        free(text);
    }
}

static void what_may_be_missing_may_be_missing(void **state)
{
    static const struct {
        const char *from, *to;
    } cases[] = {
        {"\"title\":\"a\",", ""},
        {"\"title\":\"a\"", "\"title\":null"},
        {",\"primary\":true", ""},
        {"\"minor\":1", "\"minor\":99,\"required\":[]"},
        {"\"raw_width\":8", "\"raw_width\":null"},
        {",\"seed\":7", ""},
        {"\"samples\":3", "\"samples\":3,\"mm_per_px\":0.5,\"unit\":\"mm\",\"of_later\":[1]"},
        /* Of a later version: a stream of unknown samples that is not the primary one is left out. */
        {"\"streams\":[{", "\"streams\":[{\"id\":\"sound\",\"sample_format\":\"s24\"},{"},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        char *text = with(cases[i].from, cases[i].to);
        struct ttf_manifest manifest;
        struct ttf_err err = {0};

        if (ttf_manifest_read(text, strlen(text), "dataset.json", &manifest, &err) != 0)
            fail_msg("case %u: %s", i, err.what);
        assert_int_equal(manifest.n_streams, 1);
        assert_string_equal(manifest.streams[0].id, "main");
        free(text);
    }
}

/* A long text is cut where a character ends, so that it stays UTF-8. */
static void a_long_title_is_cut_at_a_character(void **state)
{
    char title[400] = "\"title\":\"", *text;
    struct ttf_manifest manifest;
    size_t n = strlen(title);

    for (unsigned i = 0; i < 100; i++, n += 3)
        memcpy(title + n, "\xe2\x82\xac", 4);
    memcpy(title + n, "\"", 2);
    text = with("\"title\":\"a\"", title);
    assert_int_equal(ttf_manifest_read(text, strlen(text), "dataset.json", &manifest, NULL), 0);
    n = strlen(manifest.title);
    assert_int_equal(n, 126); /* of 127 bytes: 42 whole characters */
    assert_memory_equal(manifest.title + n - 3, "\xe2\x82\xac", 3);
    free(text);
}

static void what_cannot_be_read_back_is_not_written(void **state)
{
    struct ttf_manifest base, m;

    small_manifest(&base);
    for (unsigned i = 0; i < 9; i++) {
        struct ttf_err err = {0};
        char *text = NULL;

        m = base;
        switch (i) {
        case 0:
            m.uuid[3] = 'X';
            break;
        case 1:
            m.streams[0].id[0] = 'A';
            break;
        case 2:
            m.streams[0].quantity[0] = '\0';
            break;
        case 3:
            m.streams[0].width = 0;
            break;
        case 4:
            m.streams[0].samples = 256;
            break;
        case 5:
            m.streams[0].format = TTF_SAMPLE_COUNT;
            break;
        case 6:
            m.streams[0].encoding.scale = NAN;
            break;
        case 7:
            m.streams[0].mm_per_px = INFINITY;
            break;
        default:
            m.n_streams = TTF_STREAMS_MAX + 1;
            break;
        }
        assert_true(ttf_manifest_write(&m, &text, &err) < 0);
        assert_true(err.what[0] != '\0');
        assert_null(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_field_that_is_not_as_it_must_be_is_named),
        cmocka_unit_test(what_may_be_missing_may_be_missing),
        cmocka_unit_test(a_long_title_is_cut_at_a_character),
        cmocka_unit_test(what_cannot_be_read_back_is_not_written),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
