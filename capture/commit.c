/* SPDX-License-Identifier: Apache-2.0 */
#include "commit.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "image_flags.h"

static bool power_lost(struct ttf_committer *c)
{
    if (!c->power_lost && c->box->power_lost)
        c->power_lost = c->box->power_lost(c->box->box_private) != 0;
    return c->power_lost;
}

void ttf_committer_tell(struct ttf_committer *committer, const struct ttf_progress *progress)
{
    if (!committer->progress)
        return;
    pthread_mutex_lock(&committer->progress_mutex);
    committer->progress(committer->progress_ctx, progress);
    pthread_mutex_unlock(&committer->progress_mutex);
}

/* ---- storage that fails ---- */

static const char *storage_reason(int r)
{
    return r == -ENOSPC ? TTF_REASON_DISK_FULL
                        : (r == -ENOMEM ? TTF_REASON_NO_MEMORY : TTF_REASON_IO_ERROR);
}

static void note_disk(struct ttf_committer *c, bool full)
{
    if (full != c->disk_full)
        ttf_events_emit(c->events, "disk",
                        full ? "less room than the reserve: no slot is captured"
                             : "there is room again");
    c->disk_full = full;
    ttf_queue_tell_disk(c->queue, full);
}

static void look_at_space(struct ttf_committer *c)
{
    struct ttf_io_space space;

    if (!c->writer || ttf_writer_space(c->writer, &space) < 0)
        return;
    note_disk(c, space.free_bytes < c->reserve_bytes + c->slot_bytes);
}

/* Image files that opening the dataset anew may have cleared away are taken from a record not yet written. */
static void drop_lost_files(struct ttf_committer *c, struct ttf_slot_record *record)
{
    char path[4096];

    for (unsigned i = 0; i < record->n_images; i++) {
        struct ttf_image *image = &record->images[i];
        unsigned kept = 0;

        for (unsigned f = 0; f < image->n_files; f++) {
            struct ttf_io_stat st;

            snprintf(path, sizeof(path), "%s/%s", c->path, image->files[f].path);
            if (c->io->ops->stat(c->io, path, &st) == 0 && st.bytes == image->files[f].bytes)
                image->files[kept++] = image->files[f];
        }
        if (image->n_files > 0 && kept == 0)
            snprintf(image->lacking, sizeof(image->lacking), "%s", TTF_REASON_IO_ERROR);
        image->n_files = kept;
    }
    ttf_ledger_judge(record);
}

/* After a write that failed nobody knows what is on the disk: open it anew, which repairs what it must. */
static int reopen(struct ttf_committer *c)
{
    struct ttf_err err = {0};
    int r;

    ttf_writer_abandon(c->writer);
    c->writer = NULL;
    r = ttf_writer_open(c->io, c->path, &c->writer, &err);
    if (r < 0) {
        c->writer = NULL;
        return r;
    }
    for (struct ttf_slot_work *work = c->pending; work; work = work->next)
        drop_lost_files(c, &work->record);
    return 0;
}

/* ---- records ---- */

static void acknowledge(struct ttf_committer *c, const struct ttf_slot_work *work)
{
    const struct ttf_slot_record *record = &work->record;
    int64_t now = ttf_clock_now_ns(c->box->clock);
    struct ttf_progress p = {
        .kind = TTF_PROGRESS_SLOT,
        .index = record->index,
        .total = c->total,
        .result = (int)record->result,
        .text = record->reason,
        .now_ns = now,
        .error_ns = record->middle_ns == TTF_NS_UNKNOWN ? TTF_NS_UNKNOWN
                                                        : record->middle_ns - record->due_ns,
        .wakeup_ns = work->wakeup_ns,
    };

    if (work->wakeup_ns != TTF_NS_UNKNOWN)
        ttf_quantile_add(&c->ledger.wakeup, work->wakeup_ns);
    if (c->rehearsal && c->busy_since_ns != TTF_NS_UNKNOWN)
        ttf_rehearsal_slot(c->rehearsal, record, now - work->begun_ns, now - c->busy_since_ns);
    ttf_committer_tell(c, &p);
}

/* Writes one record. 0 once it is on the disk. */
static int write_record(struct ttf_committer *c, const struct ttf_slot_record *record,
                        struct ttf_err *err)
{
    int r = c->writer ? ttf_writer_commit(c->writer, record, err) : -EIO;

    if (r == 0 || power_lost(c))
        return r;
    r = reopen(c);
    if (r < 0)
        return ttf_err_set(err, r, c->path, "the dataset cannot be opened anew");
    if (ttf_writer_state(c->writer)->next_index > record->index)
        return 0; /* it had got there after all */
    r = ttf_writer_commit(c->writer, record, err);
    if (r == 0)
        ttf_events_emit(c->events, "retry", "record of slot %lld needed a second try",
                        (long long)record->index);
    return r;
}

static void drop_first(struct ttf_committer *c)
{
    struct ttf_slot_work *work = c->pending;

    c->pending = work->next;
    if (!c->pending)
        c->pending_tail = NULL;
    c->n_pending--;
    ttf_slot_work_free(work);
}

