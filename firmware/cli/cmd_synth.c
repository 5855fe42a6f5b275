/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_synth.c: `ttfbox synth quilt`: input, sink, report, check. */
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "quilt_sink.h"
#include "ttf/dataset/sequence.h"
#include "ttf/hal/clock.h"
#include "ttf/synth/run.h"

struct synth {
    struct cli *cli;
    struct ttf_reader *reader; /* NULL: the input is a picture */
    struct ttf_sequence *whole, *input;
    struct ttf_pool *pool;
    struct ttf_clock *clock;
    struct ttf_quilt_config config;
    struct quilt_sink *sink;
    struct ttf_quilt_report report;
    struct ttf_quilt_map map;
    struct ttf_quilt_check check;
    struct cli_progress bar;
    bool checked;
};

static void on_progress(void *ctx, double done)
{
    struct synth *s = ctx;

    cli_progress_at(&s->bar, (int64_t)(done * 1000), 1000, NULL);
}

/* A dataset, or a picture as a sequence of one frame. */
static int open_input(struct synth *s)
{
    struct cli *cli = s->cli;
    const char *path = cli->opt.args[0];
    struct ttf_io_stat st;
    int r = cli->io->ops->stat(cli->io, path, &st);

    if (r < 0)
        return ttf_err_set(&cli->err, r, path, "%s", strerrordesc_np(-r));
    if (!st.is_dir)
        return ttf_sequence_of_image(cli->io, path, &s->whole, &cli->err);
    r = ttf_reader_open(cli->io, path, &s->reader, &cli->err);
    if (r == 0)
        r = ttf_sequence_of_dataset(s->reader, cli->opt.stream, &s->whole, &cli->err);
    return r;
}

static int configure(struct synth *s)
{
    const struct cli_options *o = &s->cli->opt;
    struct ttf_quilt_config *c = &s->config;

    ttf_quilt_defaults(c);
    c->width = o->size[0] ? o->size[0] : 2 * s->input->width;
    c->height = o->size[0] ? o->size[1] : 2 * s->input->height;
    if (o->block[0]) {
        c->block_width = o->block[0];
        c->block_height = o->block[1];
    }
    c->overlap_x = o->overlap[0];
    c->overlap_y = o->overlap[1];
    c->tolerance = o->tolerance;
    c->seed = (uint64_t)o->seed;
    c->per_frame = o->per_frame;
    c->feather_px = (uint32_t)o->feather;
    c->now_ns = cli_now_ns;
    c->now_ctx = s->clock;
    c->progress = on_progress;
    c->progress_ctx = s;
    c->cancel = cli_stop_flag();
    if (o->metric && strcmp(o->metric, "linear") == 0)
        c->metric = TTF_METRIC_LINEAR;
    else if (o->metric && strcmp(o->metric, "display") != 0) {
        ttf_err_set(&s->cli->err, -EINVAL, "--metric", "'%s' is no space", o->metric);
        return ttf_err_hint(&s->cli->err, "display or linear"), -EINVAL;
    }
    return ttf_quilt_validate(c, s->input, &s->cli->err);
}

/* Reads the result back: every pixel's life must be that of the source pixel the map names. */
static int check(struct synth *s)
{
    struct cli *cli = s->cli;
    struct ttf_reader *reader = NULL;
    struct ttf_sequence *output = NULL;
    int r = ttf_reader_open(cli->io, cli->opt.output, &reader, &cli->err);

    if (r == 0)
        r = ttf_sequence_of_dataset(reader, NULL, &output, &cli->err);
    if (r == 0)
        r = ttf_quilt_verify(&s->config, s->input, output, s->config.per_frame ? NULL : &s->map,
                             &s->check, &cli->err);
    s->checked = r == 0;
    ttf_sequence_destroy(output);
    ttf_reader_close(reader);
    return r;
}

static int run(struct synth *s)
{
    struct cli *cli = s->cli;
    struct ttf_quilt_sink sink = quilt_sink_of(s->sink);
    int r;

    cli_stop_catch();
    cli_progress_begin(&s->bar, cli, "quilting");
    r = ttf_quilt_run(&s->config, s->input, s->pool, &sink, &s->report, &s->map, &cli->err);
    s->report.simulated = s->reader && ttf_reader_manifest(s->reader)->simulated;
    if (r == 0)
        r = quilt_sink_finish(s->sink, &s->report, &cli->err);
    if (r == 0 && cli->opt.check)
        r = check(s);
    cli_progress_end(&s->bar);
    return r;
}

