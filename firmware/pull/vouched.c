/* SPDX-License-Identifier: Apache-2.0 */
#include "vouched.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"

static void bytes_of(const char *hex, uint8_t *ret, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const char pair[3] = {hex[2 * i], hex[2 * i + 1], '\0'};

        ret[i] = (uint8_t)strtoul(pair, NULL, 16);
    }
}

static struct vouched_file file_of(const char *path, const char *hex)
{
    struct vouched_file file = {0};
    struct ttf_sha256 hash;
    char name[65];

    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, path, strlen(path));
    ttf_sha256_hex(&hash, name);
    bytes_of(name, file.path, sizeof file.path);
    bytes_of(hex, file.hash, sizeof file.hash);
    return file;
}

static int add(struct vouched *v, const char *path, const char *hex)
{
    if (v->n == v->room) {
        size_t room = v->room ? 2 * v->room : 256;
        struct vouched_file *more = realloc(v->files, room * sizeof *more);

        if (!more)
            return -ENOMEM;
        v->files = more;
        v->room = room;
    }
    v->files[v->n++] = file_of(path, hex);
    return 0;
}

static int add_files(struct vouched *v, const json_t *owner)
{
    const json_t *file;
    size_t i;
    int r = 0;

    json_array_foreach(json_object_get(owner, "files"), i, file)
    {
        const char *path = json_string_value(json_object_get(file, "path"));
        const char *hex = json_string_value(json_object_get(file, "sha256"));

        if (r == 0 && path && hex && ttf_sha256_is_hex(hex))
            r = add(v, path, hex);
    }
    return r;
}

/* Lines of a later version say nothing of the end. */
static void note_end(struct vouched *v, const char *type)
{
    static const char *const OTHERS[] = {"slot", "segment", "plan", "calibration"};

    if (!type)
        return;
    v->ended |= strcmp(type, "end") == 0;
    for (unsigned i = 0; i < sizeof OTHERS / sizeof *OTHERS; i++)
        v->ended &= strcmp(type, OTHERS[i]) != 0;
}

int vouched_add(struct vouched *v, const json_t *record)
{
    const json_t *image;
    size_t i;
    int r = add_files(v, record);

    note_end(v, json_string_value(json_object_get(record, "type")));
    json_array_foreach(json_object_get(record, "images"), i, image) if (r == 0) r =
        add_files(v, image);
    return r;
}

/* grown_line_fn */
static int take_line(void *ctx, const char *line, size_t n, struct ttf_err *err)
{
    json_t *json;
    int r = ttf_json_parse(line, n, &json, NULL);

    if (r == 0) {
        r = vouched_add(ctx, json);
        json_decref(json);
    }
    return r == -ENOMEM ? ttf_err_set(err, r, NULL, "no memory") : 0;
}

static int by_path(const void *a, const void *b)
{
    const struct vouched_file *one = a, *other = b;

    return memcmp(one->path, other->path, sizeof one->path);
}

void vouched_sort(struct vouched *v)
{
    if (v->n > 1)
        qsort(v->files, v->n, sizeof *v->files, by_path);
}

int vouched_read(const struct grown *records, struct vouched *ret, struct ttf_err *err)
{
    struct grown now = {.io = records->io};
    int r;

    *ret = (struct vouched){0};
    (void)snprintf(now.path, sizeof now.path, "%s", records->path);
    now.file = now.io->ops->open(now.io, now.path, TTF_IO_READ);
    if (now.file < 0)
        return ttf_err_set(err, now.file, now.path, "cannot be opened: %s",
                           strerrordesc_np(-now.file));
    r = grown_each(&now, 0, take_line, ret, err);
    (void)now.io->ops->close(now.io, now.file);
    vouched_sort(ret);
    return r;
}

void vouched_free(struct vouched *vouched)
{
    free(vouched->files);
    *vouched = (struct vouched){0};
}

enum vouched_as vouched_as(struct vouched *v, const char *path, const char *hex)
{
    const struct vouched_file wanted = file_of(path, hex);
    struct vouched_file *found =
        v->n ? bsearch(&wanted, v->files, v->n, sizeof *v->files, by_path) : NULL;
    bool so = found != NULL;

    if (!found)
        return VOUCHED_NOT;
    /* One that is named twice is so only if it is in both. */
    while (found > v->files && by_path(found - 1, &wanted) == 0)
        found--;
    for (; found < v->files + v->n && by_path(found, &wanted) == 0; found++) {
        so = so && memcmp(found->hash, wanted.hash, sizeof wanted.hash) == 0;
        found->listed = true;
    }
    return so ? VOUCHED_SO : VOUCHED_OTHERWISE;
}

bool vouched_all_listed(const struct vouched *v)
{
    for (size_t i = 0; i < v->n; i++)
        if (!v->files[i].listed)
            return false;
    return true;
}
