/* SPDX-License-Identifier: Apache-2.0 */
#include "sim_run.h"

#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/verify.h"

void sim_run_plain(struct sim_run *run)
{
    struct ttf_plan_shot *shot = &run->plan.shots[0];

    memset(run, 0, sizeof(*run));
    ttf_sim_config_defaults(&run->config);
    run->config.width = 48;
    run->config.height = 32;
    run->scene = "grass";
    run->scene_span_ns = 7 * TTF_NS_PER_DAY;
    ttf_plan_defaults(&run->plan);
    strcpy(run->plan.title, "a capture");
    run->plan.interval_ns = TTF_NS_PER_MIN;
    run->plan.count = 6;
    run->plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    run->plan.settle_ns = 10 * TTF_NS_PER_S;
    shot->n_levels = 1;
    strcpy(shot->levels[0].lamp, "left");
    shot->levels[0].permille = 1000;
    run->plan.reserve_bytes = 0;
}

void sim_run_init(struct sim_run *run)
{
    sim_run_plain(run);
    strcpy(run->folder, "/tmp/ttf-sim-XXXXXX");
    assert_non_null(mkdtemp(run->folder));
    snprintf(run->path, sizeof(run->path), "%s/dataset", run->folder);
}

/* The machine's files, on a disk that may say that it is full. */
struct sim_disk {
    struct ttf_io io;
    struct ttf_io_ops ops;
    struct sim_run *run;
};

static int disk_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    const struct sim_disk *disk = (const struct sim_disk *)io;
    int r = ttf_io_posix()->ops->space(ttf_io_posix(), path, ret);

    if (r == 0) /* not what this machine's own disk has */
        ret->fs_errors =
            strstr(path, "/second") ? disk->run->second_fs_errors : disk->run->fs_errors;
    if (r == 0 && disk->run->free_bytes != 0 && !strstr(path, "/second"))
        ret->free_bytes = disk->run->free_bytes;
    return r;
}

static int no_sync(struct ttf_io *io, int file, bool data_only)
{
    return 0;
}

static int no_sync_dir(struct ttf_io *io, const char *path)
{
    return 0;
}

/* What a file operation meets in this box, at this moment. */
static int storage_fault(void *ctx, const char *op, const char *path)
{
    struct sim_run *run = ctx;
    const unsigned storage = strstr(path, "/second") != NULL;
    int error = 0;

    if (!run->box)
        return 0;
    if (run->on_file)
        run->on_file(run);
    if (run->fault)
        error = run->fault(run, op, path);
    if (error)
        return error;
    if (run->failing > 0) {
        run->failing--;
        return EIO;
    }
    if (ttf_sim_storage_fault_at(run->box, TTF_FAULT_READ_ONLY, storage))
        return EROFS;
    if (ttf_sim_storage_fault_at(run->box, TTF_FAULT_DISK_FULL, storage))
        return ENOSPC;
    return ttf_sim_storage_fault_at(run->box, TTF_FAULT_IO_ERROR, storage) ? EIO : 0;
}

static void told(void *ctx, const struct ttf_progress *progress)
{
    struct sim_run *run = ctx;

    if (progress->kind == TTF_PROGRESS_SLOT) {
        run->slots_told++;
        run->committed = progress->index + 1;
    }
    if (progress->kind == TTF_PROGRESS_ALARM) {
        run->alarms++;
        snprintf(run->alarm_text, sizeof(run->alarm_text), "%.500s", progress->text);
    }
    if (progress->kind == TTF_PROGRESS_ALARM_OVER)
        run->alarms_over += strcmp(run->alarm_text, progress->text) == 0;
    if (progress->kind == TTF_PROGRESS_EVENT)
        run->events_told++;
    if (run->on_progress)
        run->on_progress(run, progress);
}

static int run_session(struct sim_run *run, struct ttf_io *io)
{
    struct ttf_session_config config = {
        .box = run->box,
        .io = io,
        .path = run->path,
        .plan = &run->plan,
        .plan_yaml = run->plan_yaml ? run->plan_yaml : "# as given\n",
        .plan_as_given = run->plan_as_given,
        .control = run->control,
        .calibration_folder = run->calibration,
        .threads = 1,
        .progress = told,
        .progress_ctx = run,
        .stop = &run->stop,
        .rehearse = run->rehearse,
    };

    return ttf_session_run(&config, &run->result, &run->err);
}

