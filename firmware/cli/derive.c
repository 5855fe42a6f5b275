/* SPDX-License-Identifier: Apache-2.0 */
/* derive.c: see derive.h. */
#include "derive.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
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
    ret->rehearsal = old->rehearsal;
    memcpy(ret->derived_uuid, old->uuid, sizeof ret->derived_uuid);
    if (ttf_reader_digest(parent, digest, NULL) == 0)
        memcpy(ret->derived_digest, digest, sizeof digest);
    derive_command(cli, ret->derived_command, sizeof ret->derived_command);
    return 0;
}

void derive_discard(struct ttf_io *io, const char *path)
{
    char real[PATH_MAX];

    /* A link to a folder was made by whoever gave it as the output: what is in the folder is ours. */
    (void)ttf_io_remove_tree(io, realpath(path, real) ? real : path);
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

int derive_seal(struct ttf_writer *writer, const char *reason, char ret_digest[65],
                struct ttf_err *err)
{
    ret_digest[0] = '\0';
    return ttf_writer_manifest(writer)->rehearsal
               ? 0
               : ttf_writer_seal(writer, reason, ret_digest, err);
}