static void say(struct synth *s)
{
    const struct ttf_quilt_report *p = &s->report;
    struct cli *cli = s->cli;
    struct ttf_json *j = &cli->out;
    bool simulated = p->simulated;

    cli_say(cli, "%s%-17s %s", simulated ? "SIMULATED\n" : "", quilt_sink_name(s->sink),
            cli->opt.output ? cli->opt.output : "(nothing kept)");
    cli_say(cli,
            "frames            %u of %u x %u from %u x %u, %u blocks of %u x %u, seed %" PRIu64,
            p->frames, s->config.width, s->config.height, p->source_width, p->source_height,
            p->blocks, s->config.block_width, s->config.block_height, s->config.seed);
    cli_say(cli, "coherence         %.4f of the input's mean frame difference", p->coherence);
    cli_say(cli, "flicker           %.4f of the input's second difference", p->flicker);
    cli_say(cli, "time              %.2f s with %u threads", (double)p->total_ns / 1e9, p->threads);
    if (s->checked)
        cli_say(cli, "check             %" PRIu64 " of %" PRIu64 " trajectories are no source's%s",
                s->check.unmatched, s->check.pixels,
                s->check.unmatched ? "" : ": all copied, bit for bit");
    if (cli->opt.output)
        ttf_json_kstring(j, "output", cli->opt.output);
    ttf_json_kstring(j, "sink", quilt_sink_name(s->sink));
    ttf_json_kbool(j, "simulated", simulated);
    if (*quilt_sink_digest(s->sink))
        ttf_json_kstring(j, "digest", quilt_sink_digest(s->sink));
    if (s->checked) {
        ttf_json_kint(j, "checked_pixels", (int64_t)s->check.pixels);
        ttf_json_kint(j, "unmatched_pixels", (int64_t)s->check.unmatched);
    }
    ttf_json_key(j, "report");
    ttf_quilt_report_json(p, j);
}

static int check_options(struct cli *cli, enum quilt_sink_kind *ret_kind)
{
    const char *compress = cli->opt.compress;
    int kind = quilt_sink_find(cli->opt.sink ? cli->opt.sink : "dataset");
    int r;

    if (kind < 0) {
        ttf_err_set(&cli->err, -EINVAL, "--sink", "'%s' is no sink", cli->opt.sink);
        return ttf_err_hint(&cli->err, "dataset, raw or null"), -EINVAL;
    }
    *ret_kind = (enum quilt_sink_kind)kind;
    if (compress && strcmp(compress, "none") != 0 && strcmp(compress, "deflate") != 0) {
        ttf_err_set(&cli->err, -EINVAL, "--compress", "'%s' is no compression", compress);
        return ttf_err_hint(&cli->err, "none or deflate"), -EINVAL;
    }
    if (cli->opt.check && kind != QUILT_SINK_DATASET)
        return ttf_err_set(&cli->err, -EINVAL, "--check", "needs a dataset to read back");
    if (kind == QUILT_SINK_NULL)
        return 0;
    r = cli_need(cli, cli->opt.output, "-o", "say where the result goes, as -o big");
    return r < 0 ? r : cli_refuse_existing(cli, cli->opt.output);
}

int cmd_synth_quilt(struct cli *cli)
{
    struct synth s = {.cli = cli, .clock = ttf_clock_real_create()};
    enum quilt_sink_kind kind = QUILT_SINK_DATASET;
    int r = check_options(cli, &kind);

    if (r == 0)
        r = open_input(&s);
    if (r == 0)
        r = quilt_first_frames(
            s.whole, (uint32_t)(cli->opt.frames > UINT32_MAX ? UINT32_MAX : cli->opt.frames),
            &s.input, &cli->err);
    if (r == 0)
        r = configure(&s);
    if (r == 0) {
        s.pool = ttf_pool_create((unsigned)cli->opt.threads);
        r = s.pool ? quilt_sink_create(cli, kind, s.reader, s.input, &s.config, &s.sink) : -ENOMEM;
    }
    if (r == 0)
        r = run(&s);
    if (r == 0)
        say(&s);
    /* A check that fails is a failure of ours, not damage of the user's. */
    if (r == 0 && s.checked && s.check.unmatched && !s.config.feather_px)
        r = CLI_FAILED;
    quilt_sink_destroy(s.sink);
    ttf_quilt_map_free(&s.map);
    ttf_pool_destroy(s.pool);
    if (s.input != s.whole)
        ttf_sequence_destroy(s.input);
    ttf_sequence_destroy(s.whole);
    ttf_reader_close(s.reader);
    ttf_clock_destroy(s.clock);
    return r;
}
