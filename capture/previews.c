/* SPDX-License-Identifier: Apache-2.0 */
#include "previews.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Looked for in one pass over the folders. */
#define BATCH 32

#define NAME_BYTES 160 /* "STREAM/NAME", each of at most 64 */

struct oldest {
    struct ttf_io *io;
    const char *folder; /* .../preview */
    char sub[80];       /* "STREAM/", or empty */
    unsigned n;
    char name[BATCH][NAME_BYTES]; /* sorted */
};

/* By the slot's index, which a preview's name begins with; then by name. */
static int compare(const char *a, const char *b)
{
    const char *file_a = strrchr(a, '/');
    const char *file_b = strrchr(b, '/');
    long long index_a = strtoll(file_a ? file_a + 1 : a, NULL, 10);
    long long index_b = strtoll(file_b ? file_b + 1 : b, NULL, 10);

    if (index_a != index_b)
        return index_a < index_b ? -1 : 1;
    return strcmp(a, b);
}

static void keep_if_old(struct oldest *o, const char *name)
{
    char full[NAME_BYTES];
    unsigned at;

    if (snprintf(full, sizeof(full), "%s%s", o->sub, name) >= (int)sizeof(full))
        return;
    for (at = o->n; at > 0 && compare(full, o->name[at - 1]) < 0; at--)
        ;
    if (at == BATCH)
        return;
    if (o->n == BATCH)
        o->n--;
    memmove(o->name[at + 1], o->name[at], (o->n - at) * NAME_BYTES);
    memcpy(o->name[at], full, sizeof(full));
    o->n++;
}

static int look(void *ctx, const char *name, bool is_dir)
{
    struct oldest *o = ctx;
    char path[4096];

    if (!is_dir) {
        keep_if_old(o, name);
    } else if (o->sub[0] == '\0') {
        if (snprintf(path, sizeof(path), "%s/%s", o->folder, name) < (int)sizeof(path) &&
            snprintf(o->sub, sizeof(o->sub), "%s/", name) < (int)sizeof(o->sub))
            (void)o->io->ops->list(o->io, path, look, o);
        o->sub[0] = '\0';
    }
    return 0;
}

static bool room(struct ttf_io *io, const char *folder, int64_t free_bytes)
{
    struct ttf_io_space space;

    return io->ops->space(io, folder, &space) == 0 && space.free_bytes >= free_bytes;
}

unsigned ttf_previews_remove(struct ttf_io *io, const char *dataset, int64_t free_bytes)
{
    char folder[4096];
    char path[4096 + NAME_BYTES];
    struct oldest o = {.io = io, .folder = folder};
    unsigned removed = 0;
    unsigned before;

    if (snprintf(folder, sizeof(folder), "%s/preview", dataset) >= (int)sizeof(folder))
        return 0;
    do {
        before = removed;
        o.n = 0;
        if (room(io, folder, free_bytes) || io->ops->list(io, folder, look, &o) < 0)
            break;
        for (unsigned i = 0; i < o.n && !room(io, folder, free_bytes); i++) {
            snprintf(path, sizeof(path), "%s/%s", folder, o.name[i]);
            if (io->ops->unlink(io, path) == 0)
                removed++;
        }
    } while (removed > before);
    return removed;
}
