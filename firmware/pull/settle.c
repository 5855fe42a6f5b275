/* SPDX-License-Identifier: Apache-2.0 */
#include "settle.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "landing.h"

#define PATH_SIZE   4600
#define STACK_BYTES ((size_t)256 << 10)
#define HELPERS     15 /* threads that sync beside whoever settles */
#define TOGETHER    8u /* files for which the whole file system is synced */
/* A sync of all that takes so long waits for what others write; so many batches after it are synced file by file. */
#define SLOW_NS     TTF_NS_PER_S
#define APART       16u

static int sync_file(struct settling *settling, const char *path)
{
    char final[PATH_SIZE];
    int file, r;

    (void)snprintf(final, sizeof final, "%s/%s", settling->folder, path);
    file = settling->io->ops->open(settling->io, final, TTF_IO_READ);
    if (file < 0)
        return file;
    r = settling->io->ops->sync(settling->io, file, true);
    (void)settling->io->ops->close(settling->io, file);
    return r;
}

/* The folder that a file lies in, and those above: another hand may have made one of them a moment ago, or a pull that was killed. */
static int sync_folders(struct settling *settling, const char *path)
{
    size_t above = strlen(settling->folder);
    char whole[PATH_SIZE], *slash;
    int r = 0;

    (void)snprintf(whole, sizeof whole, "%s/%s", settling->folder, path);
    while (r == 0 && (slash = strrchr(whole + above, '/'))) {
        *slash = '\0';
        r = settling->io->ops->sync_dir(settling->io, whole);
    }
    return r;
}

/* What a sync that failed leaves may be on the disk or not, and the next sync would not say so again: it is to come anew. */
static void take_away(struct settling *settling)
{
    for (unsigned i = 0; i < settling->n; i++)
        settle_forget(settling, settling->paths[i]);
}

void settle_forget(const struct settling *settling, const char *path)
{
    static const char *const ENDS[] = {"", ".tmp"};
    char whole[PATH_SIZE];

    if (settling->failed == 0 || !landing_is_image(path))
        return; /* dataset.json: without it the folder is none */
    for (unsigned i = 0; i < sizeof ENDS / sizeof *ENDS; i++) {
        (void)snprintf(whole, sizeof whole, "%s/%s%s", settling->folder, path, ENDS[i]);
        (void)settling->io->ops->unlink(settling->io, whole);
    }
}

/* Does an earlier one of the batch lie in the same folder? */
static bool same_folder(const struct settling *settling, unsigned i)
{
    const char *slash = strrchr(settling->paths[i], '/');
    size_t n = slash ? (size_t)(slash - settling->paths[i]) + 1 : 0;

    for (unsigned k = i; k-- > 0;) /* most often the last one does */
        if (strncmp(settling->paths[k], settling->paths[i], n) == 0 &&
            !strchr(settling->paths[k] + n, '/'))
            return true;
    return false;
}

struct round {
    struct settling *settling;
    atomic_uint next;
    atomic_int failed;
};

static void *sync_some(void *ctx)
{
    struct round *round = ctx;
    unsigned i;

    while ((i = atomic_fetch_add(&round->next, 1)) < round->settling->n &&
           atomic_load(&round->failed) == 0) {
        int r = sync_file(round->settling, round->settling->paths[i]);

        if (r < 0)
            atomic_store(&round->failed, r);
    }
    return NULL;
}

/*
 * Each sync waits for the disk's journal, and one turn of that serves all who wait at the same time: alone, one after another, they
 * take longer than the files took to come. Signals are the program's own threads'.
 */
static int sync_files(struct settling *settling)
{
    struct round round = {.settling = settling};
    pthread_t threads[HELPERS];
    unsigned n = 0, wanted = settling->n / 4 < HELPERS ? settling->n / 4 : HELPERS;
    sigset_t all, before;
    pthread_attr_t small; /* stacks that the C library keeps for the next time */

    (void)sigfillset(&all);
    if (wanted > 0 && pthread_attr_init(&small) == 0) {
        if (pthread_attr_setstacksize(&small, STACK_BYTES) == 0 &&
            pthread_sigmask(SIG_SETMASK, &all, &before) == 0) {
            while (n < wanted && pthread_create(&threads[n], &small, sync_some, &round) == 0)
                n++;
            (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
        }
        (void)pthread_attr_destroy(&small);
    }
    (void)sync_some(&round);
    while (n > 0)
        (void)pthread_join(threads[--n], NULL);
    return atomic_load(&round.failed);
}

static int sync_each(struct settling *settling)
{
    int r = sync_files(settling);

    for (unsigned i = 0; r == 0 && i < settling->n; i++)
        if (!same_folder(settling, i))
            r = sync_folders(settling, settling->paths[i]);
    return r;
}

/* Are all of the batch on the dataset's own file system? */
static bool on_one_disk(const struct settling *settling)
{
    struct ttf_io *io = settling->io;
    struct ttf_io_stat whole, st;
    char path[PATH_SIZE];

    if (io->ops->stat(io, settling->folder, &whole) < 0 || whole.device == 0)
        return false;
    for (unsigned i = 0; i < settling->n; i++) {
        if (same_folder(settling, i))
            continue;
        (void)snprintf(path, sizeof path, "%s/%s", settling->folder, settling->paths[i]);
        if (io->ops->stat(io, path, &st) < 0 || st.device != whole.device)
            return false;
    }
    return true;
}

/*
 * One turn of the journal for all of them. The folder's own sync behind it costs little, and finds what is left: a file system that gave
 * up its journal meanwhile (before Linux 5.17 syncfs does not say so), and what one without a journal leaves in the disk's own cache.
 */
static int sync_together(struct settling *settling)
{
    int64_t begun_ns = ttf_clock_now_ns(settling->clock);
    int r = ttf_io_sync_all(settling->io, settling->handle);

    if (r == 0)
        r = settling->io->ops->sync_dir(settling->io, settling->folder);
    if (ttf_clock_now_ns(settling->clock) - begun_ns > SLOW_NS)
        settling->apart = APART;
    return r;
}

static int sync_batch(struct settling *settling)
{
    int r = -EOPNOTSUPP;

    if (settling->n == 0)
        return 0;
    if (settling->apart > 0)
        settling->apart--;
    else if (settling->n >= TOGETHER && settling->handle >= 0 && on_one_disk(settling))
        r = sync_together(settling);
    return r == -EOPNOTSUPP ? sync_each(settling) : r;
}

int settle_all(struct settling *settling, struct ttf_err *err)
{
    int r = settling->failed;

    if (r == 0)
        r = sync_batch(settling);
    settling->failed = r;
    if (r < 0)
        take_away(settling);
    settling->n = 0;
    if (r < 0)
        return ttf_err_set(err, r, settling->folder, "cannot be synced: %s", strerrordesc_np(-r));
    return 0;
}

int settle_add(struct settling *settling, const char *path, struct ttf_err *err)
{
    (void)snprintf(settling->paths[settling->n++], sizeof settling->paths[0], "%s", path);
    return settling->n == SETTLE_MOST ? settle_all(settling, err) : 0;
}
