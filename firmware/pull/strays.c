/* SPDX-License-Identifier: Apache-2.0 */
#include "strays.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "names.h"
#include "ttf/dataset/copy.h"

#define PREFIX    66 /* digits and two blanks of a line */
#define DEPTH_MAX 16

static int by_bytes(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

struct search {
    struct ttf_io *io;
    const char *folder;
    struct names listed;
    const char **sorted; /* those listed */
    int64_t aside;
};

static int read_list(const char *sums, struct search *s)
{
    size_t i = 0;
    int r = 0;

    for (const char *lf; r == 0 && (lf = strchr(sums, '\n')); sums = lf + 1)
        r = names_add(&s->listed, sums + PREFIX, (size_t)(lf - sums) - PREFIX);
    s->sorted = calloc(s->listed.n + 1, sizeof *s->sorted);
    if (r < 0 || !s->sorted)
        return -ENOMEM;
    for (const char *name = names_first(&s->listed); name; name = names_next(&s->listed, name))
        s->sorted[i++] = name;
    qsort(s->sorted, s->listed.n, sizeof *s->sorted, by_bytes);
    return 0;
}

static bool is_listed(const struct search *s, const char *path)
{
    return bsearch(&path, s->sorted, s->listed.n, sizeof *s->sorted, by_bytes);
}

static int put_aside(struct search *s, const char *path)
{
    char from[4600], to[4608];
    int r;

    (void)snprintf(from, sizeof from, "%s/%s", s->folder, path);
    (void)snprintf(to, sizeof to, "%s.tmp", from);
    r = s->io->ops->rename(s->io, from, to);
    s->aside += r == 0;
    return r;
}

/* What lies in a folder: files that are no dataset's, and folders. */
struct found {
    const struct search *search;
    const char *at;
    struct names files, folders;
};

static int look_at(void *ctx, const char *name, bool is_dir)
{
    struct found *f = ctx;
    char path[192];

    /* Other names are no dataset's; 'verify' says so, and no more. */
    if (name[0] == '.' || (size_t)snprintf(path, sizeof path, "%s/%s", f->at, name) >= sizeof path)
        return 0;
    if (is_dir)
        return names_add(&f->folders, path, strlen(path));
    if (!ttf_is_sealed_file(path) || is_listed(f->search, path))
        return 0;
    return names_add(&f->files, path, strlen(path));
}

static int look_in(struct search *s, const char *at, unsigned depth)
{
    struct found f = {.search = s, .at = at};
    char whole[4600];
    int r;

    (void)snprintf(whole, sizeof whole, "%s/%s", s->folder, at);
    r = depth > DEPTH_MAX ? -ELOOP : s->io->ops->list(s->io, whole, look_at, &f);
    if (r == -ENOENT)
        r = 0;
    for (const char *p = names_first(&f.files); r == 0 && p; p = names_next(&f.files, p))
        r = put_aside(s, p);
    if (r == 0 && f.files.n > 0)
        r = s->io->ops->sync_dir(s->io, whole);
    for (const char *p = names_first(&f.folders); r == 0 && p; p = names_next(&f.folders, p))
        r = look_in(s, p, depth + 1);
    names_free(&f.files);
    names_free(&f.folders);
    return r;
}

int strays_put_aside(struct ttf_io *io, const char *folder, const char *sums, int64_t *ret_n,
                     struct ttf_err *err)
{
    static const char *const FOLDERS[] = {"frames", "raw", "plans", "calibration"};
    static const char EVENTS[] = "events.jsonl";
    struct search s = {.io = io, .folder = folder};
    int r = read_list(sums, &s);

    for (unsigned i = 0; r == 0 && i < sizeof FOLDERS / sizeof *FOLDERS; i++)
        r = look_in(&s, FOLDERS[i], 0);
    if (r == 0 && !is_listed(&s, EVENTS)) {
        r = put_aside(&s, EVENTS);
        r = r == 0 ? io->ops->sync_dir(io, folder) : r == -ENOENT ? 0 : r;
    }
    free(s.sorted);
    names_free(&s.listed);
    *ret_n = s.aside;
    return r == 0
               ? 0
               : ttf_err_set(err, r, folder, "what the seal does not list cannot be put aside: %s",
                             strerrordesc_np(-r));
}
