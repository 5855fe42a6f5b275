/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_job.c: see quilt_job.h. What is said of a result: quilt_say.c. */
#include "quilt_job.h"

#include <errno.h>
#include <malloc.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "quilt_options.h"
#include "quilt_say.h"

static struct ttf_sequence *first(const struct quilt_job *job)
{
    return quilt_input_top(&job->inputs[0]);
}

static void on_progress(void *ctx, double done)
{
    struct quilt_job *job = ctx;

    cli_progress_at(&job->bar, (int64_t)(done * 1000), 1000, NULL);
}

static const char *uuid_of(const struct quilt_input *input)
{
    return input->reader ? ttf_reader_manifest(input->reader)->uuid : "";
}

/* ---- inputs ---- */

static int open_inputs(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    int r = quilt_input_open(cli, job->source, &job->inputs[0]);

    job->n_inputs = r == 0;
    for (unsigned i = 0; i < cli->opt.n_sources && r == 0; i++) {
        r = quilt_input_open(cli, cli->opt.sources[i], &job->inputs[1 + i]);
        r = cli_by_option(cli, r, "--source", cli->opt.sources[i]);
        job->n_inputs += r == 0;
        if (r == 0)
            r = quilt_input_mixes(cli, &job->inputs[0], &job->inputs[1 + i], cli->opt.sources[i]);
    }
    return r;
}

static struct ttf_report_prepared *prepared_of(struct quilt_job *job, unsigned input)
{
    return input ? &job->more_prepared[input - 1] : &job->prepared;
}

/* Smaller and rarer, if so asked. */
static int reduce(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    const struct quilt_preview *p = &job->preview;
    const struct quilt_preview_ask ask = {.inputs = job->inputs,
                                          .n_inputs = job->n_inputs,
                                          .config = &job->config,
                                          .timed = quilt_options_pace(cli),
                                          .keep_shrink = job->factors.was.shrink,
                                          .keep_step = job->factors.was.step,
                                          .fastest = job->fastest,
                                          .ctx = job};
    int r;

    if (!cli->opt.preview)
        return 0;
    r = quilt_preview_choose(cli, job->clock, &ask, &job->preview);
    for (unsigned i = 0; i < job->n_inputs && r == 0 && (p->shrink > 1 || p->step > 1); i++)
        r = quilt_input_reduce(cli, &job->inputs[i], p->shrink, p->step);
    if (r < 0)
        return r;
    quilt_config_reduce(&job->config, p->shrink, p->step);
    for (unsigned i = 0; i < job->n_inputs; i++) {
        struct ttf_report_prepared *prepared = prepared_of(job, i);

        prepared->reduced = p->shrink > 1 || p->step > 1;
        prepared->shrink = p->shrink;
        prepared->step = p->step;
    }
    job->prepared.estimated_ns = p->total_ns;
    job->prepared.allowed_ns = cli->opt.time_ns;
    if (p->total_ns > cli->opt.time_ns)
        cli_warn(
            "--time: no preview is estimated to take %.1f s at most; this, the fastest, %.1f s",
            (double)cli->opt.time_ns / 1e9, (double)p->total_ns / 1e9);
    return 0;
}

/* The block from what is seen, before the gradient is taken out: what is slow follows from the block. */
static int find_block(struct quilt_job *job)
{
    struct ttf_feature_size *feature = &job->prepared.feature;
    int r;

    if (!job->cli->opt.block_auto)
        return 0;
    r = ttf_feature_size_find(first(job), feature, &job->cli->err);
    if (r < 0)
        return r;
    job->prepared.auto_block = true;
    job->config.block_width = feature->block_width;
    job->config.block_height = feature->block_height;
    return 0;
}

/* What changes across a block is light; half of it leaves neighbours alike (prepare/README.md). */
static double sigma_px(const struct quilt_job *job)
{
    const struct ttf_quilt_config *c = &job->config;

    if (cli_given(&job->cli->opt, OPT_FLATTEN_SIGMA))
        return job->cli->opt.flatten_sigma / (job->prepared.reduced ? job->prepared.shrink : 1);
    return (c->block_width > c->block_height ? c->block_width : c->block_height) / 2.0;
}

