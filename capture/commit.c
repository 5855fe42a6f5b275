/* SPDX-License-Identifier: Apache-2.0 */
#include "commit.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "asks.h"
#include "commit_place.h"
#include "commit_storage.h"
#include "image_flags.h"
#include "previews.h"
#include "ttf/capture/note.h"

/* Removed so far ahead of the reserve that it need not be done anew for each slot. */
#define PREVIEW_SLOTS 8

void ttf_committer_tell(struct ttf_committer *committer, const struct ttf_progress *progress)
{
    if (!committer->progress)
        return;
    pthread_mutex_lock(&committer->progress_mutex);
    committer->progress(committer->progress_ctx, progress);
    pthread_mutex_unlock(&committer->progress_mutex);
}

static void tell_alarm(struct ttf_committer *committer, enum ttf_progress_kind kind,
                       enum ttf_alarm_until until, const char *text)
{
    struct ttf_progress p = {.kind = kind,
                             .until = until,
                             .index = committer->ledger.next_index,
                             .total = committer->total,
                             .text = text,
                             .now_ns = ttf_clock_now_ns(committer->box->clock),
                             .error_ns = TTF_NS_UNKNOWN,
                             .wakeup_ns = TTF_NS_UNKNOWN};

    ttf_committer_tell(committer, &p);
}

void ttf_committer_alarm(struct ttf_committer *committer, enum ttf_alarm_until until,
                         const char *text)
{
    tell_alarm(committer, TTF_PROGRESS_ALARM, until, text);
}

/* ---- room on the disk ---- */

static bool full(int r)
{
    return r == -ENOSPC || r == -EDQUOT;
}

static const char *storage_reason(int r)
{
    if (r == -EROFS)
        return TTF_REASON_READ_ONLY;
    return full(r) ? TTF_REASON_DISK_FULL
                   : (r == -ENOMEM ? TTF_REASON_NO_MEMORY : TTF_REASON_IO_ERROR);
}

void ttf_committer_note_disk(struct ttf_committer *c, bool full)
{
    if (full != c->disk_full)
        ttf_events_emit(c->events, "disk",
                        full ? "less room than the reserve: no slot is captured"
                             : "there is room again");
    /* The first look of a run tells in any case: the alarm of a run before may stand. */
    if (full != c->disk_full || !c->disk_noted)
        tell_alarm(c, full ? TTF_PROGRESS_ALARM : TTF_PROGRESS_ALARM_OVER, TTF_ALARM_UNTIL_OVER,
                   TTF_REASON_DISK_FULL
                   ", less room than the reserve: no slot is captured until there is more");
    c->disk_full = full;
    c->disk_noted = true;
    ttf_queue_tell_disk(c->queue, full);
}

/*
 * What the file system has found in itself: slots are still safe, but the disk may be about to go. As above the first
 * look of a run tells in any case; a move to another storage begins anew with none.
 */
static void note_fs_errors(struct ttf_committer *c, int64_t errors)
{
    static const char TEXT[] =
        "the storage's file system has found errors in itself: copy what matters, then check it "
        "(fsck); a card or disk may be wearing out";

    if (errors > c->fs_errors)
        ttf_events_emit(c->events, "storage",
                        "the file system has found errors in itself, %lld since it was last "
                        "checked: the card or disk may be wearing out",
                        (long long)errors);
    if (errors > c->fs_errors || (errors == 0 && !c->fs_errors_noted))
        tell_alarm(c, errors > 0 ? TTF_PROGRESS_ALARM : TTF_PROGRESS_ALARM_OVER,
                   TTF_ALARM_UNTIL_OVER, TEXT);
    c->fs_errors = errors;
    c->fs_errors_noted = true;
}

/*
 * A storage may take records and no images (no inodes are left, blocks are bad): every slot fails, and nothing ends the
 * run. After as many slots and as long as for records it is an alarm, until one slot has all its images. As above the
 * first such slot of a run tells in any case. After each record.
 */
