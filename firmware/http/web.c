/* SPDX-License-Identifier: Apache-2.0 */
#include "web.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static int give(struct ttf_http_request *request, const char *path, struct ttf_http_answer *ret)
{
    /* One without a type is none that a page has. */
    for (size_t i = 0; ret->type && i < WEB_FILES_N; i++) {
        const struct web_file *file = &WEB_FILES[i];

        if (strcmp(file->path, path) != 0)
            continue;
        ret->fixed = file->bytes;
        ret->bytes = (int64_t)file->n;
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