int sim_run_boot(struct sim_run *run)
{
    struct sim_disk disk = {.ops = *ttf_io_posix()->ops, .run = run};
    struct ttf_io *io = ttf_io_faulty_create(&disk.io, storage_fault, run);
    struct ttf_scene scene;
    struct ttf_box box;

    assert_non_null(io);
    disk.io.ops = &disk.ops;
    disk.ops.space = disk_space;
    if (run->plain_disk || run->no_waiting) {
        disk.ops.sync = no_sync;
        disk.ops.sync_dir = no_sync_dir;
    }
    memset(&run->err, 0, sizeof(run->err));
    assert_int_equal(
        ttf_scene_procedural(run->scene, run->config.seed, run->scene_span_ns, &scene, &run->err),
        0);
    run->code = ttf_sim_box_create(&run->config, &scene, &box, &run->err);
    if (run->code < 0)
        print_error("box: %s: %s\n", run->err.where, run->err.what);
    assert_int_equal(run->code, 0);
    run->box = &box;
    if (run->on_box)
        run->on_box(run);
    run->code = run_session(run, run->plain_disk ? &disk.io : io);
    run->ended_ns = ttf_sim_elapsed_ns(&box, ttf_clock_now_ns(box.clock));
    run->back_ns = ttf_sim_back_ns(&box);
    run->bites = ttf_sim_watchdog_bites(&box);
    if (run->at_end)
        run->at_end(run);
    run->box = NULL;
    ttf_box_destroy(&box);
    ttf_io_faulty_destroy(io);
    return run->code;
}

int sim_run_through_cuts(struct sim_run *run)
{
    while (sim_run_boot(run) == -ESHUTDOWN)
        run->config.power_on_ns = run->back_ns;
    return run->code;
}

struct ttf_fault *sim_run_fault(struct sim_run *run, enum ttf_fault_kind kind, int64_t at_ns)
{
    struct ttf_fault *fault = &run->config.faults[run->config.n_faults++];

    *fault = (struct ttf_fault){.kind = kind, .at_ns = at_ns};
    return fault;
}

bool sim_run_path_ends(const char *path, const char *end)
{
    size_t n = strlen(path), m = strlen(end);

    return n >= m && strcmp(path + n - m, end) == 0;
}

static int remove_entry(void *ctx, const char *name, bool is_dir)
{
    char path[512];

    snprintf(path, sizeof(path), "%s/%s", (const char *)ctx, name);
    if (is_dir)
        (void)ttf_io_posix()->ops->list(ttf_io_posix(), path, remove_entry, path);
    return ttf_io_posix()->ops->unlink(ttf_io_posix(), path);
}

void sim_run_finish(struct sim_run *run)
{
    char parent[] = "/tmp";

    (void)remove_entry(parent, strrchr(run->folder, '/') + 1, true);
}

static struct ttf_reader *open_reader(const struct sim_run *run)
{
    struct ttf_reader *reader = NULL;
    struct ttf_err err = {0};
    int r = ttf_reader_open(ttf_io_posix(), run->path, &reader, &err);

    if (r < 0)
        print_error("reader: %s: %s\n", err.where, err.what);
    assert_int_equal(r, 0);
    return reader;
}

int64_t sim_run_due_ns(const struct sim_run *run, int64_t k)
{
    struct ttf_reader *reader = open_reader(run);
    struct ttf_segment segment;

    assert_int_equal(ttf_reader_segment(reader, 0, &segment), 0);
    ttf_reader_close(reader);
    /* The boot clock of the first boot begins at the first power-on. */
    return segment.origin_ns + k * segment.interval_ns;
}

void sim_run_record(const struct sim_run *run, int64_t index, struct ttf_slot_record *ret)
{
    struct ttf_reader *reader = open_reader(run);
    int64_t i = ttf_reader_find(reader, index);

    assert_true(i >= 0);
    assert_int_equal(ttf_reader_slot(reader, i, ret, NULL), 0);
    assert_int_equal(ret->index, index);
    ttf_reader_close(reader);
}

void sim_run_results(const struct sim_run *run, char *ret, size_t size)
{
    static const char letters[] = "cpmfzw";
    struct ttf_reader *reader = open_reader(run);
    int64_t n = ttf_reader_summary(reader)->slots;

    assert_true(n < (int64_t)size);
    for (int64_t i = 0; i < n; i++) {
        struct ttf_slot_record record;

        assert_int_equal(ttf_reader_slot(reader, i, &record, NULL), 0);
        assert_int_equal(record.index, i);
        ret[i] = letters[record.result];
        ttf_slot_record_free(&record);
    }
    ret[n] = '\0';
    ttf_reader_close(reader);
}

