/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_plan.c: `ttfbox plan check`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>

#include "box.h"
#include "commands.h"
#include "ttf/capture/disk_budget.h"
#include "ttf/config/plan_file.h"
#include "ttf/config/units.h"

/* What is checked, and what came of it. */
struct check {
    struct ttf_plan_file *file;
    struct ttf_box box;
    struct ttf_clock *clock; /* the machine's: disks are measured in real time */
    struct ttf_plan_figures figures;
    struct ttf_disk_figures disk;
    int64_t now_utc_ns;
    bool same_disk; /* the second storage lies on the first one's */
};

/* A duration for people: "7 d 3 h", "12 min 30 s"; without the parts that are zero. */
static const char *span(int64_t ns, char *buf, size_t size)
{
    static const struct {
        const char *name;
        int64_t s;
        int64_t below_s; /* of longer ones it is left out */
    } PARTS[] = {
        {"d", 86400, INT64_MAX}, {"h", 3600, INT64_MAX}, {"min", 60, INT64_MAX}, {"s", 1, 3600}};
    int64_t whole = ns / TTF_NS_PER_S, left = whole;
    size_t n = 0;

    if (ns < TTF_NS_PER_MIN) {
        (void)snprintf(buf, size, "%.3g s", (double)ns / 1e9);
        return buf;
    }
    for (unsigned i = 0; i < TTF_COUNT_OF(PARTS) && n < size; i++) {
        int64_t part = left / PARTS[i].s;

        left %= PARTS[i].s;
        if (part > 0 && whole < PARTS[i].below_s)
            n += (size_t)snprintf(buf + n, size - n, "%s%" PRId64 " %s", n ? " " : "", part,
                                  PARTS[i].name);
    }
    return buf;
}

static const char *size_text(int64_t bytes, char *buf, size_t size)
{
    if (bytes < 10 * 1000000)
        (void)snprintf(buf, size, "%.1f kB", (double)bytes / 1e3);
    else if (bytes < INT64_C(10) * 1000000000)
        (void)snprintf(buf, size, "%.1f MB", (double)bytes / 1e6);
    else
        (void)snprintf(buf, size, "%.1f GB", (double)bytes / 1e9);
    return buf;
}

static void say_shots(const struct cli *cli, const struct check *c)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);

    for (unsigned i = 0; i < plan->n_shots; i++) {
        const struct ttf_plan_shot *shot = &plan->shots[i];
        char brackets[160] = "";
        size_t n = 0;

        for (unsigned b = 0; shot->n_brackets > 1 && b < shot->n_brackets; b++)
            n += (size_t)snprintf(brackets + n, sizeof brackets - n, "%s%.4g",
                                  b ? ", " : ", brackets of ", shot->brackets[b]);
        cli_say(cli, "exposure %-8s %.3f ms%s", shot->stream,
                (double)c->figures.exposure_ns[i] / 1e6, brackets);
    }
}

static void say_lamps(const struct cli *cli, const struct check *c)
{
    const struct ttf_plan_figures *f = &c->figures;

    for (unsigned i = 0; c->box.lamps && i < ttf_lamps_count(c->box.lamps); i++)
        cli_say(cli, "lamp %-12s %.1f h on, %" PRId64 " switchings, duty %u permille",
                ttf_lamps_info(c->box.lamps, i)->name, (double)f->lamp_on_ns[i] / TTF_NS_PER_H,
                f->lamp_switchings[i], f->lamp_duty_permille[i]);
}

