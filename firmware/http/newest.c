/* SPDX-License-Identifier: Apache-2.0 */
#include "newest.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/json_parse.h"

#define LOOK_FIRST ((int64_t)64 * 1024)
#define LOOK_MOST  ((int64_t)8 * 1024 * 1024)

static void copy(char *ret, size_t size, const char *text)
{
    size_t n = text ? strlen(text) : 0;

    n = n < size ? n : size - 1;
    if (text)
        memcpy(ret, text, n);
    ret[n] = '\0';
}

/* The best file of an image: developed before raw. */
static bool take_image(json_t *image, struct newest *ret)
{
    json_t *file;
    bool found = false;
    size_t i;

    json_array_foreach(json_object_get(image, "files"), i, file)
    {
        const char *role = json_string_value(json_object_get(file, "role"));
        const char *path = json_string_value(json_object_get(file, "path"));
        bool developed = role && strcmp(role, "developed") == 0;

        if (!role || !path || !folder_is_path(path) || strlen(path) >= sizeof ret->path ||
            (!developed && (found || strcmp(role, "raw") != 0)))
            continue;
        copy(ret->stream, sizeof ret->stream, json_string_value(json_object_get(image, "stream")));
        copy(ret->path, sizeof ret->path, path);
        copy(ret->sha256, sizeof ret->sha256, json_string_value(json_object_get(file, "sha256")));
        found = true;
    }
    return found;
}

int newest_of_line(const char *line, size_t bytes, struct newest *ret)
{
    json_t *record, *image;
    const char *type;
    bool found = false;
    size_t i;
    int r = ttf_json_parse(line, bytes, &record, NULL);

    if (r < 0)
        return r == -ENOMEM ? r : -ENOENT;
    memset(ret, 0, sizeof *ret);
    type = json_string_value(json_object_get(record, "type"));
    if (type && strcmp(type, "slot") == 0)
        json_array_foreach(json_object_get(record, "images"), i, image)
        {
            found = take_image(image, ret);
            if (found)
                break;
        }
    ret->index = json_integer_value(json_object_get(record, "index"));
    json_decref(record);
    return found ? 0 : -ENOENT;
}

/* From the last line on backwards. */
static int find_in(const char *text, size_t bytes, struct newest *ret)
{
    int r = -ENOENT;

    while (bytes > 0 && r == -ENOENT) {
        const char *before = bytes > 1 ? memrchr(text, '\n', bytes - 1) : NULL;
        const char *line = before ? before + 1 : text;

        r = newest_of_line(line, (size_t)(text + bytes - line), ret);
        bytes = (size_t)(line - text);
    }
    return r;
}

static int look(int fd, int64_t whole, int64_t bytes, struct newest *ret)
{
    char *text = malloc((size_t)bytes);
    int64_t got = 0;
    int r;

    if (!text)
        return -ENOMEM;
    while (got < bytes) {
        ssize_t n = pread(fd, text + got, (size_t)(bytes - got), whole - bytes + got);

        if (n <= 0)
            break;
        got += n;
    }
    r = got == bytes ? find_in(text, (size_t)bytes, ret) : -EIO;
    free(text);
    return r;
}

int newest_find(const struct folder *folder, const char *dataset, struct newest *ret,
                struct ttf_err *err)
{
    struct stat st;
    int fd = folder_file(folder, dataset, "records.jsonl", &st);
    int64_t whole;
    int r = -ENOENT;

    if (fd < 0)
        return ttf_err_set(err, fd, dataset, "has no records");
    whole = folder_whole_lines(fd, st.st_size);
    if (whole < 0)
        r = (int)whole;
    for (int64_t bytes = LOOK_FIRST; whole > 0 && r == -ENOENT;
         bytes = bytes * 8 < LOOK_MOST ? bytes * 8 : LOOK_MOST) {
        int64_t part = bytes < whole ? bytes : whole;

        r = look(fd, whole, part, ret);
        if (part == whole || bytes >= LOOK_MOST)
            break;
    }
    (void)close(fd);
    if (r < 0)
        ttf_err_set(err, r, dataset, "%s", r == -ENOENT ? "has no picture yet" : "cannot be read");
    return r;
}
