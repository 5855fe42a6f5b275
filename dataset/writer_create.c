/* SPDX-License-Identifier: Apache-2.0 */
/* A new dataset. dataset.json comes last: a folder without it is none yet (DESIGN.md, "Creating"). */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "manifest_rules.h"
#include "record_line.h"
#include "ttf/dataset/hash.h"
#include "writer_private.h"

/* Is this what an interrupted creation can leave? Anything else is not ours to write over. */
static int foreign_entry(void *ctx, const char *name, bool is_dir)
{
    static const char *const ours[] = {"plans", "records.jsonl", "events.jsonl", TTF_RESERVE_NAME};
    size_t i, n = strlen(name);

    for (i = 0; i < TTF_COUNT_OF(ours); i++)
        if (strcmp(name, ours[i]) == 0)
            return 0;
    return n > 4 && strcmp(name + n - 4, ".tmp") == 0 && !is_dir ? 0 : 1;
}

static int foreign_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    return strcmp(line->type, "plan") == 0 ? 0 : 1;
}

static int check_folder(struct ttf_writer *writer, struct ttf_err *err)
{
    struct ttf_io *io = writer->io;
    struct ttf_io_stat st;
    char *records;
    int r;

    r = io->ops->stat(io, writer->path, &st);
    if (r == -ENOENT)
        return ttf_io_mkdirs(io, writer->path, err);
    if (r)
        return ttf_err_set(err, r, writer->path, "cannot be looked at: %s", strerrordesc_np(-r));
    if (!st.is_dir)
        return ttf_err_set(err, -EEXIST, writer->path, "is there already, and is no folder");
    r = io->ops->list(io, writer->path, foreign_entry, NULL);
    if (r < 0)
        return ttf_err_set(err, r, writer->path, "cannot be listed: %s", strerrordesc_np(-r));
    if (r == 0) {
        records = ttf_path_format("%s/records.jsonl", writer->path);
        if (!records)
            return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
        r = ttf_lines_scan(io, records, foreign_line, NULL, NULL, NULL, err);
        if (r == -ENOENT) {
            r = 0;
            if (err)
                *err = (struct ttf_err){0};
        }
        free(records);
    }
    if (r == 0 || (r < 0 && r != -TTF_EDAMAGED))
        return r;
    ttf_err_set(err, -EEXIST, writer->path, "is there already, and is not empty");
    ttf_err_hint(err, "choose another name, or go on with the dataset that is there");
    return -EEXIST;
}

static int plan_file(struct ttf_writer *writer, int n, const char *extension, const char *text,
                     struct ttf_json *json, struct ttf_err *err)
{
    char *path = ttf_path_format("plans/%d.%s", n, extension);
    char *full = path ? ttf_path_format("%s/%s", writer->path, path) : NULL;
    struct ttf_sha256 hash;
    char hex[65];
    int r;

    if (!full) {
        r = ttf_err_set(err, -ENOMEM, "plans", "no memory");
        goto out;
    }
    r = ttf_io_write_file(writer->io, full, text, strlen(text), err);
    if (r)
        goto out;
    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, text, strlen(text));
    ttf_sha256_hex(&hash, hex);
    ttf_json_object(json);
    ttf_json_kstring(json, "path", path);
    ttf_json_kint(json, "bytes", (int64_t)strlen(text));
    ttf_json_kstring(json, "sha256", hex);
    ttf_json_object_end(json);
out:
    free(full);
    free(path);
    return r;
}

int ttf_writer_plan_files(struct ttf_writer *writer, int n, const char *yaml, const char *text,
                          struct ttf_json *json, struct ttf_err *err)
{
    int r;

    r = ttf_writer_folder(writer, "plans", err);
    ttf_json_kint(json, "plan", n);
    ttf_json_key(json, "files");
    ttf_json_array(json);
    if (r == 0 && yaml)
        r = plan_file(writer, n, "yaml", yaml, json, err);
    if (r == 0 && text)
        r = plan_file(writer, n, "json", text, json, err);
    ttf_json_array_end(json);
    return r;
}

static int write_text(struct ttf_writer *writer, const char *name, const char *text, size_t n,
                      struct ttf_err *err)
{
    char *path = ttf_path_format("%s/%s", writer->path, name);
    int r;