/* When it is day: what a local time and a zone came to, before weeks rest on it. */
static void say_light(const struct cli *cli, const struct ttf_plan *plan)
{
    int offset = plan->zone_offset_s < 0 ? -plan->zone_offset_s : plan->zone_offset_s;
    char day[64], period[64], from[64];

    if (plan->lamps != TTF_LAMPS_PHOTOPERIOD)
        return;
    (void)span(plan->day_ns, day, sizeof day);
    (void)span(plan->period_ns, period, sizeof period);
    if (plan->photoperiod_local)
        cli_say(cli, "light             %s of every %s, from %02d:%02d in %s, UTC%c%02d:%02d", day,
                period, plan->day_start_s / 3600, plan->day_start_s / 60 % 60, plan->zone,
                plan->zone_offset_s < 0 ? '-' : '+', offset / 3600, offset / 60 % 60);
    else
        cli_say(cli, "light             %s of every %s, from %s%s", day, period,
                plan->phase_ns ? span(plan->phase_ns, from, sizeof from) : "the first slot",
                plan->phase_ns ? " after the first slot" : "");
}

/* A warning, not a refusal: whoever averages or does not mind rows may know better. */
static void warn_of_flicker(const struct check *c)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);

    for (unsigned i = 0; i < plan->n_shots; i++)
        if (c->figures.flicker_ppm[i] > TTF_FLICKER_SHOWS_PPM)
            cli_warn("ttfbox plan check: warning: shot '%s': lamps dimmed by pulses leave bands of "
                     "%.1f%% in it: expose for whole cycles, or longer, or take a shorter 'period'",
                     plan->shots[i].stream, (double)c->figures.flicker_ppm[i] / 1e4);
}

static void say(const struct cli *cli, const struct check *c)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);
    const struct ttf_plan_figures *f = &c->figures;
    /* At once means when the lamps have settled. */
    int64_t start = plan->start_utc_ns ? plan->start_utc_ns : c->now_utc_ns + f->ready_ns;
    char a[64], b[64];

    if (c->box.simulated)
        cli_say(cli, "SIMULATED         board '%s': what it photographs is computed", c->box.board);
    if (*plan->title)
        cli_say(cli, "plan              %s", plan->title);
    cli_say(cli, "slots             %" PRId64 ", one every %s", f->slots,
            span(plan->interval_ns, a, sizeof a));
    cli_say(cli, "length            %s", span(f->duration_ns, a, sizeof a));
    cli_say(cli, "end               %s if it starts %s",
            ttf_utc_format(start + f->duration_ns, a, sizeof a),
            plan->start_utc_ns                   ? ttf_utc_format(start, b, sizeof b)
            : ttf_clock_is_virtual(c->box.clock) ? "now, by the simulated clock"
                                                 : "now");
    cli_say(cli, "busy              %s of each interval", span(f->slot_busy_ns, a, sizeof a));
    say_shots(cli, c);
    say_light(cli, plan);
    say_lamps(cli, c);
    cli_say(cli, "storage           %s, %s a slot", size_text(f->bytes, a, sizeof a),
            size_text(f->slot_bytes, b, sizeof b));
    cli_say(cli, "memory            %s", size_text(f->memory_bytes, a, sizeof a));
    if (c->disk.free_bytes)
        cli_say(cli, "disk              %s free, room for %" PRId64 " slots",
                size_text(c->disk.free_bytes, a, sizeof a), c->disk.slots_that_fit);
    if (c->disk.bytes_per_s)
        cli_say(cli, "write speed       %s/s, sustains a slot every %s",
                size_text(c->disk.bytes_per_s, a, sizeof a),
                span(c->disk.shortest_interval_ns, b, sizeof b));
    if (*plan->second_storage)
        cli_say(cli, "second storage    %s%s", plan->second_storage,
                c->same_disk ? ", on the same file system" : "");
    cli_say(cli, "The plan fits.");
}