static void note_images(struct ttf_committer *c)
{
    static const char TEXT[] = "no images can be stored: slots fail, one after another, until the "
                               "storage takes files again";
    int64_t now = ttf_clock_now_ns(c->box->clock);
    bool refused = c->image_refused;
    bool stored = c->image_stored && !refused;

    c->image_refused = c->image_stored = false;
    if (refused && c->image_strikes++ == 0)
        c->first_image_strike_ns = now;
    if (refused && !c->images_alarm && c->image_strikes >= TTF_COMMIT_STRIKES &&
        now - c->first_image_strike_ns >= TTF_COMMIT_PATIENCE_NS) {
        ttf_events_emit(c->events, "disk", "no images can be stored, %u slots on end",
                        c->image_strikes);
        tell_alarm(c, TTF_PROGRESS_ALARM, TTF_ALARM_UNTIL_OVER, TEXT);
        c->images_alarm = true;
    }
    if (!stored)
        return;
    if (c->images_alarm)
        ttf_events_emit(c->events, "disk", "images are stored again");
    if (c->images_alarm || !c->images_noted)
        tell_alarm(c, TTF_PROGRESS_ALARM_OVER, TTF_ALARM_UNTIL_OVER, TEXT);
    c->image_strikes = 0;
    c->images_alarm = false;
    c->images_noted = true;
}

/* Previews go first. True if that made room. */
static bool drop_previews(struct ttf_committer *c, int64_t free_bytes)
{
    unsigned n = ttf_previews_remove(c->io, c->path, free_bytes);

    if (n > 0)
        ttf_events_emit(c->events, "disk", "%u files of preview/ were removed to make room", n);
    return n > 0;
}

static void look_at_space(struct ttf_committer *c)
{
    struct ttf_io_space space;
    int64_t needs = c->reserve_bytes + c->slot_bytes;

    if (!c->writer || ttf_writer_space(c->writer, &space) < 0)
        return;
    note_fs_errors(c, space.fs_errors);
    if (space.free_bytes < needs + c->slot_bytes &&
        drop_previews(c, needs + PREVIEW_SLOTS * c->slot_bytes) &&
        ttf_writer_space(c->writer, &space) < 0)
        return;
    if (space.free_bytes < needs && ttf_committer_move(c, "less room than the reserve", NULL) == 0)
        return;
    ttf_committer_note_disk(c, space.free_bytes < needs);
}

/* ---- images ---- */

/* Writes one file; an error that may pass is tried once more. */
static int try_file(struct ttf_committer *c, struct ttf_darkroom *room, const char *role,
                    const struct ttf_print *print)
{
    struct ttf_err err = {0};
    int r;

    if (!c->writer)
        return c->away < 0 ? c->away : -EIO;
    if (ttf_committer_place(c) == TTF_PLACE_GONE)
        return -EIO; /* its folders would be made anew, and be in the way of the next run */
    r = ttf_darkroom_print(room, c->writer, role, print, &err);
    if (r == 0 || full(r) || r == -EROFS || ttf_committer_power_lost(c))
        return r;
    ttf_events_emit(c->events, "retry", "%s file of slot %lld is written again: %s", role,
                    (long long)print->index, err.what);
    return ttf_darkroom_print(room, c->writer, role, print, &err);
}

