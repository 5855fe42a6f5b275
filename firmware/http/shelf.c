/* SPDX-License-Identifier: Apache-2.0 */
#include "shelf.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

struct shelves {
    char *path;
    pthread_mutex_t lock; /* over what follows, and the users of each shelf */
    struct shelf *newest;
};

static void shelf_free(struct shelf *shelf)
{
    folder_close(&shelf->folder);
    summaries_destroy(shelf->summaries);
    derived_destroy(shelf->derived);
    free(shelf);
}

static int shelf_open(const char *path, struct shelf **ret, struct ttf_err *err)
{
    struct shelf *shelf = calloc(1, sizeof *shelf);
    struct stat st;
    int r;

    if (!shelf)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = folder_open(path, &shelf->folder, err);
    if (r == 0 && fstat(shelf->folder.fd, &st) < 0)
        r = ttf_err_set(err, -errno, path, "cannot be looked at");
    if (r == 0) {
        shelf->device = st.st_dev;
        shelf->inode = st.st_ino;
        shelf->summaries = summaries_create();
        shelf->derived = derived_create();
        if (!shelf->summaries || !shelf->derived)
            r = ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    if (r < 0) {
        shelf_free(shelf);
        return r;
    }
    shelf->users = 1;
    *ret = shelf;
    return 0;
}

int shelves_create(const char *path, struct shelves **ret, struct ttf_err *err)
{
    struct shelves *shelves = calloc(1, sizeof *shelves);
    int r;

    if (!shelves)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)pthread_mutex_init(&shelves->lock, NULL);
    shelves->path = strdup(path);
    r = shelves->path ? shelf_open(path, &shelves->newest, err)
                      : ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (r < 0) {
        shelves_destroy(shelves);
        return r;
    }
    *ret = shelves;
    return 0;
}

void shelves_destroy(struct shelves *shelves)
{
    if (!shelves)
        return;
    if (shelves->newest)
        shelf_free(shelves->newest);
    (void)pthread_mutex_destroy(&shelves->lock);
    free(shelves->path);
    free(shelves);
}

bool shelves_other(const struct shelves *shelves, const struct shelf *shelf)
{
    struct stat st;

    return stat(shelves->path, &st) == 0 && S_ISDIR(st.st_mode) &&
           (st.st_dev != shelf->device || st.st_ino != shelf->inode);
}

void shelves_give(struct shelves *shelves, struct shelf *shelf)
{
    bool last;

    (void)pthread_mutex_lock(&shelves->lock);
    last = --shelf->users == 0;
    (void)pthread_mutex_unlock(&shelves->lock);
    if (last)
        shelf_free(shelf);
}

static struct shelf *take_newest(struct shelves *shelves)
{
    struct shelf *shelf;

    (void)pthread_mutex_lock(&shelves->lock);
    shelf = shelves->newest;
    shelf->users++;
    (void)pthread_mutex_unlock(&shelves->lock);
    return shelf;
}

/* The disk is asked without the lock: one that hangs keeps only those waiting who ask of it. */
struct shelf *shelves_take(struct shelves *shelves)
{
    struct shelf *shelf = take_newest(shelves);
    struct shelf *before, *other = NULL;

    if (shelves_other(shelves, shelf) && shelf_open(shelves->path, &other, NULL) < 0)
        other = NULL; /* next time */
    if (!other)
        return shelf;
    (void)pthread_mutex_lock(&shelves->lock);
    before = shelves->newest;
    shelves->newest = other;
    other->users++;
    (void)pthread_mutex_unlock(&shelves->lock);
    shelves_give(shelves, before); /* the shelves' own use of it */
    shelves_give(shelves, shelf);
    return other;
}