static int prepare_inputs(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    int r = 0;

    for (unsigned i = job->n_inputs; i-- > 0 && r == 0;)
        r = quilt_input_steady(cli, &job->inputs[i], prepared_of(job, i));
    if (r == 0)
        r = find_block(job);
    /* a map's block is what it was found by, so the gradient is that of then */
    if (r == 0)
        quilt_map_describe(&job->kept, first(job), &job->config);
    for (unsigned i = job->n_inputs; i-- > 0 && r == 0 && cli->opt.flatten;)
        r = quilt_input_flatten(cli, &job->inputs[i], sigma_px(job), prepared_of(job, i));
    for (unsigned i = 1; i < job->n_inputs && r == 0; i++)
        job->more[i - 1] = quilt_input_top(&job->inputs[i]);
    job->config.more = job->more;
    job->config.n_more = job->n_inputs - 1;
    return r;
}

/* ---- configuration ---- */

/* Twice the input as it is by now: preparing may have cut something off. */
static void default_size(struct quilt_job *job)
{
    struct ttf_quilt_config *c = &job->config;

    if (c->width)
        return;
    c->width = 2 * first(job)->width;
    c->height = 2 * first(job)->height;
}

static int make_gradient(struct quilt_job *job)
{
    int r;

    if (!job->cli->opt.keep_gradient)
        return 0;
    r = ttf_gradient_resample(&job->inputs[0].gradient, job->config.width, job->config.height,
                              &job->gradient, &job->cli->err);
    job->prepared.gradient_reapplied = r == 0;
    return r;
}

static int configure(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    struct ttf_quilt_config *c = &job->config;
    int r;

    default_size(job);
    c->now_ns = cli_now_ns;
    c->now_ctx = job->clock;
    c->progress = on_progress;
    c->progress_ctx = job;
    c->cancel = cli_stop_flag();
    r = quilt_options_name(cli, ttf_quilt_validate(c, first(job), &cli->err));
    if (r == 0 && job->control)
        r = job->control(job);
    if (r == 0 && job->rate.m)
        c->rate = &job->rate;
    if (r == 0)
        r = quilt_options_name(cli, ttf_quilt_validate(c, first(job), &cli->err));
    if (r == 0)
        r = quilt_options_name(cli, quilt_factors_suit(&job->factors, &job->prepared,
                                                       uuid_of(&job->inputs[0]), first(job), c));
    return r < 0 ? r : make_gradient(job);
}

/* ---- the run ---- */

static void edit(void *ctx, const struct ttf_encoding *encoding, uint16_t *codes)
{
    const struct quilt_job *job = ctx;

    /* within a frame's own task of the pool: it may not ask the pool again */
    if (job->gradient.g)
        ttf_gradient_apply(&job->gradient, encoding, NULL, codes);
    if (job->edit)
        job->edit(job->edit_ctx, encoding, codes);
}

static int open_sink(struct quilt_job *job)
{
    const struct quilt_sink_spec spec = {.kind = job->kind,
                                         .parent = job->inputs[0].reader,
                                         .source = job->source,
                                         .input = first(job),
                                         .config = &job->config,
                                         .shrink = job->prepared.reduced ? job->prepared.shrink : 1,
                                         .edit = job->gradient.g || job->edit ? edit : NULL,
                                         .edit_ctx = job};

    return quilt_sink_create(job->cli, &spec, &job->sink);
}

/* Reads the result back: every pixel's life must be that of the source pixel the map names. */
static int check(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    const struct ttf_sequence_choice all = {.threads = (unsigned)cli->opt.threads};
    struct ttf_reader *reader = NULL;
    struct ttf_sequence *output = NULL;
    int r = ttf_reader_open(cli->io, cli->opt.output, &reader, &cli->err);

    if (r == 0)
        r = ttf_sequence_of_dataset(reader, &all, &output, &cli->err);
    if (r == 0)
        r = ttf_quilt_verify(&job->config, first(job), output,
                             job->config.per_frame ? NULL : &job->map, &job->check, &cli->err);
    job->checked = r == 0;
    if (r == -ECANCELED)
        ttf_err_set(&cli->err, r, cli->opt.output, "is whole, but its check was cancelled");
    ttf_sequence_destroy(output);
    ttf_reader_close(reader);
    return r;
}

