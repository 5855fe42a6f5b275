/* SPDX-License-Identifier: Apache-2.0 */
/* verify: SHA256SUMS and the seal, and what lies in the folder without belonging there. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "manifest_rules.h"
#include "sums.h"
#include "verify_private.h"

/* ---- sealed: SHA256SUMS is the whole truth ---- */

/* One line of a sealed list: against the record, or against the file. */
static void check_listed(struct ttf_verify_run *run, const char *path, const char *sha256,
                         const char *where)
{
    const struct ttf_named *named = ttf_named_files_find(&run->named, path);

    if (!named)
        ttf_verify_queue(run, path, -1, sha256, true, -1);
    else if (memcmp(named->sha256, sha256, 64) != 0)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, ttf_path_index(path), where,
                        "gives %.150s another sha256 than its record", path);
}

static int by_name(const void *key, const void *item)
{
    return strcmp(key, *(char *const *)item);
}

/* A path that no record names and nothing lies at is the damage itself: others are not measured by it. */
static bool is_somewhere(const struct ttf_verify_run *run, const struct ttf_paths *files,
                         const char *path)
{
    return ttf_named_files_find(&run->named, path) ||
           (files->n > 0 && bsearch(path, files->items, files->n, sizeof(*files->items), by_name));
}

static void read_list(struct ttf_verify_run *run, int file, const struct ttf_paths *files,
                      struct ttf_named_files *listed)
{
    struct ttf_lines lines;
    const char *line, *path;
    char name[200], last[200] = "", where[40];
    bool terminated;
    int64_t offset;
    size_t n;
    int r;

    ttf_lines_init(&lines, run->io, file);
    while ((r = ttf_lines_next(&lines, &line, &n, &offset, &terminated)) > 0) {
        snprintf(where, sizeof(where), TTF_SUMS_NAME ":%lld", (long long)lines.number);
        name[0] = '\0';
        if (terminated && ttf_sums_parse(line, n, &path) && n - TTF_SUMS_PREFIX < sizeof(name))
            snprintf(name, sizeof(name), "%.*s", (int)(n - TTF_SUMS_PREFIX), path);
        if (!ttf_path_ok(name)) {
            ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, where, "is no line that sha256sum checks");
            continue;
        }
        if (strcmp(name, last) <= 0)
            ttf_verify_find(
                run, TTF_FINDING_DAMAGE, -1, where,
                "%.150s does not come behind %.150s: a seal lists by the bytes of the paths", name,
                last);
        if (is_somewhere(run, files, name))
            memcpy(last, name, sizeof(last));
        if (ttf_named_files_add(listed, name, line) != 0) {
            run->failed = -ENOMEM;
            break;
        }
        check_listed(run, name, line, where);
    }
    if (r < 0 && !ttf_verify_kept_from(run, r))
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, TTF_SUMS_NAME, "cannot be read: %s",
                        strerrordesc_np(-r));
    ttf_lines_free(&lines);
    ttf_named_files_sort(listed);
}

static bool starts(const char *path, const char *with)
{
    return strncmp(path, with, strlen(with)) == 0;
}

/* A file that the seal does not cover: harmless only where other programs may put theirs. */
static void unlisted(struct ttf_verify_run *run, const char *path)
{
    bool ours = starts(path, "frames/") || starts(path, "raw/") || starts(path, "plans/") ||
                starts(path, "calibration/") || strcmp(path, "dataset.json") == 0 ||
                strcmp(path, "events.jsonl") == 0;

    if (ttf_is_temporary(path))
        ttf_verify_find(run, TTF_FINDING_LEFTOVER, -1, path, "is a leftover temporary file");
    else if (ours && ttf_path_ok(path))
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, path,
                        "is not covered by the seal: " TTF_SUMS_NAME " does not list it");
    else
        ttf_verify_find(run, TTF_FINDING_NOTE, -1, path, "does not belong to the sealed dataset");
}

static bool outside_by_rule(const char *path)
{
    return strcmp(path, "notes.jsonl") == 0 || strcmp(path, "samples.json") == 0 ||
           strcmp(path, "report.json") == 0 || strcmp(path, TTF_SUMS_NAME) == 0;
}

