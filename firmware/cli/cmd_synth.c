/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_synth.c: `ttfbox synth quilt`. */
#include "commands.h"
#include "quilt_control.h"
#include "quilt_job.h"

static int control(struct quilt_job *job)
{
    return quilt_control_make(job->cli, job->config.width, job->config.height, &job->rate);
}

int cmd_synth_quilt(struct cli *cli)
{
    struct quilt_job job = {.cli = cli, .source = cli->opt.args[0], .control = control};
    int r = quilt_job_run(&job);

    quilt_job_free(&job);
    return r;
}