/* The frame is still in memory: what has failed here for good is written to the second storage. */
static int print_file(struct ttf_committer *c, struct ttf_darkroom *room, const char *role,
                      const struct ttf_print *print, struct ttf_slot_work *work)
{
    int r = try_file(c, room, role, print);

    if (r == 0 || r == -ENOMEM || ttf_committer_power_lost(c))
        return r;
    if (full(r) && drop_previews(c, c->reserve_bytes + PREVIEW_SLOTS * c->slot_bytes))
        r = try_file(c, room, role, print);
    if (r < 0 && ttf_committer_move(c, storage_reason(r), work) == 0)
        r = try_file(c, room, role, print);
    return r;
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
        raw = print_file(c, room, "raw", &print, job->slot);
    if (room->keep != TTF_KEEP_RAW && !ttf_committer_power_lost(c))
        developed = print_file(c, room, "developed", &print, job->slot);
    if (ttf_committer_power_lost(c))
        return;
    c->image_stored |= image->n_files > 0;
    c->image_refused |= image->n_files == 0 && raw != -ENOMEM && developed != -ENOMEM;
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

/* Nothing more can be recorded: an event where the storage takes one, and the watcher is told. */
static void give_up(struct ttf_committer *c, int code, const struct ttf_err *err);

/*
 * An event or a correction that failed leaves a writer that takes nothing more. Opening anew clears away files
 * without a record, so it comes before the slot's first one, not between its files and its record.
 * So also of a dataset whose disk came back: images go there by their path.
 */
static void open_for_slot(struct ttf_committer *c, const struct ttf_slot_record *record)
{
    if (!c->writer || c->pending ||
        (!ttf_writer_broken(c->writer) && ttf_committer_place(c) != TTF_PLACE_BACK))
        return;
    for (unsigned i = 0; i < record->n_images; i++)
        if (record->images[i].n_files > 0)
            return;
    if (ttf_committer_reopen(c) < 0)
        return; /* the files' own tries go on from there */
}

/* Of a bracket the image at the plan's exposure; and none that is told to be unlike the others. */
static void watch_focus(struct ttf_committer *c, unsigned shot, const struct ttf_image *image)
{
    double fall;

    if ((image->bracket >= 0 && image->relative_exposure != 1.0) || image->flags[0] != 0)
        return;
    if (ttf_focus_watch_look(&c->focus[shot], image->sharpness, &fall))
        ttf_events_emit(c->events, "focus",
                        "stream %s has lost %.0f %% of its sharpness: look at lens and sample",
                        image->stream, 100 * fall);
}

/* Looked at before each image: its file would be written there. */
static bool another_lies_there(struct ttf_committer *c)
{
    struct ttf_err err = {0};

    if (ttf_committer_power_lost(c) || ttf_committer_place(c) != TTF_PLACE_OTHER)
        return false;
    give_up(c, ttf_committer_come_back(c, &err), &err);
    return true;
}

static void do_image(struct ttf_committer *c, struct ttf_job *job)
{
    if (c->busy_since_ns == TTF_NS_UNKNOWN)
        c->busy_since_ns = ttf_clock_now_ns(c->box->clock);
    if (another_lies_there(c)) {
        ttf_queue_give_raw(c->queue, job->raw);
        return;
    }
    open_for_slot(c, &job->slot->record);
    ttf_clock_charge(c->box->clock, TTF_WORK_DEVELOP, 1);
    if (!ttf_committer_power_lost(c)) {
        if (!c->writer)
            (void)ttf_committer_catch_up(c,
                                         NULL); /* the image itself will tell whether it helped */
        print_image(c, job);
        watch_focus(c, job->shot, &job->slot->record.images[job->image]);
        if (c->rehearsal)
            ttf_rehearsal_image(c->rehearsal, job->shot, job->raw,
                                &job->slot->record.images[job->image]);
    }
    ttf_queue_give_raw(c->queue, job->raw);
}

/* ---- slots ---- */

static void put_why(const struct ttf_committer *c, int told, char ret[256])
{
    const char *second = "and the plan names no second storage";

    if (told == -ESTALE) {
        snprintf(ret, 256, "%s", TTF_PLACE_ALARM);
        return;
    }
    if (c->second_path[0])
        second = c->moved ? "in the second storage too" : "and the second storage cannot be used";
    snprintf(ret, 256, "%s, %s: the run ends; nothing that was committed is lost",
             storage_reason(told), second);
}

static void give_up(struct ttf_committer *c, int code, const struct ttf_err *err)
{
    const bool is_said = full(code) || code == -EROFS || code == -TTF_EDAMAGED || code == -ESTALE;
    int told = is_said ? code : -EIO;
    char text[256];

    if (ttf_queue_fatal(c->queue) < 0)
        return; /* told before */
    put_why(c, told, text);
    if (c->writer)
        (void)ttf_committer_say(c, c->writer, text, NULL);
    ttf_committer_alarm(c, TTF_ALARM_UNTIL_ARMED, text);
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

/* Writes what waits, in the second storage if this one takes it no more. */
static int flush(struct ttf_committer *c, struct ttf_err *err)
{
    int r = ttf_committer_flush(c, err);

    if (full(r) && drop_previews(c, c->reserve_bytes))
        r = ttf_committer_flush(c, err);
    if (r == 0 || r == -ENOMEM || r == -EINVAL || ttf_committer_power_lost(c))
        return r;
    /* There, or, if that one fails as well, here once more, opened anew. */
    if (ttf_committer_move(c, storage_reason(r), NULL) != -ENOENT)
        r = ttf_committer_flush(c, err);
    return r;
}

/*
 * A supply that sagged may have moved anything: light, exposure, pixels. Its reading is the slot's, taken behind the last
 * exposure; whoever looks at images alone finds it at each of them.
 */
static void flag_supply(struct ttf_slot_record *record)
{
    const char *kind = ttf_sensor_kind_name(TTF_SENSOR_UNDERVOLTAGE);
    bool low = false;

    for (unsigned i = 0; i < record->n_sensors; i++)
        low |= record->sensors[i].ok && record->sensors[i].value != 0 &&
               strcmp(record->sensors[i].kind, kind) == 0;
    for (unsigned i = 0; low && i < record->n_images; i++)
        if (record->images[i].n_files > 0)
            ttf_image_flag(&record->images[i], "under-voltage");
}

static void do_slot(struct ttf_committer *c, struct ttf_slot_work *work)
{
    struct ttf_err err = {0};
    int r;

    if (work->record.n_images > 0)
        ttf_clock_charge(c->box->clock, TTF_WORK_COMMIT, 1);
    if (ttf_committer_power_lost(c) || ttf_queue_fatal(c->queue) < 0) {
        ttf_stock_give_slot(&c->queue->stock, work);
        return;
    }
    flag_supply(&work->record);
    ttf_committer_keep(c, work);
    r = flush(c, &err);
    c->busy_since_ns = TTF_NS_UNKNOWN;
    if (r == 0) {
        c->strikes = 0;
        ttf_committer_write_late(c);
        note_images(c);
        look_at_space(c);
        return;
    }
    if (ttf_committer_power_lost(c))
        return;
    if (lasting(c) || r == -EROFS || r == -TTF_EDAMAGED || r == -ESTALE)
        give_up(c, r, &err);
}

/* ---- the rest ---- */

static void tell_event(struct ttf_committer *c, const struct ttf_job *job)
{
    struct ttf_progress p = {.kind = TTF_PROGRESS_EVENT,
                             .index = c->ledger.next_index,
                             .total = c->total,
                             .text = job->text,
                             .now_ns = job->at_ns,
                             .error_ns = TTF_NS_UNKNOWN,
                             .wakeup_ns = TTF_NS_UNKNOWN};

    ttf_committer_tell(c, &p);
}

/* In order: one that cannot be written now waits, and those after it. */
static void write_or_keep(struct ttf_committer *c, const struct ttf_job *job)
{
    if (c->late.n > 0 || ttf_committer_write_event(c, job) < 0)
        ttf_late_events_keep(&c->late, job);
}

/* Of those that the queue had no place for nobody has heard. */
static void tell_lost(struct ttf_committer *c, const struct ttf_lost *lost)
{
    struct ttf_job job;

    if (lost->n == 0)
        return;
    ttf_late_events_lost(&job, lost);
    write_or_keep(c, &job);
    tell_event(c, &job);
}

static void do_event(struct ttf_committer *c, const struct ttf_job *job)
{
    if (job->total > 0)
        ttf_committer_another_end(c, job->total);
    tell_lost(c, &job->lost_before);
    write_or_keep(c, job);
    tell_event(c, job);
}

static void do_segment(struct ttf_committer *c, const struct ttf_job *job)
{
    unsigned i;

    /* The newest of a segment says all that those before it did. */
    for (i = 0; i < c->n_late_segments; i++)
        if (c->late_segments[i].segment == job->segment.segment)
            break;
    if (ttf_committer_write_correction(c, &job->segment) == 0) {
        if (i < c->n_late_segments)
            c->late_segments[i] = c->late_segments[--c->n_late_segments];
        return;
    }
    if (i == TTF_PULSE_EARLIER + 1) {
        i--; /* the oldest segments go first out of the pulse's sight too */
        memmove(&c->late_segments[0], &c->late_segments[1], i * sizeof(c->late_segments[0]));
    }
    c->late_segments[i] = job->segment;
    if (i == c->n_late_segments)
        c->n_late_segments++;
}

static void do_note(struct ttf_committer *c, const struct ttf_job *job)
{
    struct ttf_err err = {0};
    int r = ttf_note_add(c->box->clock, c->io, c->path, job->note, &err);

    ttf_asks_answer(c->control, job->ask, r, &err);
}

static void do_job(struct ttf_committer *c, struct ttf_job *job)
{
    bool dark = ttf_committer_power_lost(c);

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
    case TTF_JOB_NOTE:
        if (!dark)
            do_note(c, job);
        break;
    case TTF_JOB_QUIT:
        break;
    }
}

/* Records that still wait for their storage at the end have as long as during the run; without them it is no success. */
static void last_chance(struct ttf_committer *c)
{
    struct ttf_clock *clock = c->box->clock;
    int64_t until = ttf_clock_now_ns(clock) + TTF_COMMIT_PATIENCE_NS;
    struct ttf_err err = {0};
    int r = 0;

    if (ttf_committer_power_lost(c) || !(c->pending || c->late.n > 0 || c->n_late_segments > 0))
        return;
    r = ttf_committer_catch_up(c, &err);
    if (r < 0 && r != -ENOMEM && r != -EINVAL &&
        ttf_committer_move(c, storage_reason(r), NULL) != -ENOENT)
        r = ttf_committer_catch_up(c, &err); /* there, or here once more */
    while (ttf_storage_may_pass(r) && ttf_queue_fatal(c->queue) == 0 &&
           ttf_clock_now_ns(clock) < until) {
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + TTF_NS_PER_S);
        if (ttf_committer_power_lost(c))
            return;
        r = ttf_committer_catch_up(c, &err);
    }
    if (r < 0 && !ttf_committer_power_lost(c))
        give_up(c, r, &err);
}

