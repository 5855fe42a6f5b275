/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_verify.c: `ttfbox verify`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>

#include "commands.h"
#include "elsewhere.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

struct watch {
    struct cli_progress bar;
    int64_t files; /* in all, 0 while not known */
};

static void on_progress(void *ctx, int64_t files_done, int64_t bytes_done)
{
    struct watch *w = ctx;
    char text[48];

    (void)snprintf(text, sizeof text, "files, %" PRId64 " MB", bytes_done / 1000000);
    cli_progress_at(&w->bar, files_done, w->files, text);
}

static void say_finding(struct cli *cli, const struct ttf_verify_finding *f)
{
    struct ttf_json *j = &cli->out;

    if (f->last_slot > f->slot)
        cli_say(cli, "%-9s %s, slots %" PRId64 " to %" PRId64 ": %s",
                ttf_severity_name(f->severity), f->file, f->slot, f->last_slot, f->text);
    else if (f->slot >= 0)
        cli_say(cli, "%-9s %s, slot %" PRId64 ": %s", ttf_severity_name(f->severity), f->file,
                f->slot, f->text);
    else
        cli_say(cli, "%-9s %s: %s", ttf_severity_name(f->severity), f->file, f->text);
    ttf_json_object(j);
    ttf_json_kstring(j, "severity", ttf_severity_name(f->severity));
    ttf_json_kstring(j, "file", f->file);
    if (f->slot >= 0)
        ttf_json_kint(j, "slot", f->slot);
    if (f->last_slot > f->slot)
        ttf_json_kint(j, "last_slot", f->last_slot);
    ttf_json_kstring(j, "text", f->text);
    ttf_json_object_end(j);
}

static void say(struct cli *cli, const struct ttf_verify_report *report)
{
    struct ttf_json *j = &cli->out;

    ttf_json_kstring(j, "dataset", cli->opt.args[0]);
    ttf_json_kbool(j, "damaged", report->damaged);
    ttf_json_kbool(j, "sealed", report->sealed);
    ttf_json_kint(j, "slots", report->slots);
    ttf_json_kint(j, "files", report->files);
    ttf_json_kint(j, "bytes", report->bytes);
    for (int i = 0; i < TTF_FINDING_COUNT; i++)
        ttf_json_kint(j, ttf_severity_name((enum ttf_severity)i), report->n_of[i]);
    if (*report->digest)
        ttf_json_kstring(j, "digest", report->digest);
    ttf_json_key(j, "findings");
    ttf_json_array(j);
    for (unsigned i = 0; i < report->n_findings; i++)
        say_finding(cli, &report->findings[i]);
    ttf_json_array_end(j);
    cli_say(cli, "%s: %" PRId64 " slots, %" PRId64 " files, %.1f MB, %s",
            report->damaged ? "DAMAGED" : "whole", report->slots, report->files,
            (double)report->bytes / 1e6, report->sealed ? "sealed" : "not sealed");
    if (*report->digest)
        cli_say(cli, "digest %s", report->digest);
}

/* SIMULATED is said of every dataset that is; one that cannot be read says so above. */
static void say_whose(struct cli *cli, bool before)
{
    struct ttf_reader *reader = NULL;

    if (ttf_reader_open(cli->io, cli->opt.args[0], &reader, NULL) < 0)
        return;
    if (!before) {
        cli_say_elsewhere(cli, reader);
    } else {
        ttf_json_kbool(&cli->out, "simulated", ttf_reader_manifest(reader)->simulated);
        if (ttf_reader_manifest(reader)->simulated)
            cli_say(cli, "SIMULATED");
    }
    ttf_reader_close(reader);
}

int cmd_verify(struct cli *cli)
{
    struct watch watch = {.files = 0};
    struct ttf_verify_report report;
    struct ttf_verify_options options = {
        .deep = true, .progress = on_progress, .progress_ctx = &watch};
    struct ttf_pool *pool = ttf_pool_create((unsigned)cli->opt.threads);
    int r;

    if (!pool)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    options.pool = pool;
    cli_progress_begin(&watch.bar, cli, "verifying");
    r = ttf_verify(cli->io, cli->opt.args[0], &options, &report, &cli->err);
    cli_progress_end(&watch.bar);
    ttf_pool_destroy(pool);
    if (r < 0)
        return r;
    say_whose(cli, true);
    say(cli, &report);
    say_whose(cli, false);
    r = report.damaged ? CLI_DAMAGED : CLI_DONE;
    ttf_verify_report_free(&report);
    return r;
}