    if (!path)
        return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    r = ttf_io_write_file(writer->io, path, text, n, err);
    free(path);
    return r;
}

/* records.jsonl with plan 0, if there is one, as its first line. */
static int write_records(struct ttf_writer *writer, const char *yaml, const char *plan_json,
                         struct ttf_lines_tail *tail, struct ttf_err *err)
{
    struct ttf_json json;
    const char *text = "";
    char *line = NULL;
    size_t n = 0;
    int r = 0;

    *tail = (struct ttf_lines_tail){0};
    ttf_line_begin(&json, "plan", 0);
    if (yaml || plan_json) {
        r = ttf_writer_plan_files(writer, 0, yaml, plan_json, &json, err);
        if (r == 0)
            r = ttf_line_finish(&json, &text, &n);
        if (r)
            goto out;
        line = ttf_path_format("%s\n", text);
        if (!line) {
            r = -ENOMEM;
            goto out;
        }
        n++;
        tail->lines = tail->next_seq = 1;
        writer->state.n_plans = 1;
    }
    tail->good_bytes = (int64_t)n;
    r = write_text(writer, "records.jsonl", line ? line : "", n, err);
out:
    if (r == -ENOMEM)
        ttf_err_set(err, r, writer->path, "no memory");
    free(line);
    ttf_json_free(&json);
    return r;
}

static int open_logs(struct ttf_writer *writer, const struct ttf_lines_tail *records,
                     struct ttf_err *err)
{
    static const struct ttf_lines_tail nothing = {0};
    char *path = ttf_path_format("%s/records.jsonl", writer->path);
    char *events = ttf_path_format("%s/events.jsonl", writer->path);
    int r;

    if (!path || !events)
        r = ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    else
        r = ttf_jsonl_open(&writer->records, writer->io, path, records, err);
    if (r == 0)
        r = ttf_jsonl_open(&writer->events, writer->io, events, &nothing, err);
    free(events);
    free(path);
    return r;
}

static int fill_folder(struct ttf_writer *writer, const char *text, const char *plan_yaml,
                       const char *plan_json, struct ttf_err *err)
{
    struct ttf_lines_tail tail;
    int r;

    r = check_folder(writer, err);
    if (r)
        return r;
    ttf_writer_sync_above(writer);
    r = ttf_writer_sync_names(writer, err);
    if (r)
        return r;
    r = ttf_writer_lock(writer, err);
    if (r)
        return r;
    r = write_records(writer, plan_yaml, plan_json, &tail, err);
    if (r)
        return r;
    r = write_text(writer, "events.jsonl", "", 0, err);
    if (r)
        return r;
    ttf_reserve_make(writer);
    /* Once dataset.json is there nothing may fail: it would be a dataset that nobody was given. */
    r = open_logs(writer, &tail, err);
    return r ? r : write_text(writer, "dataset.json", text, strlen(text), err);
}

int ttf_writer_create(struct ttf_io *io, const char *path, const struct ttf_manifest *manifest,
                      const char *plan_yaml, const char *plan_json, struct ttf_writer **ret,
                      struct ttf_err *err)
{
    struct ttf_writer *writer = ttf_writer_alloc(io, path);
    struct ttf_sha256 hash;
    char *text = NULL;
    const char *name;
    int r;

    if (!writer)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    name = strrchr(writer->path, '/');
    name = name ? name + 1 : writer->path;
    if (!ttf_name_ok(name)) {
        r = ttf_err_set(err, -EINVAL, path,
                        "a dataset's name must be 1 to 64 of A-Z a-z 0-9 . _ and -");
        goto err_abandon;
    }
    writer->manifest = *manifest;
    r = ttf_manifest_write(manifest, &text, err);
    if (r == 0) {
        ttf_sha256_init(&hash);
        ttf_sha256_add(&hash, text, strlen(text));
        ttf_sha256_hex(&hash, writer->manifest_sha256);
    }
    if (r == 0)
        r = fill_folder(writer, text, plan_yaml, plan_json, err);
    free(text);
    if (r)
        goto err_abandon;
    *ret = writer;
    return 0;

err_abandon:
    ttf_writer_abandon(writer);
    return r;
}
