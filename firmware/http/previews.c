/* SPDX-License-Identifier: Apache-2.0 */
#include "previews.h"

#include <errno.h>
#include <string.h>

static int open_one(struct ttf_http_request *request, const char *path, struct ttf_http_answer *ret)
{
    struct stat st;
    int fd = folder_preview(request->folder, request->match->name, path, &st);

    if (fd < 0)
        return fd;
    answer_file(ret, fd, st.st_size, &st);
    return 0;
}

int previews_state(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char path[4096 + 80];
    int r = folder_dataset(request->folder, name, path, sizeof path);

    if (r < 0)
        return ttf_err_set(&request->err, r, name, "there is no dataset of this name");
    r = open_one(request, "state.json", ret);
    if (r == -ENOENT) {
        char *none = strdup("{\"state\":\"none\",\"frames\":[]}");

        if (!none)
            return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
        answer_json(ret, none, strlen(none));
        return 0;
    }
    return r < 0 ? ttf_err_set(&request->err, r, name, "its preview cannot be read") : 0;
}

int previews_frame(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *path = request->match->path;
    size_t n = strlen(path);
    int r = n > 4 && strcmp(path + n - 4, ".jpg") == 0 ? open_one(request, path, ret) : -ENOENT;

    if (r < 0)
        return ttf_err_set(&request->err, r, path, "there is no such frame: read the state again");
    return 0;
}