static void put_json(struct ttf_json *j, const struct check *c)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);
    const struct ttf_plan_figures *f = &c->figures;

    ttf_json_kbool(j, "simulated", c->box.simulated);
    ttf_plan_figures_put(plan, f, j);
    if (*plan->second_storage)
        ttf_json_kstring(j, "second_storage", plan->second_storage);
    ttf_json_key(j, "lamps");
    ttf_json_array(j);
    for (unsigned i = 0; c->box.lamps && i < ttf_lamps_count(c->box.lamps); i++) {
        ttf_json_object(j);
        ttf_json_kstring(j, "name", ttf_lamps_info(c->box.lamps, i)->name);
        ttf_json_kint(j, "on_ns", f->lamp_on_ns[i]);
        ttf_json_kint(j, "switchings", f->lamp_switchings[i]);
        ttf_json_kint(j, "duty_permille", f->lamp_duty_permille[i]);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
    if (c->disk.free_bytes)
        ttf_json_kint(j, "disk_free_bytes", c->disk.free_bytes);
    if (c->disk.bytes_per_s) {
        ttf_json_kint(j, "disk_bytes_per_s", c->disk.bytes_per_s);
        ttf_json_kint(j, "shortest_interval_ns", c->disk.shortest_interval_ns);
    }
}

/* The second storage, and against the first one's disk if a folder is named. */
static int check_second(struct cli *cli, struct check *c, const struct ttf_plan *plan)
{
    const char *path = cli->opt.output;
    int r = ttf_second_storage_check(cli->io, path ? path : "", plan, path ? &c->same_disk : NULL,
                                     &cli->err);

    if (r < 0)
        return -EINVAL; /* wrong input, at its line */
    if (c->same_disk)
        cli_warn("ttfbox plan check: warning: the second storage lies on the same file system as "
                 "%s: what fills or breaks one does so to the other",
                 path);
    return 0;
}

/* The plan against the box, and against the disk if a folder is named. */
static int check(struct cli *cli, struct check *c, const struct ttf_board *board)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);
    struct ttf_utc utc;
    int r = box_create(board, cli->io, NULL, &c->box, &cli->err);

    if (r == 0)
        r = box_configure(board, &c->box, &cli->err);
    if (r < 0) {
        if (!board->simulated)
            ttf_err_hint(&cli->err, "a plan is checked by its box; on another machine take -b sim "
                                    "with the lamps' limits by --set (boards/README.md)");
        return r;
    }
    ttf_clock_utc(c->box.clock, &utc);
    c->now_utc_ns = utc.utc_ns;
    r = ttf_plan_file_resolve(c->file, utc.utc_ns, &cli->err);
    if (r == 0)
        r = ttf_plan_file_check_start(c->file, &utc, &cli->err);
    if (r == 0)
        r = ttf_plan_check(plan, &c->box, &c->figures, &cli->err);
    if (r == 0 && cli->opt.output) {
        c->clock = ttf_clock_real_create();
        r = c->clock ? ttf_disk_budget_check(cli->io, cli->opt.output, c->clock, plan, &c->figures,
                                             &c->disk, &cli->err)
                     : ttf_err_set(&cli->err, -errno, "clock", "the machine's clock cannot be had");
        /* A disk too small is a plan too long: wrong input, at the line that says how long. */
        if (r == -ENOSPC) {
            ttf_err_prefix(&cli->err, "%s", cli->opt.output);
            (void)snprintf(cli->err.where, sizeof cli->err.where, "count");
            r = -EINVAL;
        }
    }
    if (r == 0)
        r = check_second(cli, c, plan);
    if (r < 0)
        ttf_plan_file_place(c->file, &cli->err);
    return r;
}

int cmd_plan_check(struct cli *cli)
{
    struct check c = {0};
    struct ttf_board board;
    int r = ttf_plan_file_load(cli->opt.args[0], &c.file, &cli->err);

    if (r == 0)
        r = cli_load_board(cli, &board);
    if (r == 0)
        r = check(cli, &c, &board);
    if (r == 0) {
        warn_of_flicker(&c);
        say(cli, &c);
        put_json(&cli->out, &c);
    }
    ttf_clock_destroy(c.clock);
    ttf_box_destroy(&c.box);
    ttf_plan_file_free(c.file);
    return r;
}
