/* SPDX-License-Identifier: Apache-2.0 */
/* Opening for writing: what a crash can leave is put right, and nothing else (DESIGN.md, "Recovery"). */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "record_line.h"
#include "sums.h"
#include "walk.h"
#include "writer_private.h"

/* Of a fragment as much as any line of an ordinary slot has. */
#define ASIDE_BYTES_MAX ((size_t)64 * 1024)

/* ---- bytes behind the last whole line ---- */

static int read_hex(struct ttf_jsonl *f, int64_t offset, int64_t bytes, char **ret,
                    struct ttf_err *err)
{
    static const char digits[] = "0123456789abcdef";
    size_t n = bytes < (int64_t)ASIDE_BYTES_MAX ? (size_t)bytes : ASIDE_BYTES_MAX, i;
    unsigned char *raw = malloc(n);
    char *hex = malloc(2 * n + 1);
    int64_t got = raw && hex ? ttf_io_pread_all(f->io, f->file, raw, n, offset) : -ENOMEM;

    if (got != (int64_t)n) {
        free(raw);
        free(hex);
        got = got < 0 ? got : -EIO;
        return ttf_err_set(err, (int)got, f->path, "its end cannot be set aside: %s",
                           strerrordesc_np((int)-got));
    }
    for (i = 0; i < n; i++) {
        hex[2 * i] = digits[raw[i] >> 4];
        hex[2 * i + 1] = digits[raw[i] & 15];
    }
    hex[2 * n] = '\0';
    free(raw);
    *ret = hex;
    return 0;
}

static int aside_event(struct ttf_writer *writer, const char *name, int64_t bytes, const char *hex,
                       struct ttf_err *err)
{
    char text[160];
    struct ttf_json json;
    const char *detail;
    int r;

    snprintf(text, sizeof(text), "%s ended in %lld bytes that are no whole line: set aside here",
             name, (long long)bytes);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "file", name);
    ttf_json_kint(&json, "bytes", bytes);
    if (hex)
        ttf_json_kstring(&json, "hex", hex);
    ttf_json_object_end(&json);
    r = ttf_json_finish(&json, &detail, NULL);
    if (r == 0)
        r = ttf_writer_event(writer, "repair", TTF_NS_UNKNOWN, TTF_NS_UNKNOWN, text, detail, err);
    else
        ttf_err_set(err, r, name, "no memory");
    ttf_json_free(&json);
    return r;
}

static int cut_fragment(struct ttf_jsonl *f, const struct ttf_lines_tail *tail, struct ttf_err *err)
{
    int r;

    r = f->io->ops->truncate(f->io, f->file, tail->good_bytes);
    if (r == 0) {
        r = f->io->ops->sync(f->io, f->file, false);
        f->doubt = f->doubt || r != 0;
    }
    return r ? ttf_err_set(err, r, f->path, "cannot be repaired: %s", strerrordesc_np(-r)) : 0;
}

/*
 * Good lines that are on the disk, and nothing behind them, before anything is put there. Of a file whose
 * sync failed another sync proves nothing: it is written anew.
 */
static int settle_good(struct ttf_jsonl *f, const struct ttf_lines_tail *tail, bool doubt,
                       struct ttf_err *err)
{
    int r;

    if (doubt)
        return ttf_jsonl_renew(f, err);
    r = ttf_jsonl_sync_last(f, err);
    if (r == 0 && tail->fragment_bytes > 0)
        r = cut_fragment(f, tail, err);
    return r;
}

/* Both files end in whole lines after this; what was cut off stands in events.jsonl. */
static int repair_ends(struct ttf_writer *writer, const struct ttf_lines_tail *records,
                       const struct ttf_lines_tail *events, bool doubt, struct ttf_err *err)
{
    char *of_events = NULL, *of_records = NULL;
    int r = 0;

    if (events->fragment_bytes > 0)
        r = read_hex(&writer->events, events->fragment_offset, events->fragment_bytes, &of_events,
                     err);
    if (r == 0)
        r = settle_good(&writer->events, events, doubt, err);
    if (r == 0 && events->fragment_bytes > 0) {
        r = aside_event(writer, "events.jsonl", events->fragment_bytes, of_events, err);
        writer->state.repaired++;
    }
    if (r == 0 && records->fragment_bytes > 0) {
        r = read_hex(&writer->records, records->fragment_offset, records->fragment_bytes,
                     &of_records, err);
        if (r == 0)
            r = aside_event(writer, "records.jsonl", records->fragment_bytes, of_records, err);
        writer->state.repaired++;
    }
    if (r == 0)
        r = settle_good(&writer->records, records, doubt, err);
    if (r == 0 && writer->records.no_newline) {
        r = ttf_jsonl_settle(&writer->records, err);
        writer->state.repaired++;
    }
    if (r == 0 && writer->events.no_newline)
        r = ttf_jsonl_settle(&writer->events, err);
    free(of_records);
    free(of_events);
    return r;
}

/* ---- files that are no part of any committed slot ---- */

struct orphans {
    struct ttf_paths paths;
    int64_t index; /* of all of them; -1: none yet, -2: of several slots */
};

static int named_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    struct orphans *o = ctx;
    size_t i;

    for (i = 0; i < o->paths.n; i++)
        if (strcmp(o->paths.items[i], file->path) == 0)
            o->index = -2; /* somebody's own way of naming: hands off */
    return 0;
}

static int named_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    return ttf_line_files(line, named_file, ctx, err);
}

