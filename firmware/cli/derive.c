/* SPDX-License-Identifier: Apache-2.0 */
/* derive.c: see derive.h. */
#include "derive.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"

/* Appends to a text that is cut where it is full. */
static void add(char *buf, size_t size, const char *before, const char *text)
{
    size_t n = strlen(buf);

    (void)snprintf(buf + n, size - n, "%s%s", before, text);
}

/* What changes no bit of the result. */
static bool says_nothing(enum cli_option option)
{
    return option == OPT_GROUP || option == OPT_OUTPUT || option == OPT_JSON ||
           option == OPT_QUIET || option == OPT_THREADS;
}

static void add_option(const struct cli_options *o, enum cli_option option, char *buf, size_t size)
{
    const char *name = cli_option_def(option)->name;
    bool repeated = option == OPT_SOURCE;

    for (unsigned i = 0; i < (repeated ? o->n_sources : 1); i++) {
        const char *value = repeated ? o->sources[i] : o->given[option];

        add(buf, size, " --", name);
        if (*value)
            add(buf, size, " ", value);
    }
}

const char *derive_command(const struct cli *cli, char *buf, size_t size)
{
    const struct cli_options *o = &cli->opt;

    (void)snprintf(buf, size, "%s", cli->command->name);
    for (unsigned i = 0; i < o->n_args; i++)
        add(buf, size, " ", o->args[i]);
    for (const struct cli_command_option *at = cli->command->options; at->option != OPT_END; at++)
        if (!says_nothing(at->option) && cli_given(o, at->option))
            add_option(o, at->option, buf, size);
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

int derive_create(struct cli *cli, const char *path, const struct ttf_manifest *manifest,
                  const char *plan_yaml, const char *plan_json, struct ttf_writer **ret)
{
    int r = ttf_writer_create(cli->io, path, manifest, plan_yaml, plan_json, ret, &cli->err);

    /* What another made there meanwhile is theirs. */
    if (r < 0 && r != -EEXIST && r != -ENOTEMPTY && r != -EBUSY)
        derive_discard(cli->io, path);
    return r;
}
