/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_view.c: `ttfbox view`. */
#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "commands.h"
#include "elsewhere.h"
#include "ttf/dataset/reader.h"
#include "ttf/view/view.h"

struct shown {
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;
};

static int on_progress(void *ctx, int64_t done, int64_t total)
{
    cli_progress_at(ctx, done, total, NULL);
    return *cli_stop_flag();
}

static int open_one(struct cli *cli, const char *path, const char *role, struct shown *shown,
                    struct ttf_view_texture *ret)
{
    struct ttf_sequence_choice choice = cli_choice(cli);
    const struct ttf_manifest *manifest;
    const struct ttf_stream *stream;
    int r;

    /* What lies beside it has streams and brackets of its own. */
    if (strcmp(path, cli->opt.args[0]) != 0)
        choice = (struct ttf_sequence_choice){.with_excluded = choice.with_excluded,
                                              .threads = choice.threads};
    r = ttf_reader_open(cli->io, path, &shown->reader, &cli->err);
    if (r == 0)
        r = ttf_sequence_of_dataset(shown->reader, &choice, &shown->sequence, &cli->err);
    if (r < 0)
        return r;
    manifest = ttf_reader_manifest(shown->reader);
    stream = choice.stream ? ttf_manifest_stream(manifest, choice.stream)
                           : ttf_manifest_primary(manifest);
    *ret = (struct ttf_view_texture){
        .sequence = shown->sequence,
        .role = role,
        .title = manifest->title[0] ? manifest->title : path,
        .quantity = stream ? stream->quantity : NULL,
        .camera_colours = stream && strcmp(stream->colour_space, "linear-srgb") != 0,
        .simulated = manifest->simulated,
    };
    return 0;
}

static int configure(struct cli *cli, struct ttf_view_config *config)
{
    const struct cli_options *o = &cli->opt;

    config->output = o->output;
    config->white = o->white;
    config->threads = (unsigned)o->threads;
    if (o->frames > TTF_VIEW_FRAMES_MAX) {
        if (cli_given(o, OPT_FRAMES))
            return ttf_err_set(&cli->err, -EINVAL, "--frames", "at most %d frames",
                               TTF_VIEW_FRAMES_MAX);
    } else {
        config->frames_max = (uint32_t)o->frames;
    }
    if (o->width_max > TTF_VIEW_SIDE_MAX)
        return ttf_err_set(&cli->err, -EINVAL, "--width", "at most %d pixels", TTF_VIEW_SIDE_MAX);
    config->side_max = (uint32_t)o->width_max;
    return 0;
}

static void say(struct cli *cli, const struct ttf_view_texture *textures, unsigned n,
                const struct ttf_view_result *result)
{
    bool simulated = textures[0].simulated || (n > 1 && textures[1].simulated);

    cli_say(cli, "%s%s: %.1f MB", simulated ? "SIMULATED\n" : "", cli->opt.output,
            (double)result->bytes / 1e6);
    ttf_json_kstring(&cli->out, "output", cli->opt.output);
    ttf_json_kint(&cli->out, "bytes", result->bytes);
    ttf_json_kbool(&cli->out, "simulated", simulated);
    ttf_json_key(&cli->out, "panels");
    ttf_json_array(&cli->out);
    for (unsigned i = 0; i < n; i++) {
        const struct ttf_sequence *s = textures[i].sequence;

        cli_say(cli, "%-10s %u of %u frames, %u x %u of %u x %u pixels, %s", textures[i].role,
                result->panel[i].frames, s->n, result->panel[i].width, result->panel[i].height,
                s->width, s->height, result->panel[i].exact ? "exact in 8 bits" : "JPEG");
        ttf_json_object(&cli->out);
        ttf_json_kstring(&cli->out, "role", textures[i].role);
        ttf_json_kint(&cli->out, "frames", result->panel[i].frames);
        ttf_json_kint(&cli->out, "of_frames", s->n);
        ttf_json_kint(&cli->out, "width", result->panel[i].width);
        ttf_json_kint(&cli->out, "height", result->panel[i].height);
        ttf_json_kbool(&cli->out, "exact", result->panel[i].exact);
        ttf_json_object_end(&cli->out);
    }
    ttf_json_array_end(&cli->out);
}

int cmd_view(struct cli *cli)
{
    struct cli_progress bar;
    struct ttf_view_config config = {.progress = on_progress, .progress_ctx = &bar};
    struct ttf_view_texture textures[2];
    struct ttf_view_result result;
    struct shown shown[2] = {{NULL, NULL}, {NULL, NULL}};
    unsigned n = cli->opt.beside ? 2 : 1;
    int r = cli_need(cli, cli->opt.output, "-o", "say where it goes, as -o grass.html");

    if (r == 0)
        r = cli_refuse_existing(cli, cli->opt.output);
    if (r == 0)
        r = configure(cli, &config);
    if (r == 0)
        r = open_one(cli, cli->opt.args[0], n > 1 ? "source" : "texture", &shown[0], &textures[0]);
    if (r == 0 && n > 1)
        r = cli_by_option(cli, open_one(cli, cli->opt.beside, "synthesis", &shown[1], &textures[1]),
                          "--beside", cli->opt.beside);
    if (r == 0) {
        cli_stop_catch();
        cli_progress_begin(&bar, cli, "viewing");
        r = ttf_view_write(textures, n, cli->io, &config, &result, &cli->err);
        cli_progress_end(&bar);
    }
    if (r == 0) {
        say(cli, textures, n, &result);
        cli_say_elsewhere(cli, shown[0].reader);
    }
    for (unsigned i = 0; i < 2; i++) {
        ttf_sequence_destroy(shown[i].sequence);
        ttf_reader_close(shown[i].reader);
    }
    return r;
}
