/* SPDX-License-Identifier: Apache-2.0 */
/* verify_people.c: what people added: nothing in it is damage, but a line that no reader understands is worth a word. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"
#include "verify_private.h"

static void wrong_line(void *ctx, int64_t line, const char *what)
{
    struct ttf_verify_run *run = ctx;
    char file[40];

    snprintf(file, sizeof(file), "notes.jsonl:%lld", (long long)line);
    ttf_verify_find(run, TTF_FINDING_NOTE, -1, file, "is not understood: %.150s", what);
}

static void cannot_be_read(struct ttf_verify_run *run, const char *file, int code,
                           const struct ttf_err *why)
{
    if (code < 0 && !ttf_verify_kept_from(run, code))
        ttf_verify_find(run, TTF_FINDING_NOTE, -1, file, "is not understood: %.150s", why->what);
}

/* Not what anybody meant, and no reader can show it. */
static void look_at_regions(struct ttf_verify_run *run, const struct ttf_sample_region *samples,
                            unsigned n)
{
    const struct ttf_stream *primary =
        run->has_manifest ? ttf_manifest_primary(&run->manifest) : NULL;

    for (unsigned i = 0; primary && i < n; i++)
        if (!ttf_sample_rect_is_within(&samples[i].region, primary->width, primary->height))
            ttf_verify_find(run, TTF_FINDING_NOTE, -1, "samples.json",
                            "the region of '%s' reaches outside of the picture", samples[i].id);
}

void ttf_verify_people(struct ttf_verify_run *run)
{
    const struct ttf_note_visitor visitor = {.wrong = wrong_line, .ctx = run};
    struct ttf_sample_region *samples;
    struct ttf_err why = {0};
    unsigned n;

    cannot_be_read(run, "notes.jsonl", ttf_notes_read(run->io, run->path, &visitor, &why), &why);
    cannot_be_read(run, "samples.json", ttf_samples_read(run->io, run->path, &samples, &n, &why),
                   &why);
    look_at_regions(run, samples, n);
    free(samples);
}
