/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_capture.c: `ttfbox capture`: a session, and, in a simulated box, its reboots. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture_script.h"
#include "commands.h"
#include "run.h"
#include "ttf/capture/disk_budget.h"
#include "ttf/capture/session.h"

struct capture {
    struct cli *cli;
    struct ttf_board board;
    struct run run;
    struct box_lock lock;
    struct cli_progress bar;
    struct capture_script *script; /* NULL: none */
    unsigned unheard;              /* of its lines */
    char path[4096];               /* of the dataset that the run went on in */
    unsigned events;
};

static void on_progress(void *ctx, const struct ttf_progress *p)
{
    struct capture *c = ctx;
    char text[96];

    if (p->kind == TTF_PROGRESS_ALARM) {
        cli_progress_end(&c->bar);
        cli_warn("ttfbox capture: %s", p->text);
        return;
    }
    if (p->kind == TTF_PROGRESS_ALARM_OVER)
        return; /* what ended it has an event */
    if (p->kind == TTF_PROGRESS_EVENT) {
        c->events++;
        if (c->bar.shown) {
            cli_progress_end(&c->bar);
            cli_warn("%s", p->text);
        }
        return;
    }
    (void)snprintf(text, sizeof text, "%s%s", c->board.simulated ? "SIMULATED " : "",
                   p->text ? p->text : "");
    cli_progress_at(&c->bar, p->kind == TTF_PROGRESS_SLOT ? p->index + 1 : p->index, p->total,
                    text);
}

/* Two storages on one disk are worth a word before a week begins. */
static void warn_of_same_disk(struct capture *c)
{
    bool same = false;

    if (ttf_second_storage_check(c->cli->io, c->cli->opt.output, ttf_plan_file_plan(c->run.file),
                                 &same, NULL) == 0 &&
        same)
        cli_warn("ttfbox capture: warning: the second storage lies on the same file system as %s: "
                 "what fills or breaks one does so to the other",
                 c->cli->opt.output);
}

static void say_rehearsal(struct capture *c)
{
    const struct ttf_session_result *s = &c->run.result;

    cli_say(c->cli, "busy              %.3f s a slot", (double)s->busy_ns / 1e9);
    cli_say(c->cli, "sustains          a slot every %.3f s",
            (double)s->sustained_interval_ns / 1e9);
    cli_say(c->cli, "headroom          %.2f stops below saturation", s->headroom_stops);
    if (!isnan(s->sharpness)) /* nothing was developed */
        cli_say(c->cli, "sharpness         %.4g", s->sharpness);
    cli_say(c->cli, "settling          %+.3f %% from the first slot to the last",
            s->settle_change * 100);
    cli_say(c->cli, "size              %.2f MB a slot", (double)s->slot_bytes / 1e6);
}

/* The same seal as before: this run added nothing. */
static bool was_complete(const struct capture *c)
{
    return c->run.result.sealed && strcmp(c->run.digest, c->run.result.digest) == 0;
}

/* Of the dataset that the run went on in. */
static const char *second_path(struct capture *c)
{
    if (ttf_session_find(c->cli->io, c->cli->opt.output, ttf_plan_file_plan(c->run.file), c->path,
                         sizeof c->path, NULL) < 0)
        return ttf_plan_file_plan(c->run.file)->second_storage;
    return c->path;
}

static void say(struct capture *c)
{
    const struct ttf_session_result *s = &c->run.result;
    struct cli *cli = c->cli;

    cli_say(cli, "%sdataset           %s", c->board.simulated ? "SIMULATED\n" : "",
            cli->opt.output);
    cli_say(cli,
            "slots             %" PRId64 ": %" PRId64 " captured, %" PRId64 " partial, %" PRId64
            " missed, %" PRId64 " failed, %" PRId64 " paused, %" PRId64 " without power",
            s->slots, s->captured, s->partial, s->missed, s->failed, s->paused, s->power);
    if (s->second_storage)
        cli_say(cli, "goes on in        %s: slots are counted there", second_path(c));
    if (s->moved_on_from >= 0)
        cli_say(cli,
                "plan              the one given is plans/%d of the dataset, which has moved on "
                "from it: left alone (--plan-as-given goes back to it)",
                s->moved_on_from);
    if (s->error_max_ns) /* 0: this run captured nothing */
        cli_say(cli, "timing            middle of exposure within %.3f ms (p99), %.3f ms at most",
                (double)s->error_p99_ns / 1e6, (double)s->error_max_ns / 1e6);
    if (cli->opt.rehearse)
        say_rehearsal(c);
    if (was_complete(c))
        cli_say(cli, "complete          already: nothing was left to do");
    if (s->sealed)
        cli_say(cli, "sealed            digest %s", s->digest);
    else if (!cli->opt.rehearse)
        cli_say(cli, "stopped           run the same command again to go on");
}

