/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_say.c: see quilt_say.h. */
#include "quilt_say.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

/* What was done to an input before, the further ones by their number. */
static void say_steadied(const struct cli *cli, const struct ttf_report_prepared *p, unsigned input)
{
    char which[24] = "", unlike[64] = "";

    if (input > 0)
        (void)snprintf(which, sizeof which, "input %u: ", input + 1);
    if (p->stabilise.unlike)
        (void)snprintf(unlike, sizeof unlike,
                       ", %u unlike all others and left with their neighbour", p->stabilise.unlike);
    if (p->stabilised)
        cli_say(cli,
                "stabilised        %s%u frames moved, by %.2f px at most%s; %u x %u px cut off",
                which, p->stabilise.moved, p->stabilise.largest_shift_px, unlike,
                p->stabilise.crop_x, p->stabilise.crop_y);
    if (p->deflickered)
        cli_say(cli, "deflickered       %sgains of %.4f to %.4f", which, p->deflicker.smallest_gain,
                p->deflicker.largest_gain);
    if (p->flattened)
        cli_say(cli, "flattened         %sa gradient of %.3f to %.3f%s", which,
                (double)p->gradient_least, (double)p->gradient_most,
                p->gradient_reapplied ? ", laid over the output" : "");
}

static void say_prepared(const struct quilt_job *job)
{
    const struct ttf_report_prepared *p = &job->prepared;
    const struct cli *cli = job->cli;

    if (cli->opt.preview)
        cli_say(cli,
                "preview           shrunk by %u, one frame of %u: estimated %zu MiB of %zu, %.1f s "
                "of %.1f",
                job->preview.shrink, job->preview.step, job->preview.bytes >> 20,
                job->config.memory_bytes >> 20, (double)job->preview.total_ns / 1e9,
                (double)cli->opt.time_ns / 1e9);
    for (unsigned i = 0; i < job->n_inputs; i++)
        say_steadied(cli, i ? &job->more_prepared[i - 1] : p, i);
    if (p->auto_block)
        cli_say(cli, "block             %u x %u: what is seen is %.1f x %.1f px large",
                job->config.block_width, job->config.block_height, p->feature.correlation_x_px,
                p->feature.correlation_y_px);
}

#define OFTEN 10 /* times as often as evenly spread uses: nobody overlooks that */

/* Coherence is as good where one spot is laid everywhere: what the eye sees first is said, too. */
static void say_repetition(const struct quilt_job *job)
{
    const struct ttf_quilt_report *p = &job->report;
    const struct ttf_repetition_figures *r = &p->repetition;
    const struct cli *cli = job->cli;
    double even = (double)job->config.width * job->config.height / p->source_pixels;
    char avoid[32];

    cli_say(cli,
            "repetition        %.0f %% of the input is used, one pixel of it %u time%s at most",
            100 * r->source_coverage, r->max_uses, r->max_uses == 1 ? "" : "s");
    if (r->max_uses <= OFTEN * (even < 1 ? 1 : even) ||
        (job->config.avoid_px && job->prepared.flattened))
        return;
    (void)snprintf(avoid, sizeof avoid, "--avoid %u", job->config.block_width);
    cli_say(cli, "                  the same place again and again; try%s%s%s",
            job->prepared.flattened ? "" : " --flatten (light that is uneven)",
            !job->prepared.flattened && !job->config.avoid_px ? " and " : " ",
            job->config.avoid_px ? "" : avoid);
}

/* Of an input that does not change there is no share: what the output does is said as it is. */
static void say_coherence(const struct cli *cli, const struct ttf_quilt_report *p)
{
    if (!isnan(p->coherence))
        cli_say(cli, "coherence         %.4f of the input's mean frame difference", p->coherence);
    else if (p->frames < 2)
        cli_say(cli, "coherence         nothing to compare: the input is one frame");
    else
        cli_say(
            cli,
            "coherence         nothing to compare: the input does not change, the output by %.2f "
            "codes a frame",
            p->output.mean_difference);
    if (!isnan(p->flicker))
        cli_say(cli, "flicker           %.4f of the input's second difference", p->flicker);
}

static void say_figures(const struct quilt_job *job)
{
    const struct ttf_quilt_report *p = &job->report;
    const struct cli *cli = job->cli;

    char block[40] = "", how[40] = ", replayed";

    if (p->block_known)
        (void)snprintf(block, sizeof block, " of %u x %u", job->config.block_width,
                       job->config.block_height);
    if (!job->config.replay)
        (void)snprintf(how, sizeof how, ", seed %" PRIu64, job->config.seed);
    cli_say(cli, "frames            %u of %u x %u from %u x %u, %u block%s%s%s", p->out_frames,
            job->config.width, job->config.height, p->source_width, p->source_height, p->blocks,
            p->blocks == 1 ? "" : "s", block, how);
    if (!job->config.replay && p->rank.rank != TTF_QUILT_RANK_FULL)
        cli_say(cli, "matched           rank %u, which misses %.2f %%%s", p->rank.rank,
                100 * p->rank.error, p->rank.known_frames ? "; gone on with known factors" : "");
    if (p->measured) {
        say_coherence(cli, p);
        say_repetition(job);
    }
    cli_say(cli, "time              %.2f s with %u threads", (double)p->total_ns / 1e9, p->threads);
    if (job->checked)
        cli_say(cli, "check             %" PRIu64 " of %" PRIu64 " trajectories are no source's%s",
                job->check.unmatched, job->check.pixels,
                job->check.unmatched ? "" : ": all copied, bit for bit");
}

static void put_json(struct quilt_job *job)
{
    struct cli *cli = job->cli;
    struct ttf_json *j = &cli->out;

    if (cli->opt.output)
        ttf_json_kstring(j, "output", cli->opt.output);
    ttf_json_kstring(j, "sink", quilt_sink_name(job->sink));
    ttf_json_kbool(j, "simulated", job->report.simulated);
    if (*quilt_sink_digest(job->sink))
        ttf_json_kstring(j, "digest", quilt_sink_digest(job->sink));
    if (cli->opt.preview) {
        ttf_json_key(j, "preview");
        ttf_json_object(j);
        ttf_json_kint(j, "shrunk_by", job->preview.shrink);
        ttf_json_kint(j, "frame_step", job->preview.step);
        ttf_json_kint(j, "estimated_bytes", (int64_t)job->preview.bytes);
        ttf_json_kint(j, "estimated_ns", job->preview.total_ns);
        ttf_json_kint(j, "frame_read_ns", job->preview.read_ns);
        ttf_json_object_end(j);
    }
    if (job->checked) {
        ttf_json_kint(j, "checked_pixels", (int64_t)job->check.pixels);
        ttf_json_kint(j, "unmatched_pixels", (int64_t)job->check.unmatched);
    }
    ttf_json_key(j, "report");
    ttf_quilt_report_json(&job->report, j);
}

static void warn_of_rank(const struct ttf_quilt_report *report)
{
    double wanted = ttf_quilt_report_wanted_error(report);

    if (wanted > 0 && report->rank.error > wanted)
        cli_warn("--rank-error: rank %u, the most there is, misses %.2f %%, not %.4g %%",
                 report->rank.rank, 100 * report->rank.error, 100 * wanted);
}

void quilt_say(struct quilt_job *job)
{
    const struct cli *cli = job->cli;

    warn_of_rank(&job->report);

    cli_say(cli, "%s%-17s %s", job->report.simulated ? "SIMULATED\n" : "",
            quilt_sink_name(job->sink), cli->opt.output ? cli->opt.output : "(nothing kept)");
    say_prepared(job);
    say_figures(job);
    put_json(job);
}