void sim_run_expect(const struct sim_run *run, const char *letters)
{
    char results[4096];

    sim_run_results(run, results, sizeof(results));
    assert_string_equal(results, letters);
}

unsigned sim_run_events(const struct sim_run *run, const char *kind, const char *text)
{
    char path[128];
    char want[64];
    char *all = NULL;
    char *rest = NULL;
    size_t bytes;
    unsigned n = 0;

    snprintf(path, sizeof(path), "%s/events.jsonl", run->path);
    snprintf(want, sizeof(want), "\"kind\":\"%s\"", kind);
    if (ttf_io_slurp(ttf_io_posix(), path, 1 << 24, &all, &bytes, NULL) < 0)
        return 0;
    for (char *line = strtok_r(all, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        if (strstr(line, want) && (!text || strstr(line, text)))
            n++;
    }
    free(all);
    return n;
}

void sim_run_expect_flag(const struct sim_run *run, int64_t index, const char *flag)
{
    struct ttf_slot_record record;

    sim_run_record(run, index, &record);
    assert_true(record.n_images > 0);
    if (!strstr(record.images[0].flags, flag))
        print_error("slot %d: flags '%s', not %s\n", (int)index, record.images[0].flags, flag);
    assert_non_null(strstr(record.images[0].flags, flag));
    ttf_slot_record_free(&record);
}

void sim_run_expect_no_flag(const struct sim_run *run, int64_t index)
{
    struct ttf_slot_record record;

    sim_run_record(run, index, &record);
    assert_int_equal(record.result, TTF_RESULT_CAPTURED);
    assert_string_equal(record.images[0].flags, "");
    assert_true(record.images[0].n_files > 0);
    ttf_slot_record_free(&record);
}

void sim_run_expect_reason(const struct sim_run *run, int64_t index, const char *reason)
{
    struct ttf_slot_record record;

    sim_run_record(run, index, &record);
    assert_string_equal(record.reason, reason);
    ttf_slot_record_free(&record);
}

int64_t sim_run_due_of(const struct sim_run *run, int64_t index)
{
    struct ttf_slot_record record;
    int64_t due;

    sim_run_record(run, index, &record);
    due = record.due_ns;
    ttf_slot_record_free(&record);
    return due;
}

int sim_run_segment_of(const struct sim_run *run, int64_t index, struct ttf_segment *ret)
{
    struct ttf_slot_record record;
    struct ttf_reader *reader;
    int n;

    sim_run_record(run, index, &record);
    n = record.segment;
    ttf_slot_record_free(&record);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, n, ret), 0);
    ttf_reader_close(reader);
    return n;
}

char *sim_run_text(const struct sim_run *run, const char *name)
{
    char path[160];
    char *text = NULL;
    size_t bytes;

    snprintf(path, sizeof(path), "%s/%s", run->path, name);
    return ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &text, &bytes, NULL) < 0 ? NULL : text;
}

void sim_run_expect_text(const struct sim_run *run, const char *name, const char *what)
{
    char *text = sim_run_text(run, name);

    assert_non_null(text);
    if (!strstr(text, what))
        print_error("%s: '%s' lacks '%s'\n", name, text, what);
    assert_non_null(strstr(text, what));
    free(text);
}

/* Deep verify: not damaged; sealed as said. Returns its slots. */
static int64_t expect_sound(const struct sim_run *run, bool sealed)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    int64_t slots;

    assert_int_equal(ttf_verify(ttf_io_posix(), run->path, &options, &report, &err), 0);
    for (unsigned i = 0; report.damaged && i < report.n_findings; i++)
        print_message("verify: %s: %s: %s\n", ttf_severity_name(report.findings[i].severity),
                      report.findings[i].file, report.findings[i].text);
    assert_false(report.damaged);
    assert_int_equal(report.sealed, sealed);
    slots = report.slots;
    ttf_verify_report_free(&report);
    return slots;
}

void sim_run_expect_undamaged(const struct sim_run *run, bool sealed)
{
    (void)expect_sound(run, sealed);
}

void sim_run_expect_whole(const struct sim_run *run, bool sealed)
{
    int64_t slots = expect_sound(run, sealed);

    if (sealed)
        assert_int_equal(slots, run->plan.count);
}