static void append(struct ttf_committer *c, struct ttf_slot_work *work)
{
    work->next = NULL;
    if (c->pending_tail)
        c->pending_tail->next = work;
    else
        c->pending = work;
    c->pending_tail = work;
    c->n_pending++;
}

/* Writes the records that wait, oldest first. 0, or why the first of them could not be written. */
static int flush(struct ttf_committer *c, struct ttf_err *err)
{
    while (c->pending) {
        struct ttf_slot_work *work = c->pending;
        int r = write_record(c, &work->record, err);

        if (r < 0)
            return r;
        if (ttf_ledger_add(&c->ledger, &work->record) == 0)
            acknowledge(c, work);
        drop_first(c);
    }
    return 0;
}

static int write_event(struct ttf_committer *c, const struct ttf_job *event)
{
    if (!c->writer)
        return -EIO;
    return ttf_writer_event(c->writer, event->event, event->at_ns, event->at_utc_ns, event->text,
                            NULL, NULL);
}

static void write_late_lines(struct ttf_committer *c)
{
    if (c->has_segment && c->writer && ttf_writer_segment(c->writer, &c->segment, NULL) == 0)
        c->has_segment = false;
    while (c->n_late > 0 && write_event(c, c->late[0]) == 0) {
        ttf_job_free(c->late[0]);
        c->n_late--;
        memmove(&c->late[0], &c->late[1], c->n_late * sizeof(struct ttf_job *));
    }
}

/* What waits for a storage that was away. 0 once all records are written. */
static int catch_up(struct ttf_committer *c, struct ttf_err *err)
{
    int r = c->writer ? 0 : reopen(c);

    if (r == 0)
        r = flush(c, err);
    if (r == 0)
        write_late_lines(c);
    return r;
}

/* ---- images ---- */

/* Writes one file; an error that may pass is tried once more. */
static int print_file(struct ttf_committer *c, struct ttf_darkroom *room, const char *role,
                      const struct ttf_print *print)
{
    struct ttf_err err = {0};
    int r;

    if (!c->writer)
        return -EIO;
    r = ttf_darkroom_print(room, c->writer, role, print, &err);
    if (r == 0 || r == -ENOSPC || r == -EROFS || power_lost(c))
        return r;
    ttf_events_emit(c->events, "retry", "%s file of slot %lld is written again: %s", role,
                    (long long)print->index, err.what);
    return ttf_darkroom_print(room, c->writer, role, print, &err);
}

static void print_image(struct ttf_committer *c, const struct ttf_job *job)
{
    struct ttf_image *image = &job->slot->record.images[job->image];
    struct ttf_darkroom *room = c->rooms[job->shot];
    struct ttf_print print = {.raw = job->raw,
                              .index = job->slot->record.index,
                              .start_utc_ns = job->start_utc_ns,
                              .image = image};
    int raw = 0;
    int developed = 0;

    snprintf(image->calibration, sizeof(image->calibration), "%s", room->calibration);
    ttf_darkroom_reference(room, &print);
    if (room->keep != TTF_KEEP_DEVELOPED)
        raw = print_file(c, room, "raw", &print);
    if (room->keep != TTF_KEEP_RAW && !power_lost(c))
        developed = print_file(c, room, "developed", &print);
    if (power_lost(c))
        return;
    /* What one file holds is not lost with the other: from the raw the developed one can be made again. */
    if (image->n_files == 0)
        snprintf(image->lacking, sizeof(image->lacking), "%s",
                 storage_reason(raw < 0 ? raw : developed));
    else if (raw < 0)
        ttf_image_flag(image, "raw-lost");
    else if (developed < 0)
        ttf_image_flag(image, "developed-lost");
    if (raw < 0 || developed < 0)
        ttf_events_emit(c->events, "disk", "slot %lld, %s: %s", (long long)print.index,
                        image->stream, storage_reason(raw < 0 ? raw : developed));
}

static void do_image(struct ttf_committer *c, struct ttf_job *job)
{
    if (c->busy_since_ns == TTF_NS_UNKNOWN)
        c->busy_since_ns = ttf_clock_now_ns(c->box->clock);
    ttf_clock_charge(c->box->clock, TTF_WORK_DEVELOP, 1);
    if (!power_lost(c)) {
        if (!c->writer)
            (void)catch_up(c, NULL); /* the image itself will tell whether it helped */
        print_image(c, job);
        if (c->rehearsal)
            ttf_rehearsal_image(c->rehearsal, job->shot, job->raw,
                                &job->slot->record.images[job->image]);
    }
    ttf_queue_give_raw(c->queue, job->raw);
}

/* ---- slots ---- */

static void give_up(struct ttf_committer *c, int code, const struct ttf_err *err)
{
    int told = code == -ENOSPC || code == -EROFS || code == -TTF_EDAMAGED ? code : -EIO;

    ttf_queue_tell_fatal(c->queue, told, err);
}

