/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_composite.c: `ttfbox synth composite`: figure 10 of Enrique et al. 2005 in one command. */
#include "commands.h"
#include "quilt_job.h"
#include "ttf/dataset/image_file.h"
#include "ttf/synth/shadow.h"

struct composite {
    struct quilt_job job; /* first: downcast by address */
    struct ttf_pixbuf photo;
    struct ttf_shadow shadow;
};

/* At the size that was decided on: object and shadow, and the pace that the shadow sets. */
static int control(struct quilt_job *job)
{
    struct composite *c = (struct composite *)job;
    const struct cli_options *o = &job->cli->opt;
    struct ttf_shadow_config config;
    int r;

    ttf_shadow_defaults(&config);
    config.least = o->least;
    config.threshold = o->threshold;
    config.soften_px = o->soften / (job->prepared.reduced ? job->prepared.shrink : 1);
    r = ttf_shadow_find(&config, &c->photo, job->config.width, job->config.height, &c->shadow,
                        &job->cli->err);
    if (r < 0)
        return cli_by_option(job->cli, r, o->args[0], NULL);
    ttf_pixbuf_free(&c->photo);
    return ttf_shadow_rate_map(&c->shadow, o->least, &job->rate, &job->cli->err);
}

static void lay_over(void *ctx, const struct ttf_encoding *encoding, uint16_t *codes)
{
    const struct composite *c = ctx;

    ttf_shadow_compose(&c->shadow, encoding, NULL, codes);
}

int cmd_synth_composite(struct cli *cli)
{
    struct composite c = {
        .job = {.cli = cli, .source = cli->opt.args[1], .control = control, .edit = lay_over}};
    int r = ttf_image_read_linear(cli->io, cli->opt.args[0], &c.photo, NULL, &cli->err);

    c.job.edit_ctx = &c;
    c.job.default_width = c.photo.width;
    c.job.default_height = c.photo.height;
    if (r == 0)
        r = quilt_job_run(&c.job);
    if (r == 0) {
        cli_say(cli, "object            %.1f %% of the picture, from a distance of %.3f",
                100 * c.shadow.object_share, c.shadow.threshold);
        ttf_json_kdouble(&cli->out, "object_share", c.shadow.object_share);
        ttf_json_kdouble(&cli->out, "threshold", c.shadow.threshold);
    }
    quilt_job_free(&c.job);
    ttf_shadow_free(&c.shadow);
    ttf_pixbuf_free(&c.photo);
    return r;
}
