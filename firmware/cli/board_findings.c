/* SPDX-License-Identifier: Apache-2.0 */
#include "board_findings.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "probe.h"

static void look(struct cli *cli, const struct ttf_board *board, struct ttf_clock *clock,
                 bool no_camera, struct probe_findings *findings)
{
    struct probe_machine machine;
    struct ttf_utc utc = {.trust = TTF_TRUST_NONE};
    char real[4096];

    probe_machine_here(&machine, cli->opt.root);
    probe_is_meant(&machine, board, findings);
    probe_cameras(&machine, board, findings);
    if (no_camera)
        probe_silent_camera(&machine, board, findings);
    probe_lines(&machine, board, findings);
    probe_usb(&machine, board, findings);
    if (clock)
        ttf_clock_utc(clock, &utc);
    probe_clock(&machine, utc.trust, findings);
    probe_power(&machine, board, findings);
    probe_fs_errors(&machine, findings);
    if (!cli->opt.output)
        return;
    /* Mounts are told by whole paths; another machine's are taken as they stand. */
    if (cli->opt.root || !realpath(cli->opt.output, real))
        (void)snprintf(real, sizeof real, "%s", cli->opt.output);
    probe_storage(&machine, real, findings);
    if (clock && !cli->opt.root) {
        int64_t speed = probe_write_speed(real, clock, findings);

        if (speed > 0)
            ttf_json_kint(&cli->out, "write_bytes_per_s", speed);
        if (speed > 0)
            cli_say(cli, "storage           %s takes %.1f MB/s", cli->opt.output,
                    (double)speed / 1e6);
    }
}

unsigned board_findings(struct cli *cli, const struct ttf_board *board, struct ttf_clock *clock,
                        bool no_camera)
{
    struct probe_findings *findings = calloc(1, sizeof *findings);
    unsigned problems = 0;

    if (!findings)
        return 0;
    look(cli, board, clock, no_camera, findings);
    ttf_json_key(&cli->out, "findings");
    ttf_json_array(&cli->out);
    for (unsigned i = 0; i < findings->n; i++) {
        const struct probe_finding *f = &findings->finding[i];

        problems += f->weight == PROBE_PROBLEM;
        cli_say(cli, "%-17s %s: %s", f->weight == PROBE_PROBLEM ? "PROBLEM" : "note", f->about,
                f->text);
        if (*f->hint)
            cli_say(cli, "                  -> %s", f->hint);
        ttf_json_object(&cli->out);
        ttf_json_kbool(&cli->out, "problem", f->weight == PROBE_PROBLEM);
        ttf_json_kstring(&cli->out, "about", f->about);
        ttf_json_kstring(&cli->out, "text", f->text);
        ttf_json_kstring(&cli->out, "hint", f->hint);
        ttf_json_object_end(&cli->out);
    }
    ttf_json_array_end(&cli->out);
    free(findings);
    return problems;
}

int board_bundle(struct cli *cli, const struct ttf_board *board)
{
    struct probe_machine machine;
    char *report = NULL;
    int r;

    /* The object is still open: main ends it. */
    if (cli->out.error < 0 ||
        asprintf(&report, "%.*s}\n", (int)cli->out.used, cli->out.text ? cli->out.text : "{") < 0)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    probe_machine_here(&machine, cli->opt.root);
    r = probe_bundle(&machine, cli->opt.bundle, board->path, report, &cli->err);
    free(report);
    if (r == 0)
        cli_say(cli, "bundle            %s: attach it to a report", cli->opt.bundle);
    return r;
}
