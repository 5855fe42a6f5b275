/* SPDX-License-Identifier: Apache-2.0 */
#include "web.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

const char *web_type(const char *path)
{
    static const char *const TYPES[][2] = {
        {".html", "text/html; charset=utf-8"},
        {".css", "text/css; charset=utf-8"},
        {".js", "text/javascript; charset=utf-8"},
        {".mjs", "text/javascript; charset=utf-8"},
        {".svg", "image/svg+xml"},
        {".png", "image/png"},
        {".jpg", "image/jpeg"},
        {".ico", "image/vnd.microsoft.icon"},
        {".json", "application/json"},
        {".woff2", "font/woff2"},
        {".txt", "text/plain; charset=utf-8"},
    };
    size_t n = strlen(path);

    for (size_t i = 0; i < sizeof TYPES / sizeof *TYPES; i++) {
        size_t end = strlen(TYPES[i][0]);

        if (n > end && strcmp(path + n - end, TYPES[i][0]) == 0)
            return TYPES[i][1];
    }
    return NULL;
}

static int give(struct ttf_http_request *request, const char *path, struct ttf_http_answer *ret)
{
    const char *type = web_type(path);

    for (size_t i = 0; type && i < WEB_FILES_N; i++) {
        const struct web_file *file = &WEB_FILES[i];

        if (strcmp(file->path, path) != 0)
            continue;
        ret->fixed = file->bytes;
        ret->bytes = (int64_t)file->n;
        ret->type = type;
        ret->page = true;
        (void)snprintf(ret->etag, sizeof ret->etag, "%s", file->sha256);
        return 0;
    }
    return ttf_err_set(&request->err, -ENOENT, NULL, "the page has no such file");
}

int web_index(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return give(request, "index.html", ret);
}

int web_file_of_page(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return give(request, request->match->path, ret);
}
