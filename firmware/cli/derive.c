/* SPDX-License-Identifier: Apache-2.0 */
/* derive.c: see derive.h. */
#include "derive.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"

const char *derive_command(const struct cli *cli, char *buf, size_t size)
{
    const struct cli_options *o = &cli->opt;
    size_t n = (size_t)snprintf(buf, size, "%s", cli->command->name);

    for (unsigned i = 0; i < o->n_args && n < size; i++)
        n += (size_t)snprintf(buf + n, size - n, " %s", o->args[i]);
    if (o->size[0] && n < size)
        n += (size_t)snprintf(buf + n, size - n, " --size %ux%u", o->size[0], o->size[1]);
    if (o->block[0] && n < size)
        n += (size_t)snprintf(buf + n, size - n, " --block %ux%u", o->block[0], o->block[1]);
    if (o->calibration && n < size)
        n += (size_t)snprintf(buf + n, size - n, " --calibration %s", o->calibration);
    if (o->per_frame && n < size)
        (void)snprintf(buf + n, size - n, " --per-frame");
    return buf;
}

int derive_manifest(struct cli *cli, struct ttf_reader *parent, struct ttf_manifest *ret)
{
    const struct ttf_manifest *old = ttf_reader_manifest(parent);
    char digest[65];
    int r = ttf_manifest_init(ret, &cli->err);

    if (r < 0)
        return r;
    memcpy(ret->box_serial, old->box_serial, sizeof ret->box_serial);
    memcpy(ret->title, old->title, sizeof ret->title);
    ret->simulated = old->simulated;
    memcpy(ret->derived_uuid, old->uuid, sizeof ret->derived_uuid);
    if (ttf_reader_digest(parent, digest, NULL) == 0)
        memcpy(ret->derived_digest, digest, sizeof digest);
    derive_command(cli, ret->derived_command, sizeof ret->derived_command);
    return 0;
}

struct discard {
    struct ttf_io *io;
    const char *folder;
    unsigned depth;
};

static int discard_entry(void *ctx, const char *name, bool is_dir)
{
    const struct discard *d = ctx;
    char path[PATH_MAX];

    (void)snprintf(path, sizeof path, "%s/%s", d->folder, name);
    if (is_dir && d->depth < 8) {
        struct discard below = {d->io, path, d->depth + 1};

        (void)d->io->ops->list(d->io, path, discard_entry, &below);
    }
    (void)d->io->ops->unlink(d->io, path);
    return 0;
}

void derive_discard(struct ttf_io *io, const char *path)
{
    struct discard d = {io, path, 0};

    (void)io->ops->list(io, path, discard_entry, &d);
    (void)io->ops->unlink(io, path);
}
