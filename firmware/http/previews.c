/* SPDX-License-Identifier: Apache-2.0 */
#include "previews.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/json_parse.h"

#define JSON_MAX ((off_t)4 << 20) /* of a state, of a manifest */

/* ---- of which dataset it is ---- */

static int parse(int fd, const struct stat *st, json_t **ret)
{
    ssize_t n;
    char *text;
    int r;

    if (st->st_size > JSON_MAX)
        return -EFBIG;
    text = malloc((size_t)st->st_size + 1);
    if (!text)
        return -ENOMEM;
    n = pread(fd, text, (size_t)st->st_size, 0);
    r = n < 0 ? -errno : ttf_json_parse(text, (size_t)n, ret, NULL);
    free(text);
    return r;
}

static bool same_uuid(const json_t *a, const json_t *b)
{
    const char *of_a = json_string_value(json_object_get(a, "uuid"));
    const char *of_b = json_string_value(json_object_get(b, "uuid"));

    return of_a && of_b && strcmp(of_a, of_b) == 0;
}

/* A dataset may go, and another one take its name, while what was made of the first still lies there. */
static int check_owner(const struct folder *folder, const char *dataset, const json_t *state)
{
    json_t *manifest = NULL;
    struct stat st;
    int fd = folder_file(folder, dataset, "dataset.json", &st);
    int r;

    if (fd < 0)
        return fd;
    r = parse(fd, &st, &manifest);
    (void)close(fd);
    if (r == 0 && !same_uuid(manifest, state))
        r = -ENOENT;
    json_decref(manifest);
    return r;
}

int previews_open(const struct folder *folder, const char *dataset, struct stat *ret_stat,
                  json_t **ret_state)
{
    json_t *state = NULL;
    int fd = folder_preview(folder, dataset, "state.json", ret_stat);
    int r;

    if (fd < 0)
        return fd;
    r = parse(fd, ret_stat, &state);
    if (r == 0)
        r = check_owner(folder, dataset, state);
    if (r < 0) {
        (void)close(fd);
        fd = r;
    }
    if (r == 0 && ret_state)
        *ret_state = json_incref(state);
    json_decref(state);
    return fd;
}

/* ---- answers ---- */

int previews_state(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char path[4096 + 80];
    struct stat st;
    int fd, r = folder_dataset(request->folder, name, path, sizeof path);

    if (r < 0)
        return ttf_err_set(&request->err, r, name, "there is no dataset of this name");
    fd = previews_open(request->folder, name, &st, NULL);
    if (fd == -ENOENT) {
        char *none = strdup("{\"state\":\"none\",\"frames\":[]}");

        if (!none)
            return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
        answer_json(ret, none, strlen(none));
        return 0;
    }
    if (fd < 0)
        return ttf_err_set(&request->err, fd, name, "its preview cannot be read");
    answer_file(ret, fd, st.st_size, &st);
    return 0;
}

static int open_frame(const struct folder *folder, const char *dataset, const char *path,
                      struct stat *ret_stat)
{
    size_t n = strlen(path);
    int fd = n > 4 && strcmp(path + n - 4, ".jpg") == 0
                 ? previews_open(folder, dataset, ret_stat, NULL)
                 : -ENOENT;

    if (fd < 0)
        return fd;
    (void)close(fd);
    return folder_preview(folder, dataset, path, ret_stat);
}

int previews_frame(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *path = request->match->path;
    struct stat st;
    int fd = open_frame(request->folder, request->match->name, path, &st);

    if (fd < 0)
        return ttf_err_set(&request->err, fd, path, "there is no such frame: read the state again");
    answer_file(ret, fd, st.st_size, &st);
    return 0;
}
