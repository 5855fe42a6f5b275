/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_input.c: see quilt_input.h. */
#include "quilt_input.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt_options.h"

struct ttf_sequence *quilt_input_top(const struct quilt_input *input)
{
    return input->chain[input->depth - 1];
}

static void push(struct quilt_input *input, struct ttf_sequence *sequence)
{
    input->chain[input->depth++] = sequence;
}

/* ---- the first n frames ---- */

struct first_frames {
    struct ttf_sequence base;
    struct ttf_sequence *whole;
};

static int first_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                      uint16_t *dst, struct ttf_err *err)
{
    return ttf_sequence_read_rows(((struct first_frames *)sequence)->whole, t, y0, rows, dst, err);
}

static void first_destroy(struct ttf_sequence *sequence)
{
    free(sequence);
}

static int take_first(struct cli *cli, struct quilt_input *input)
{
    static const struct ttf_sequence_ops OPS = {.read_rows = first_rows, .destroy = first_destroy};
    struct ttf_sequence *whole = quilt_input_top(input);
    struct first_frames *f;

    if (cli->opt.frames == 0 || cli->opt.frames >= whole->n)
        return 0;
    f = malloc(sizeof *f);
    if (!f)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    f->base = *whole;
    f->base.ops = &OPS;
    f->base.n = (uint32_t)cli->opt.frames;
    f->whole = whole;
    push(input, &f->base);
    return 0;
}

/* ---- opening ---- */

int quilt_input_open(struct cli *cli, const char *path, struct quilt_input *ret)
{
    const struct ttf_sequence_choice choice = cli_choice(cli);
    struct ttf_sequence *whole = NULL;
    struct ttf_io_stat st;
    int r = cli->io->ops->stat(cli->io, path, &st);

    if (r < 0)
        return ttf_err_set(&cli->err, r, path, "%s", strerrordesc_np(-r));
    if (st.is_dir) {
        r = ttf_reader_open_by_heads(cli->io, path, &ret->reader, &cli->err);
        if (r == 0)
            r = ttf_sequence_of_dataset(ret->reader, &choice, &whole, &cli->err);
    } else {
        r = ttf_sequence_of_image(cli->io, path, &whole, &cli->err);
    }
    if (r == 0 && whole->n_excluded > 0)
        cli_warn("%s: %u slots are left out, as notes say (--with-excluded takes them too)", path,
                 whole->n_excluded);
    if (r == 0) {
        push(ret, whole);
        r = take_first(cli, ret);
    }
    if (r < 0)
        quilt_input_close(ret);
    return r;
}

void quilt_input_close(struct quilt_input *input)
{
    while (input->depth > 0)
        ttf_sequence_destroy(input->chain[--input->depth]);
    ttf_gradient_free(&input->gradient);
    ttf_reader_close(input->reader);
    memset(input, 0, sizeof *input);
}

/* ---- of one material? ---- */

struct meaning {
    const char *quantity, *unit, *colour_space;
};

static struct meaning meaning_of(const struct cli *cli, const struct quilt_input *input)
{
    const struct ttf_manifest *m = input->reader ? ttf_reader_manifest(input->reader) : NULL;
    const struct ttf_stream *stream = NULL;

    if (m)
        stream =
            cli->opt.stream ? ttf_manifest_stream(m, cli->opt.stream) : ttf_manifest_primary(m);
    if (!stream)
        return (struct meaning){"radiance", "1", "linear-srgb"}; /* as of an import */
    return (struct meaning){stream->quantity, stream->unit, stream->colour_space};
}

int quilt_input_mixes(struct cli *cli, const struct quilt_input *first,
                      const struct quilt_input *other, const char *path)
{
    struct meaning a = meaning_of(cli, first), b = meaning_of(cli, other);

    if (strcmp(a.quantity, b.quantity) == 0 && strcmp(a.unit, b.unit) == 0 &&
        strcmp(a.colour_space, b.colour_space) == 0)
        return 0;
    ttf_err_set(&cli->err, -EINVAL, "--source",
                "%s is of %s (unit %s, colours %s), the first input of %s (unit %s, colours %s)",
                path, b.quantity, b.unit, b.colour_space, a.quantity, a.unit, a.colour_space);
    return ttf_err_hint(&cli->err, "their pixels would stand side by side and mean different "
                                   "things: develop both in the same way"),
           -EINVAL;
}

void quilt_input_name(const struct quilt_input *input, struct ttf_report_source *ret)
{
    *ret = (struct ttf_report_source){0};
    if (!input->reader)
        return;
    memcpy(ret->uuid, ttf_reader_manifest(input->reader)->uuid, sizeof ret->uuid);
    if (ttf_reader_digest(input->reader, ret->digest, NULL) < 0)
        ret->digest[0] = '\0';
}

/* ---- preparing ---- */

int quilt_input_reduce(struct cli *cli, struct quilt_input *input, uint32_t shrink, uint32_t step)
{
    struct ttf_sequence *reduced = NULL;
    int r = ttf_reduce_create(quilt_input_top(input), shrink, step, &reduced, &cli->err);

    if (r == 0)
        push(input, reduced);
    return cli_by_option(cli, r, "--preview", NULL);
}

static int stabilise(struct cli *cli, struct quilt_input *input,
                     struct ttf_report_prepared *prepared)
{
    struct ttf_sequence *over = NULL;
    int r = ttf_stabilise_create(quilt_input_top(input), 0, &over, &prepared->stabilise, &cli->err);

    if (r == -ERANGE)
        ttf_err_hint(&cli->err, "leave out the frames from there on (--frames), or this option");
    if (r < 0)
        return cli_by_option(cli, r, "--stabilise", NULL);
    prepared->stabilised = true;
    push(input, over);
    return 0;
}

static int deflicker(struct cli *cli, struct quilt_input *input,
                     struct ttf_report_prepared *prepared)
{
    struct ttf_sequence *over = NULL;
    uint32_t step = prepared->reduced ? prepared->step : 1;
    /* an odd number of the frames kept, as a frame is in the window's middle; the least there is */
    uint32_t window = quilt_frames_kept((uint32_t)cli->opt.deflicker_window, step, 3) | 1u;
    int r = ttf_deflicker_create(quilt_input_top(input), window, &over, &prepared->deflicker,
                                 &cli->err);

    if (r < 0)
        return cli_by_option(cli, r, "--deflicker", NULL);
    prepared->deflickered = true;
    prepared->deflicker_window = window;
    push(input, over);
    return 0;
}

int quilt_input_steady(struct cli *cli, struct quilt_input *input,
                       struct ttf_report_prepared *prepared)
{
    int r = cli->opt.stabilise ? stabilise(cli, input, prepared) : 0;

    if (r == 0 && cli->opt.deflicker)
        r = deflicker(cli, input, prepared);
    return r;
}

int quilt_input_flatten(struct cli *cli, struct quilt_input *input, double sigma_px,
                        struct ttf_report_prepared *prepared)
{
    struct ttf_sequence *over = NULL;
    int r = ttf_gradient_find(quilt_input_top(input), sigma_px, TTF_GRADIENT_MEAN, &input->gradient,
                              &cli->err);

    if (r == 0)
        r = ttf_flatten_create(quilt_input_top(input), &input->gradient, &over, &cli->err);
    if (r < 0)
        return cli_by_option(cli, r, "--flatten", NULL);
    ttf_gradient_range(&input->gradient, &prepared->gradient_least, &prepared->gradient_most);
    prepared->flattened = true;
    prepared->gradient_sigma_px = sigma_px;
    push(input, over);
    return 0;
}