/* How much of the path is calibration/ID, if it lies in a folder that has no line; 0: it does not. */
static size_t nameless_calibration(const struct ttf_writer *writer, const char *path)
{
    static const char above[] = "calibration/";
    const char *id = path + sizeof(above) - 1, *end;
    unsigned i;

    if (strncmp(path, above, sizeof(above) - 1) != 0 || !(end = strchr(id, '/')))
        return 0;
    for (i = 0; i < writer->n_calibrations; i++)
        if (strlen(writer->calibrations[i]) == (size_t)(end - id) &&
            strncmp(writer->calibrations[i], id, (size_t)(end - id)) == 0)
            return 0;
    return (size_t)(end - path);
}

/* Of a calibration that a crash kept from being copied whole: its calibration.json would have come last. */
static bool of_half_a_calibration(const struct ttf_writer *writer, const struct ttf_paths *files,
                                  const char *path)
{
    size_t n = nameless_calibration(writer, path), i;

    for (i = 0; n > 0 && i < files->n; i++)
        if (strncmp(files->items[i], path, n) == 0 &&
            strcmp(files->items[i] + n, "/calibration.json") == 0)
            n = 0;
    return n > 0;
}

static int find_leftovers(struct ttf_writer *writer, const struct ttf_paths *files,
                          struct ttf_paths *temporary, struct ttf_paths *half,
                          struct orphans *orphans, struct ttf_err *err)
{
    int64_t index;
    size_t i;
    int r = 0;

    for (i = 0; r == 0 && i < files->n; i++) {
        index = ttf_path_index(files->items[i]);
        if (ttf_is_temporary(files->items[i])) {
            r = ttf_paths_add(temporary, files->items[i]);
        } else if (of_half_a_calibration(writer, files, files->items[i])) {
            r = ttf_paths_add(half, files->items[i]);
        } else if (index >= writer->state.next_index) {
            r = ttf_paths_add(&orphans->paths, files->items[i]);
            orphans->index = orphans->index == -1 || orphans->index == index ? index : -2;
        }
    }
    if (r)
        return ttf_err_set(err, r, writer->path, "no memory");
    if (orphans->index >= 0)
        r = ttf_lines_scan(writer->io, writer->records.path, named_line, NULL, orphans, NULL, err);
    return r;
}

/*
 * For good: a file that came back after a power cut, behind a seal that was written
 * meanwhile and does not cover it, would be damage.
 */
static int remove_all(struct ttf_writer *writer, const struct ttf_paths *paths, struct ttf_err *err)
{
    char *full;
    size_t i;
    int r = 0;

    for (i = 0; r >= 0 && i < paths->n; i++) {
        full = ttf_path_format("%s/%s", writer->path, paths->items[i]);
        r = full ? ttf_remove(writer->io, full, err) : -ENOMEM;
        if (r == 1) {
            r = ttf_io_sync_parent(writer->io, full);
            if (r)
                ttf_err_set(err, r, paths->items[i], "its removal cannot be synced: %s",
                            strerrordesc_np(-r));
        }
        free(full);
        writer->state.repaired++;
    }
    return r < 0 ? r : 0;
}

static int repair_files(struct ttf_writer *writer, char *told, size_t told_size,
                        struct ttf_err *err)
{
    struct ttf_paths files = {0}, temporary = {0}, half = {0};
    struct orphans orphans = {.index = -1};
    int r, n = 0;

    r = ttf_walk(writer->io, writer->path, &files, err);
    if (r)
        return r;
    r = find_leftovers(writer, &files, &temporary, &half, &orphans, err);
    if (r == 0)
        r = remove_all(writer, &temporary, err);
    if (r == 0)
        r = remove_all(writer, &half, err);
    /*
     * A crash leaves files of at most the one slot that was being committed. Files of
     * several slots mean that records were lost: they stay, verify names them.
     */
    if (r == 0 && orphans.index >= 0)
        r = remove_all(writer, &orphans.paths, err);
    if (half.n > 0)
        n = snprintf(told, told_size, "%zu files of half a calibration removed; ", half.n);
    if (half.n > 0 || temporary.n > 0 || orphans.paths.n > 0)
        snprintf(told + n, told_size - (size_t)n,
                 "%zu temporary files removed; %zu files without a record %s", temporary.n,
                 orphans.paths.n, orphans.index == -2 ? "left alone" : "removed");
    ttf_paths_free(&half);
    ttf_paths_free(&orphans.paths);
    ttf_paths_free(&temporary);
    ttf_paths_free(&files);
    return r;
}

/* ---- the whole ---- */

int ttf_writer_repair(struct ttf_writer *writer, const struct ttf_lines_tail *records,
                      const struct ttf_lines_tail *events, enum ttf_sums_state sums, bool doubt,
                      struct ttf_err *err)
{
    char told[200] = "", text[280];
    unsigned before;
    int r;

    r = repair_ends(writer, records, events, doubt, err);
    if (r)
        return r;
    before = writer->state.repaired;
    r = repair_files(writer, told, sizeof(told), err);
    if (r == 0 && (sums == TTF_SUMS_BEHIND || sums == TTF_SUMS_WRONG)) {
        r = ttf_sums_rebuild(writer->io, writer->path, err);
        writer->state.repaired++;
    }
    if (r)
        return r;
    if (writer->state.repaired > before) {
        snprintf(text, sizeof(text), "%s%s%s", told, told[0] && sums != TTF_SUMS_SAME ? "; " : "",
                 sums == TTF_SUMS_BEHIND  ? TTF_SUMS_NAME " brought up to date"
                 : sums == TTF_SUMS_WRONG ? TTF_SUMS_NAME " had a wrong line: written anew"
                                          : "");
        r = ttf_writer_event(writer, "repair", TTF_NS_UNKNOWN, TTF_NS_UNKNOWN, text, NULL, err);
    }
    return r;
}
