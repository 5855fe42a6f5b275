/* SPDX-License-Identifier: Apache-2.0 */
#include "commit_place.h"

#include <errno.h>
#include <string.h>

#include "commit_storage.h"

void ttf_committer_note_place(struct ttf_committer *c)
{
    struct ttf_io_stat st;

    c->inode = 0; /* not known: never another one */
    if (!c->writer)
        return;
    memcpy(c->uuid, ttf_writer_manifest(c->writer)->uuid, sizeof(c->uuid));
    if (c->io->ops->stat(c->io, c->path, &st) == 0) {
        c->device = st.device;
        c->inode = st.inode;
    }
}

enum ttf_place ttf_committer_place(const struct ttf_committer *c)
{
    struct ttf_manifest there;
    struct ttf_io_stat st;
    int r;

    if (c->inode == 0)
        return TTF_PLACE_SAME;
    r = c->io->ops->stat(c->io, c->path, &st);
    if (r == -ENOENT)
        return TTF_PLACE_GONE;
    if (r < 0 || st.inode == 0 || (st.device == c->device && st.inode == c->inode))
        return TTF_PLACE_SAME;
    r = ttf_manifest_load(c->io, c->path, &there, NULL);
    if (r == 0)
        return strcmp(there.uuid, c->uuid) == 0 ? TTF_PLACE_BACK : TTF_PLACE_OTHER;
    return r == -ENOMEM ? TTF_PLACE_SAME : TTF_PLACE_OTHER;
}

int ttf_committer_come_back(struct ttf_committer *c, struct ttf_err *err)
{
    enum ttf_place place = ttf_committer_place(c);
    int r;

    if (place == TTF_PLACE_SAME)
        return 0;
    if (place == TTF_PLACE_GONE)
        return ttf_err_set(err, -EIO, c->path, "the dataset's folder is gone");
    if (place == TTF_PLACE_OTHER) {
        ttf_err_set(err, -ESTALE, c->path, "another folder lies here than the run began in");
        ttf_err_hint(err, "a disk was mounted over it, or taken away: run again");
        return -ESTALE;
    }
    r = ttf_committer_reopen(c);
    return r < 0 ? ttf_err_set(err, r, c->path, "the dataset cannot be opened anew") : 0;
}