static void put_json(struct capture *c)
{
    const struct ttf_session_result *s = &c->run.result;
    struct ttf_json *j = &c->cli->out;

    ttf_json_kstring(j, "dataset", c->cli->opt.output);
    ttf_json_kbool(j, "simulated", c->board.simulated);
    ttf_json_kint(j, "slots", s->slots);
    ttf_json_kint(j, "captured", s->captured);
    ttf_json_kint(j, "partial", s->partial);
    ttf_json_kint(j, "missed", s->missed);
    ttf_json_kint(j, "failed", s->failed);
    ttf_json_kint(j, "paused", s->paused);
    ttf_json_kint(j, "power", s->power);
    ttf_json_kint(j, "error_p99_ns", s->error_p99_ns);
    ttf_json_kint(j, "error_max_ns", s->error_max_ns);
    ttf_json_kint(j, "wakeup_p99_ns", s->wakeup_p99_ns);
    ttf_json_kint(j, "wakeup_max_ns", s->wakeup_max_ns);
    ttf_json_kint(j, "events", c->events);
    ttf_json_kint(j, "boots", c->run.boots);
    ttf_json_kbool(j, "resumed", s->resumed || c->run.boots > 1);
    ttf_json_kbool(j, "already_complete", was_complete(c));
    ttf_json_kbool(j, "second_storage", s->second_storage);
    if (s->second_storage)
        ttf_json_kstring(j, "goes_on_in", second_path(c));
    ttf_json_kbool(j, "plan_left_alone", s->moved_on_from >= 0);
    ttf_json_kint(j, "script_lines_not_done", c->unheard);
    ttf_json_kbool(j, "sealed", s->sealed);
    if (s->sealed)
        ttf_json_kstring(j, "digest", s->digest);
    if (c->cli->opt.rehearse) {
        ttf_json_kint(j, "busy_ns", s->busy_ns);
        ttf_json_kdouble(j, "headroom_stops", s->headroom_stops);
        ttf_json_kdouble(j, "sharpness", s->sharpness);
        ttf_json_kdouble(j, "settle_change", s->settle_change);
        ttf_json_kint(j, "slot_bytes", s->slot_bytes);
        ttf_json_kint(j, "sustained_interval_ns", s->sustained_interval_ns);
    }
}

static void on_power_back(void *ctx, int64_t back_ns)
{
    struct capture *c = ctx;

    cli_progress_end(&c->bar);
    cli_warn("ttfbox capture: the simulated box lost power; it is back %.1f h after its first "
             "start and goes on",
             (double)back_ns / (double)TTF_NS_PER_H);
}

static int begin(struct capture *c)
{
    struct cli *cli = c->cli;
    struct run *run = &c->run;
    int r = cli_need(cli, cli->opt.output, "-o", "say where the dataset goes, as -o grass");

    if (r == 0)
        r = ttf_plan_file_load(cli->opt.args[0], &run->file, &cli->err);
    if (r == 0)
        r = cli_load_board(cli, &c->board);
    if (r < 0)
        return r;
    run->io = cli->io;
    run->board = &c->board;
    run->power_back = on_power_back;
    run->power_back_ctx = c;
    cli_describe_board(cli, &c->board, run->description);
    run->session = (struct ttf_session_config){
        .path = cli->opt.output,
        .calibration_folder = cli->opt.calibration,
        .threads = (unsigned)cli->opt.threads,
        .progress = on_progress,
        .progress_ctx = c,
        .stop = cli_stop_flag(),
        .plan_as_given = cli->opt.as_given,
        .rehearse = cli->opt.rehearse,
        .skip_speed_check = cli->opt.no_speed_check,
    };
    r = cli_own_box(cli, &c->board, &c->lock);
    if (r == 0)
        r = run_look(run, &cli->err);
    if (r == 0 && cli->opt.script)
        r = capture_script_ask(cli, cli->opt.script, run->next_index, &c->script);
    run->session.control = c->script ? capture_script_control(c->script) : NULL;
    return r;
}

int cmd_capture(struct cli *cli)
{
    struct capture *c = calloc(1, sizeof *c);
    int r;

    if (!c)
        return -ENOMEM;
    c->cli = cli;
    c->lock.fd = -1;
    r = begin(c);
    if (r == 0) {
        if (!c->run.exists)
            warn_of_same_disk(c);
        cli_stop_catch();
        cli_progress_begin(&c->bar, cli, c->run.exists ? "going on" : "capturing");
        r = run_boots(&c->run, &cli->err);
        cli_progress_end(&c->bar);
        c->unheard = c->script ? capture_script_tell(c->script) : 0;
    }
    if (r == 0) {
        say(c);
        put_json(c);
        if ((!c->run.result.sealed && !cli->opt.rehearse) || c->unheard > 0)
            r = CLI_FAILED; /* stopped before it was done, or not done as asked */
    }
    box_lock_drop(&c->lock);
    ttf_plan_file_free(c->run.file);
    capture_script_free(c->script);
    free(c);
    return r;
}
