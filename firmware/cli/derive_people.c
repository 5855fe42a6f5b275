/* SPDX-License-Identifier: Apache-2.0 */
/* derive_people.c: what people said of a dataset, for one whose slots and pixels are the same. */
#include <errno.h>
#include <stdlib.h>

#include "derive.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"

struct notes {
    struct cli *cli;
    const char *to;
    int code;
};

static void copy_note(void *ctx, const struct ttf_note *note)
{
    struct notes *n = ctx;

    if (n->code == 0)
        n->code = ttf_note_append(n->cli->io, n->to, note, &n->cli->err);
}

static int copy_notes(struct cli *cli, const char *from, const char *to)
{
    struct notes n = {cli, to, 0};
    const struct ttf_note_visitor visitor = {.note = copy_note, .ctx = &n};
    int r = ttf_notes_read(cli->io, from, &visitor, &cli->err);

    return r < 0 ? r : n.code;
}

/* All at once. */
static int add_samples(struct cli *cli, const struct ttf_sample_region *samples, unsigned n,
                       const char *to)
{
    struct ttf_sample_change *changes = calloc(n, sizeof *changes);
    int r;

    if (!changes)
        return ttf_err_set(&cli->err, -ENOMEM, to, "no memory for %u samples", n);
    for (unsigned i = 0; i < n; i++)
        changes[i] = (struct ttf_sample_change){.id = samples[i].id,
                                                .title = samples[i].title,
                                                .treatment = samples[i].treatment,
                                                .region = &samples[i].region};
    r = ttf_samples_change(cli->io, to, changes, n, &cli->err);
    free(changes);
    return r;
}

static int copy_samples(struct cli *cli, const char *from, const char *to)
{
    struct ttf_sample_region *samples = NULL;
    unsigned n = 0;
    int r = ttf_samples_read(cli->io, from, &samples, &n, &cli->err);

    if (r == 0 && n > 0)
        r = add_samples(cli, samples, n, to);
    free(samples);
    return r;
}

int derive_people(struct cli *cli, const char *from, const char *to)
{
    int r = copy_notes(cli, from, to);

    return r < 0 ? r : copy_samples(cli, from, to);
}
