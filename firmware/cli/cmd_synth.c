/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_synth.c: `ttfbox synth quilt`. */
#include "commands.h"
#include "quilt_control.h"
#include "quilt_job.h"

static int control(struct quilt_job *job)
{
    return quilt_control_make(job->cli, job->config.width, job->config.height, &job->rate);
}

static int fastest(void *ctx, uint32_t width, uint32_t height, float *ret)
{
    const struct quilt_job *job = ctx;
    struct ttf_rate_map rate = {0};
    float least;
    int r = quilt_control_make(job->cli, width, height, &rate);

    *ret = 1;
    if (r == 0 && rate.m)
        ttf_rate_map_range(&rate, &least, ret);
    ttf_rate_map_free(&rate);
    return r;
}

int cmd_synth_quilt(struct cli *cli)
{
    struct quilt_job job = {
        .cli = cli, .source = cli->opt.args[0], .control = control, .fastest = fastest};
    int r = quilt_job_run(&job);

    quilt_job_free(&job);
    return r;
}
