/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a request says, as far as it is read by us: "METHOD URL\nHost\nAuthorization\nRange", missing parts empty. A range
 * lies within what there is; a path that a route takes and a dataset could have leads nowhere else; only the token opens.
 */
#include <stdlib.h>
#include <string.h>

#include "access.h"
#include "folder.h"
#include "fuzz.h"
#include "range.h"
#include "ttf/http/routes.h"

#define TOKEN "0123456789abcdef"

static const char *take(char **at, char end)
{
    char *text = *at, *stop = strchr(text, end);

    if (stop)
        *stop = '\0';
    *at = stop ? stop + 1 : text + strlen(text);
    return text;
}

static void check_range(const char *text, int64_t total)
{
    struct range r = range_read(text, total);

    if (r.kind == RANGE_PART && (r.first < 0 || r.bytes <= 0 || r.first > total - r.bytes))
        abort();
    if (r.kind == RANGE_WHOLE && (r.first != 0 || r.bytes != total))
        abort();
}

static void check_path(const char *method, const char *url)
{
    struct ttf_http_match match;

    if (ttf_http_route_find(method, url, &match) < 0)
        return;
    if (!match.route || strlen(match.name) > TTF_HTTP_NAME_MAX ||
        strlen(match.path) > TTF_HTTP_REST_MAX)
        abort();
    if (folder_is_name(match.name) && (strchr(match.name, '/') || match.name[0] == '.'))
        abort();
    if (folder_is_path(match.path) && (match.path[0] == '/' || strncmp(match.path, "../", 3) == 0 ||
                                       strcmp(match.path, "..") == 0 || strstr(match.path, "/../")))
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const NAMES[] = {"ttfbox-1.local", NULL};
    char *text = malloc(size + 1), *at = text;
    const char *method, *url, *host, *authorization;

    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    method = take(&at, ' ');
    url = take(&at, '\n');
    host = take(&at, '\n');
    authorization = take(&at, '\n');
    check_path(method, url);
    (void)access_host(host, NAMES);
    if (access_token(authorization, TOKEN) && !strstr(authorization, TOKEN))
        abort();
    check_range(at, 0);
    check_range(at, 1000);
    check_range(at, INT64_MAX);
    free(text);
    return 0;
}