static void check_sealed(struct ttf_verify_run *run, const struct ttf_paths *files)
{
    struct ttf_named_files listed = {0};
    char *path = ttf_path_format("%s/" TTF_SUMS_NAME, run->path);
    size_t i;
    int file = path ? run->io->ops->open(run->io, path, TTF_IO_READ) : -ENOMEM;

    free(path);
    if (ttf_verify_kept_from(run, file))
        return;
    if (file < 0) {
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, TTF_SUMS_NAME, "cannot be opened: %s",
                        strerrordesc_np(-file));
        return;
    }
    read_list(run, file, files, &listed);
    run->io->ops->close(run->io, file);
    for (i = 0; i < run->named.n; i++)
        if (!ttf_named_files_find(&listed, run->named.items[i].path))
            ttf_verify_find(run, TTF_FINDING_DAMAGE, ttf_path_index(run->named.items[i].path),
                            run->named.items[i].path,
                            "is named by a record, but not covered by the seal: " TTF_SUMS_NAME
                            " does not list it");
    for (i = 0; i < files->n; i++)
        if (!outside_by_rule(files->items[i]) && !ttf_named_files_find(&listed, files->items[i]) &&
            !ttf_named_files_find(&run->named, files->items[i]))
            unlisted(run, files->items[i]);
    ttf_named_files_free(&listed);
}

/* ---- unsealed: what a crash leaves is no damage ---- */

static void check_running(struct ttf_verify_run *run)
{
    struct ttf_sums_verdict sums;
    struct ttf_err err = {0};
    char where[40];
    int r;

    if (!run->records_good)
        return; /* what it should hold is not known */
    r = ttf_sums_compare(run->io, run->path, &sums, &err);
    if (ttf_verify_kept_from(run, r))
        return;
    if (r) {
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, TTF_SUMS_NAME, "%.200s", err.what);
        return;
    }
    snprintf(where, sizeof(where), TTF_SUMS_NAME ":%lld", (long long)sums.line);
    if (sums.state == TTF_SUMS_BEHIND)
        ttf_verify_find(run, TTF_FINDING_LEFTOVER, -1, TTF_SUMS_NAME,
                        "is behind the records; opening for writing brings it up to date");
    else if (sums.state == TTF_SUMS_WRONG)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, ttf_path_index(sums.path), where,
                        "has changed: the records have other files, or another sha256");
    else if (sums.state == TTF_SUMS_SEAL)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, where,
                        "is of a seal, as it lists %.120s, but there is no line of records.jsonl",
                        sums.path);
    else if (sums.state == TTF_SUMS_AHEAD)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, ttf_path_index(sums.path), "records.jsonl",
                        "has lost lines: " TTF_SUMS_NAME " lists %.150s, which no record names",
                        sums.path);
}

/* Files of one slot that has no record yet are what a crash leaves; of several no crash does. */
static bool strays_of_one_slot(const struct ttf_verify_run *run, const struct ttf_paths *files)
{
    int64_t index, one = -1;
    size_t i;

    for (i = 0; i < files->n; i++) {
        index = ttf_path_index(files->items[i]);
        if (index < run->next_index || ttf_is_temporary(files->items[i]))
            continue;
        if (one >= 0 && index != one)
            return false;
        one = index;
    }
    return true;
}

static enum ttf_severity stray(const struct ttf_verify_run *run, const char *path, bool one_slot)
{
    if (starts(path, "plans/") || starts(path, "calibration/"))
        return TTF_FINDING_LEFTOVER;
    return one_slot && ttf_path_index(path) >= run->next_index ? TTF_FINDING_LEFTOVER
                                                               : TTF_FINDING_NOTE;
}

static void check_strays(struct ttf_verify_run *run, const struct ttf_paths *files)
{
    bool one_slot = strays_of_one_slot(run, files);
    const char *path;
    size_t i;

    for (i = 0; i < files->n; i++) {
        path = files->items[i];
        if (ttf_is_temporary(path))
            ttf_verify_find(run, TTF_FINDING_LEFTOVER, ttf_path_index(path), path,
                            "is a leftover temporary file");
        else if ((starts(path, "frames/") || starts(path, "raw/") || starts(path, "calibration/") ||
                  starts(path, "plans/")) &&
                 run->records_good && !ttf_named_files_find(&run->named, path))
            ttf_verify_find(run, stray(run, path, one_slot), ttf_path_index(path), path,
                            "is named by no record");
    }
}

void ttf_verify_sums(struct ttf_verify_run *run)
{
    struct ttf_paths files = {0};
    struct ttf_err err = {0};
    int r;

    r = ttf_walk(run->io, run->path, &files, &err);
    if (ttf_verify_kept_from(run, r))
        return;
    if (r) {
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, ".", "%.200s", err.what);
        return;
    }
    if (run->report->sealed) {
        check_sealed(run, &files);
    } else {
        check_running(run);
        check_strays(run, &files);
    }
    ttf_paths_free(&files);
}