/* What can be written is; of the others at least the watcher hears how many they are. */
static void last_events(struct ttf_committer *c)
{
    struct ttf_lost lost = ttf_queue_take_lost(c->queue);
    struct ttf_job job;

    tell_lost(c, &lost);
    ttf_committer_write_late(c);
    lost = ttf_late_events_all(&c->late);
    if (lost.n == 0)
        return;
    ttf_late_events_lost(&job, &lost);
    tell_event(c, &job);
}

/* The oldest job. True if it was the last. */
static bool do_next(struct ttf_committer *c)
{
    struct ttf_job *job = ttf_queue_pop(c->queue);
    bool quit = job->kind == TTF_JOB_QUIT;

    do_job(c, job);
    ttf_job_free(c->queue, job);
    return quit;
}

static void *run(void *arg)
{
    struct ttf_committer *c = arg;
    struct ttf_clock *clock = c->box->clock;
    bool quit = false;

    while (!quit)
        quit = do_next(c);
    last_chance(c);
    /* What the loop saw in the meantime: a clock that was set. */
    while (ttf_queue_length(c->queue) > 0)
        (void)do_next(c);
    if (!ttf_committer_power_lost(c))
        last_events(c);
    while (c->pending)
        ttf_committer_drop_first(c);
    c->late.n = 0;
    ttf_gate_open(c->queue->done);
    ttf_clock_leave(clock);
    return NULL;
}

int ttf_committer_begin(struct ttf_committer *committer)
{
    sigset_t all;
    sigset_t before;
    int r;

    committer->busy_since_ns = TTF_NS_UNKNOWN;
    ttf_committer_note_place(committer);
    ttf_clock_join_for(committer->box->clock);
    /* Signals are for the program's own threads; here they would only interrupt writing. */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    r = pthread_create(&committer->thread, NULL, run, committer);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (r) {
        ttf_clock_leave(committer->box->clock);
        return -r;
    }
    committer->running = true;
    return 0;
}

void ttf_committer_end(struct ttf_committer *committer, struct ttf_pulse *pulse)
{
    struct ttf_job *job;

    if (!committer->running)
        return;
    job = ttf_job_new(committer->queue, TTF_JOB_QUIT);
    if (job) /* there is one, for this */
        ttf_queue_push(committer->queue, job);
    /* The last slots may take as long as they do: the loop keeps an eye on clock and watchdog. */
    ttf_pulse_last_gate(pulse, committer->queue->done);
    pthread_join(committer->thread, NULL);
    committer->running = false;
}
