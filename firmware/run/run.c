/* SPDX-License-Identifier: Apache-2.0 */
#include "run.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "sim_boot.h"
#include "ttf/dataset/reader.h"

/* A simulated box that loses power more often than this in one run is set up wrongly. */
#define BOOTS_MAX 1000

/* ---- what lies there ---- */

static int refuse_foreign(const struct run *run, struct ttf_reader *reader, struct ttf_err *err)
{
    const struct ttf_manifest *m = ttf_reader_manifest(reader);
    int r = 0;

    if (*m->source || *m->derived_uuid)
        r = ttf_err_set(err, -EEXIST, run->session.path, "is no capture: it was %s",
                        *m->source ? "imported" : "derived");
    else if (m->simulated != run->board->simulated)
        r = ttf_err_set(err, -EINVAL, run->session.path, "%s",
                        run->board->simulated ? "was captured by a real box, this one is simulated"
                                              : "is SIMULATED, this box is real");
    if (r < 0)
        ttf_err_hint(err, "capture into another place");
    return r;
}

int run_look(struct run *run, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    struct ttf_io_stat st;
    char path[4096 + 16];
    int r = ttf_session_find(run->io, run->session.path, ttf_plan_file_plan(run->file),
                             run->dataset, sizeof run->dataset, err);

    run->exists = false;
    run->next_index = 0;
    run->digest[0] = '\0';
    if (r < 0)
        return r;
    (void)snprintf(path, sizeof path, "%s/dataset.json", run->dataset);
    /* New, or cut off before it was born: the writer knows which, and refuses anything else. */
    if (run->io->ops->stat(run->io, path, &st) < 0)
        return 0;
    r = ttf_reader_open(run->io, run->dataset, &reader, err);
    if (r < 0)
        return r;
    run->exists = true;
    if (ttf_reader_summary(reader)->slots > 0)
        run->next_index = ttf_reader_summary(reader)->last_index + 1;
    if (ttf_reader_digest(reader, run->digest, NULL) < 0)
        run->digest[0] = '\0';
    r = refuse_foreign(run, reader, err);
    if (r == 0 && run->board->simulated)
        r = sim_boot_power_on(reader, &run->board->sim, &run->board->sim.power_on_ns, err);
    ttf_reader_close(reader);
    return r;
}

/* ---- running ---- */

/* The clock as it would have been when the run was wanted first. */
static struct ttf_utc utc_when_wanted(const struct run *run, const struct ttf_utc *now)
{
    struct ttf_utc then = *now;

    if (run->wanted_ns > 0 && run->wanted_ns < now->boot_ns)
        then.utc_ns -= now->boot_ns - run->wanted_ns;
    return then;
}

/* The plan as this box has it, now. */
static int prepare_plan(struct run *run, const struct ttf_box *box, struct ttf_err *err)
{
    struct ttf_plan_figures figures;
    struct ttf_utc utc, then;
    int r;

    ttf_clock_utc(box->clock, &utc);
    then = utc_when_wanted(run, &utc);
    r = ttf_plan_file_resolve(run->file, utc.utc_ns, err);
    /* What has begun may go on long after its start, and a rehearsal does not wait for it. */
    if (r == 0 && run->boots == 1 && !run->exists && !run->session.rehearse)
        r = ttf_plan_file_check_start(run->file, &then, err);
    if (r == 0)
        r = ttf_plan_check(ttf_plan_file_plan(run->file), box, &figures, err);
    if (r < 0)
        ttf_plan_file_place(run->file, err);
    else if (run->box_ready)
        run->box_ready(run->box_ready_ctx, box, ttf_plan_file_plan(run->file), &figures);
    return r;
}

static int run_session(struct run *run, struct ttf_box *box, struct ttf_io *io, struct ttf_err *err)
{
    struct ttf_session_config config = run->session;
    int r;

    config.box = box;
    config.io = io;
    config.plan = ttf_plan_file_plan(run->file);
    config.plan_yaml = ttf_plan_file_text(run->file);
    r = ttf_session_run(&config, &run->result, err);
    if (r < 0 && r != -ENODEV && strcmp(err->where, "storage.second") == 0)
        r = -EINVAL; /* whatever is the matter with the folder, but for a disk that is away: the plan names it */
    if (r == -EINVAL)
        ttf_plan_file_place(run->file, err);
    return r;
}

/* One boot of the box: devices, plan against them, the session until it ends. */
static int one_boot(struct run *run, int64_t *ret_back_ns, struct ttf_err *err)
{
    struct ttf_box box = {0};
    struct box_disk disk = {0};
    int r = box_create(run->board, run->io, run->host, &box, err);

    if (r == 0)
        r = box_configure(run->board, &box, err);
    if (r < 0)
        goto out;
    memcpy(box.description, run->description, sizeof box.description);
    r = prepare_plan(run, &box, err);
    if (r < 0)
        goto out;
    r = box_disk_create(&disk, run->io, &box, ttf_plan_file_plan(run->file)->second_storage);
    if (r < 0) {
        ttf_err_set(err, r, NULL, "no memory");
        goto out;
    }
    r = run_session(run, &box, disk.io, err);
    if (r == -ESHUTDOWN)
        *ret_back_ns = ttf_sim_back_ns(&box);
out:
    box_disk_destroy(&disk);
    ttf_box_destroy(&box);
    return r;
}

int run_boots(struct run *run, struct ttf_err *err)
{
    for (run->boots = 1;; run->boots++) {
        int64_t back_ns = 0;
        int r = one_boot(run, &back_ns, err);

        if (r != -ESHUTDOWN)
            return r;
        if (run->power_back)
            run->power_back(run->power_back_ctx, back_ns);
        if (run->boots == BOOTS_MAX || back_ns <= run->board->sim.power_on_ns)
            return ttf_err_set(err, -EIO, "sim.faults", "the simulated box never keeps its power");
        if (run->session.stop && __atomic_load_n(run->session.stop, __ATOMIC_RELAXED))
            return 0;
        memset(err, 0, sizeof *err);
        run->board->sim.power_on_ns = back_ns;
    }
}

int run_exit_code(int error)
{
    switch (error) {
    case 0:
        return 0;
    case -TTF_EDAMAGED:
        return 3;
    case -EINVAL:
    case -ENOENT:
    case -EEXIST:
    case -ENOTSUP:
    case -ENOTDIR:
    case -EISDIR:
    case -ENOTEMPTY:
    case -ENODATA:
    case -ERANGE:
    case -EFBIG:
    case -ENAMETOOLONG:
        return 2;
    default:
        return 1;
    }
}
