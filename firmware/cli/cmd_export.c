/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_export.c: `ttfbox export`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "elsewhere.h"
#include "ttf/dataset/export.h"
#include "ttf/dataset/reader.h"

static int on_progress(void *ctx, int64_t done, int64_t total)
{
    cli_progress_at(ctx, done, total, NULL);
    return *cli_stop_flag();
}

/* --to, or else by the output's ending. */
static int choose_kind(struct cli *cli, struct ttf_export_config *config)
{
    const char *dot = strrchr(cli->opt.output, '.');
    const char *name = cli->opt.to ? cli->opt.to : dot ? dot + 1 : "";
    int kind = ttf_export_kind_find(name);

    /* One picture of a whole sequence is a contact sheet; folders have no ending. */
    if (!cli->opt.to && strcmp(name, "png") == 0)
        kind = TTF_EXPORT_SHEET;
    if (kind < 0 || (!cli->opt.to && kind == TTF_EXPORT_TIFF)) {
        ttf_err_set(&cli->err, -EINVAL, cli->opt.to ? "--to" : cli->opt.output,
                    "'%s' is nothing that can be exported to", name);
        ttf_err_hint(&cli->err, "say --to mp4, gif, y4m, png, tiff, npy or sheet");
        return -EINVAL;
    }
    config->kind = (enum ttf_export_kind)kind;
    return 0;
}

static int choose(struct cli *cli, struct ttf_export_config *config)
{
    int r = choose_kind(cli, config);

    if (r < 0)
        return r;
    if (cli->opt.gaps) {
        int gaps = ttf_gaps_find(cli->opt.gaps);

        if (gaps < 0) {
            ttf_err_set(&cli->err, -EINVAL, "--gaps", "'%s' fills no gap", cli->opt.gaps);
            ttf_err_hint(&cli->err, "hold, fail or interpolate");
            return -EINVAL;
        }
        config->gaps = (enum ttf_gaps)gaps;
    }
    config->output = cli->opt.output;
    config->name = cli->opt.name;
    config->start = cli->opt.start;
    config->from_zero = cli->opt.given[OPT_START] && cli->opt.start == 0;
    config->every = (uint32_t)cli->opt.every;
    config->fps_num = (uint32_t)cli->opt.fps;
    config->fps_den = cli->opt.fps ? 1 : 0;
    config->width_max = (uint32_t)cli->opt.width_max;
    config->white = cli->opt.white;
    if (config->kind == TTF_EXPORT_SHEET) {
        config->sheet_frames = (unsigned)cli->opt.frames;
        config->sheet_columns = (unsigned)cli->opt.columns;
        config->sheet_cell = (uint32_t)cli->opt.width_max;
        config->width_max = 0;
    } else {
        config->frames_max = (uint32_t)(cli->opt.frames > UINT32_MAX ? 0 : cli->opt.frames);
    }
    return 0;
}

/* Neither the output nor what will lie beside it. */
static int refuse_existing(struct cli *cli, enum ttf_export_kind kind)
{
    const char *output = cli->opt.output;
    size_t n = strlen(output);
    char *beside = NULL;
    int r = cli_refuse_existing(cli, output);

    if (r < 0 || !ttf_export_has_sidecar_beside(kind))
        return r;
    while (n > 1 && output[n - 1] == '/')
        n--;
    if (asprintf(&beside, "%.*s.json", (int)n, output) < 0)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    r = cli_refuse_existing(cli, beside);
    free(beside);
    return r;
}

static void say(struct cli *cli, const struct ttf_export_config *config,
                const struct ttf_export_result *result, uint32_t excluded, bool simulated)
{
    cli_say(cli, "%s%-17s %s", simulated ? "SIMULATED\n" : "", ttf_export_kind_name(config->kind),
            config->output);
    cli_say(cli, "frames            %" PRId64 " of %u x %u, %" PRId64 " of them invented",
            result->frames, result->width, result->height, result->invented);
    if (excluded)
        cli_say(cli, "excluded          %u slot%s, as notes say (--with-excluded takes them too)",
                excluded, excluded == 1 ? "" : "s");
    ttf_json_kint(&cli->out, "excluded", excluded);
    ttf_json_kstring(&cli->out, "kind", ttf_export_kind_name(config->kind));
    ttf_json_kstring(&cli->out, "output", config->output);
    ttf_json_kbool(&cli->out, "simulated", simulated);
    ttf_json_kint(&cli->out, "frames", result->frames);
    ttf_json_kint(&cli->out, "invented", result->invented);
    ttf_json_kint(&cli->out, "width", result->width);
    ttf_json_kint(&cli->out, "height", result->height);
}

/* It is there: the sequence is made of it. */
static const struct ttf_stream *stream_of(const struct cli *cli, const struct ttf_reader *reader)
{
    const struct ttf_manifest *manifest = ttf_reader_manifest(reader);

    return cli->opt.stream ? ttf_manifest_stream(manifest, cli->opt.stream)
                           : ttf_manifest_primary(manifest);
}

int cmd_export(struct cli *cli)
{
    struct cli_progress bar;
    struct ttf_export_config config = {.progress = on_progress, .progress_ctx = &bar};
    struct ttf_export_result result;
    const struct ttf_sequence_choice choice = cli_choice(cli);
    struct ttf_reader *reader = NULL;
    struct ttf_sequence *sequence = NULL;
    int r = cli_need(cli, cli->opt.output, "-o", "say where it goes, as -o grass.mp4");

    if (r == 0)
        r = choose(cli, &config);
    if (r == 0)
        r = refuse_existing(cli, config.kind);
    if (r == 0)
        r = ttf_reader_open(cli->io, cli->opt.args[0], &reader, &cli->err);
    if (r == 0)
        r = ttf_sequence_of_dataset(reader, &choice, &sequence, &cli->err);
    if (r < 0 && strcmp(cli->err.where, "role") == 0)
        (void)cli_by_option(cli, r, "--role", cli->opt.args[0]);
    if (r == 0) {
        const struct ttf_stream *stream = stream_of(cli, reader);

        config.simulated = ttf_reader_manifest(reader)->simulated;
        config.camera_colours = strcmp(stream->colour_space, "linear-srgb") != 0 ||
                                (choice.role && strcmp(choice.role, "developed") != 0);
        cli_stop_catch();
        cli_progress_begin(&bar, cli, "exporting");
        r = ttf_export(sequence, cli->io, &config, &result, &cli->err);
        cli_progress_end(&bar);
    }
    if (r == 0) {
        say(cli, &config, &result, sequence->n_excluded, ttf_reader_manifest(reader)->simulated);
        cli_say_elsewhere(cli, reader);
    }
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    return r;
}