/* One more slot without a record: is this going to pass? */
static bool lasting(struct ttf_committer *c)
{
    int64_t now = ttf_clock_now_ns(c->box->clock);

    if (c->strikes++ == 0)
        c->first_strike_ns = now;
    return c->n_pending >= TTF_COMMIT_PENDING ||
           (c->strikes >= TTF_COMMIT_STRIKES && now - c->first_strike_ns >= TTF_COMMIT_PATIENCE_NS);
}

static void do_slot(struct ttf_committer *c, struct ttf_slot_work *work)
{
    struct ttf_err err = {0};
    int r;

    ttf_ledger_judge(&work->record);
    if (work->record.n_images > 0)
        ttf_clock_charge(c->box->clock, TTF_WORK_COMMIT, 1);
    if (power_lost(c) || ttf_queue_fatal(c->queue) < 0) {
        ttf_slot_work_free(work);
        return;
    }
    append(c, work);
    r = flush(c, &err);
    c->busy_since_ns = TTF_NS_UNKNOWN;
    if (r == 0) {
        c->strikes = 0;
        write_late_lines(c);
        look_at_space(c);
        return;
    }
    if (power_lost(c))
        return;
    if (lasting(c) || r == -EROFS || r == -TTF_EDAMAGED)
        give_up(c, r, &err);
}

/* ---- the rest ---- */

static void do_event(struct ttf_committer *c, const struct ttf_job *job)
{
    struct ttf_progress p = {.kind = TTF_PROGRESS_EVENT,
                             .index = c->ledger.next_index,
                             .total = c->total,
                             .text = job->text,
                             .now_ns = job->at_ns,
                             .error_ns = TTF_NS_UNKNOWN,
                             .wakeup_ns = TTF_NS_UNKNOWN};

    /* In order: one that cannot be written now waits, and those after it. */
    if ((c->n_late > 0 || write_event(c, job) < 0) && c->n_late < TTF_COMMIT_LATE_EVENTS) {
        struct ttf_job *copy = ttf_job_new(TTF_JOB_EVENT);

        if (copy) {
            *copy = *job;
            c->late[c->n_late++] = copy;
        }
    }
    ttf_committer_tell(c, &p);
}

static void do_segment(struct ttf_committer *c, const struct ttf_job *job)
{
    if (c->writer && ttf_writer_segment(c->writer, &job->segment, NULL) == 0)
        return;
    c->segment = job->segment; /* the newest says all */
    c->has_segment = true;
}

static void do_job(struct ttf_committer *c, struct ttf_job *job)
{
    bool dark = power_lost(c);

    switch (job->kind) {
    case TTF_JOB_IMAGE:
        do_image(c, job);
        break;
    case TTF_JOB_SLOT:
        do_slot(c, job->slot);
        break;
    case TTF_JOB_EVENT:
        if (!dark)
            do_event(c, job);
        break;
    case TTF_JOB_SEGMENT:
        if (!dark)
            do_segment(c, job);
        break;
    case TTF_JOB_QUIT:
        break;
    }
}

static void *run(void *arg)
{
    struct ttf_committer *c = arg;
    struct ttf_clock *clock = c->box->clock;
    bool quit = false;

    while (!quit) {
        struct ttf_job *job = ttf_queue_pop(c->queue);

        quit = job->kind == TTF_JOB_QUIT;
        do_job(c, job);
        ttf_job_free(job);
    }
    /* The last chance of records that wait for their storage. */
    if (!power_lost(c) && (c->pending || c->n_late > 0 || c->has_segment))
        (void)catch_up(c, NULL);
    while (c->pending)
        drop_first(c);
    for (unsigned i = 0; i < c->n_late; i++)
        ttf_job_free(c->late[i]);
    c->n_late = 0;
    ttf_gate_open(c->queue->done);
    ttf_clock_leave(clock);
    return NULL;
}

int ttf_committer_begin(struct ttf_committer *committer)
{
    int r;

    committer->busy_since_ns = TTF_NS_UNKNOWN;
    if (pthread_mutex_init(&committer->progress_mutex, NULL))
        return -ENOMEM;
    ttf_clock_join_for(committer->box->clock);
    r = pthread_create(&committer->thread, NULL, run, committer);
    if (r) {
        ttf_clock_leave(committer->box->clock);
        pthread_mutex_destroy(&committer->progress_mutex);
        return -r;
    }
    committer->running = true;
    return 0;
}

void ttf_committer_end(struct ttf_committer *committer)
{
    struct ttf_job *job;

    if (!committer->running)
        return;
    job = ttf_job_new(TTF_JOB_QUIT);
    while (!job) { /* nothing can be ended without it: memory comes back as the committer works */
        (void)ttf_clock_wait_until(committer->box->clock,
                                   ttf_clock_now_ns(committer->box->clock) + TTF_NS_PER_MS);
        job = ttf_job_new(TTF_JOB_QUIT);
    }
    ttf_queue_push(committer->queue, job);
    while (ttf_gate_wait(committer->queue->done, TTF_NS_NEVER) < 0)
        ;
    pthread_join(committer->thread, NULL);
    pthread_mutex_destroy(&committer->progress_mutex);
    committer->running = false;
}