static size_t peak_bytes(void)
{
    struct rusage usage;

    return getrusage(RUSAGE_SELF, &usage) == 0 ? (size_t)usage.ru_maxrss * 1024 : 0;
}

static void complete_report(struct quilt_job *job)
{
    struct ttf_quilt_report *report = &job->report;

    report->prepared = job->prepared;
    for (unsigned i = 0; i + 1 < job->n_inputs; i++)
        report->more_prepared[i] = job->more_prepared[i];
    report->peak_bytes = peak_bytes();
    for (unsigned i = 0; i < job->n_inputs; i++)
        quilt_input_name(&job->inputs[i], &report->sources[i]);
    for (unsigned i = 0; i < job->n_inputs; i++)
        report->simulated |=
            job->inputs[i].reader && ttf_reader_manifest(job->inputs[i].reader)->simulated;
}

/* What failed in the midst of a run: the disk's own words for factors, options' names for fields. */
static int explain(struct quilt_job *job, int code)
{
    struct cli *cli = job->cli;

    if (code < 0 && job->factors.err.code)
        cli->err = job->factors.err;
    return quilt_options_name(cli, code);
}

static int run(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    struct ttf_quilt_sink sink = quilt_sink_of(job->sink);
    bool saved = false;
    int r;

    cli_progress_begin(&job->bar, cli, "quilting");
    r = explain(job, ttf_quilt_run(&job->config, first(job), job->pool, &sink, &job->report,
                                   &job->map, &cli->err));
    if (r == 0) {
        complete_report(job);
        saved =
            cli->opt.save_map; /* there was none, so whatever lies there after a failure is ours */
        r = quilt_map_save(cli, &job->map);
    }
    if (r == 0)
        r = quilt_sink_finish(job->sink, &job->report, &cli->err);
    if (r < 0 && saved)
        (void)cli->io->ops->unlink(cli->io, cli->opt.save_map);
    if (r == 0)
        r = quilt_factors_save(&job->factors);
    if (r == 0 && cli->opt.check)
        r = check(job);
    cli_progress_end(&job->bar);
    return r;
}

int quilt_job_run(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    int r = quilt_options_check(cli, &job->kind);

    /* What one frame's map or one stage took goes back to the system, instead of into the heap. */
    if (cli->opt.preview)
        (void)mallopt(M_MMAP_THRESHOLD, 128 * 1024); /* NOLINT(concurrency-mt-unsafe): one thread */
    if (r == 0)
        r = quilt_options_config(cli, job->kind, &job->config);
    if (r == 0 && job->config.width == 0) {
        job->config.width = job->default_width;
        job->config.height = job->default_height;
    }
    job->clock = ttf_clock_real_create();
    if (r == 0)
        r = open_inputs(job);
    if (r == 0) /* what is kept takes memory, and previews go by it */
        r = quilt_factors_open(cli, &job->factors, &job->config);
    if (r == 0)
        r = reduce(job);
    if (r == 0)
        r = quilt_map_load(cli, &job->kept);
    if (r == 0)
        r = prepare_inputs(job);
    if (r == 0)
        r = configure(job);
    if (r < 0)
        return r;
    /* from here on there is something to take away: a signal only asks for it */
    cli_stop_catch();
    job->pool = ttf_pool_create((unsigned)cli->opt.threads);
    r = job->pool ? open_sink(job) : -ENOMEM;
    if (r == 0)
        r = run(job);
    if (r == 0)
        quilt_say(job);
    /* A check that fails is a failure of ours, not damage of the user's. */
    if (r == 0 && job->checked && job->check.unmatched && !job->config.feather_px)
        r = CLI_FAILED;
    return r;
}

void quilt_job_free(struct quilt_job *job)
{
    quilt_sink_destroy(job->sink);
    quilt_factors_close(&job->factors);
    ttf_quilt_map_free(&job->map);
    ttf_quilt_map_free(&job->kept);
    ttf_rate_map_free(&job->rate);
    ttf_gradient_free(&job->gradient);
    ttf_pool_destroy(job->pool);
    for (unsigned i = 0; i < job->n_inputs; i++)
        quilt_input_close(&job->inputs[i]);
    ttf_clock_destroy(job->clock);
}
