/* SPDX-License-Identifier: Apache-2.0 */
#include "commit_storage.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "commit_place.h"
#include "image_flags.h"
#include "plan_change.h"

bool ttf_storage_may_pass(int code)
{
    return code == -EIO || code == -ENOSPC || code == -EDQUOT || code == -ENOMEM || code == -EINTR;
}

bool ttf_committer_power_lost(struct ttf_committer *c)
{
    if (!c->power_lost && c->box->power_lost)
        c->power_lost = c->box->power_lost(c->box->box_private) != 0;
    return c->power_lost;
}

/* Image files that opening the dataset anew may have cleared away are taken from a record not yet written. */
void ttf_committer_drop_lost_files(struct ttf_committer *c, struct ttf_slot_record *record)
{
    char path[4096];

    for (unsigned i = 0; i < record->n_images; i++) {
        struct ttf_image *image = &record->images[i];
        unsigned kept = 0;

        if (image->n_files == 0) /* of a slot under way, it may be the loop's still */
            continue;
        for (unsigned f = 0; f < image->n_files; f++) {
            struct ttf_io_stat st;

            snprintf(path, sizeof(path), "%s/%s", c->path, image->files[f].path);
            if (c->io->ops->stat(c->io, path, &st) == 0 && st.bytes == image->files[f].bytes)
                image->files[kept++] = image->files[f];
            else
                ttf_image_flag(image, strcmp(image->files[f].role, "raw") == 0 ? "raw-lost"
                                                                               : "developed-lost");
        }
        if (kept == 0)
            snprintf(image->lacking, sizeof(image->lacking), "%s", TTF_REASON_IO_ERROR);
        image->n_files = kept;
    }
}

/* After a write that failed nobody knows what is on the disk: open it anew, which repairs what it must. */
int ttf_committer_reopen(struct ttf_committer *c)
{
    struct ttf_writer *old = c->writer;
    struct ttf_err err = {0};
    int r;

    if (ttf_committer_place(c) == TTF_PLACE_OTHER)
        return -ESTALE; /* this run's records are none of it */
    c->writer = NULL;
    r = ttf_writer_open_anew(c->io, c->path, old, &c->doubt, &c->writer, &err);
    r = r == -ESTALE ? -EIO : r; /* as of a commit */
    if (r == 0)
        r = ttf_writer_reserve(c->writer, c->line_bytes, &err);
    c->away = r;
    if (r < 0) {
        ttf_writer_abandon(c->writer);
        c->writer = NULL;
        return r;
    }
    ttf_committer_note_place(c);
    for (struct ttf_slot_work *work = c->pending; work; work = work->next)
        ttf_committer_drop_lost_files(c, &work->record);
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
        .total = work->total,
        .result = (int)record->result,
        .text = record->reason,
        .now_ns = now,
        .error_ns = record->middle_ns == TTF_NS_UNKNOWN ? TTF_NS_UNKNOWN
                                                        : record->middle_ns - record->due_ns,
        .wakeup_ns = work->wakeup_ns,
    };

    c->total = work->total;
    if (work->wakeup_ns != TTF_NS_UNKNOWN)
        ttf_quantile_add(&c->ledger.wakeup, work->wakeup_ns);
    if (c->rehearsal && c->busy_since_ns != TTF_NS_UNKNOWN)
        ttf_rehearsal_slot(c->rehearsal, record, now - work->begun_ns, now - c->busy_since_ns);
    ttf_committer_tell(c, &p);
}

/* As it is now: its files may be others since it was handed over, and its dataset too. */
static int commit(struct ttf_committer *c, struct ttf_slot_record *record, struct ttf_err *err)
{
    struct ttf_slot_record numbered;
    int r;

    ttf_ledger_judge(record);
    numbered = *record;
    numbered.segment = ttf_committer_segment_number(c, record->segment);
    r = c->writer ? ttf_writer_commit(c->writer, &numbered, err) : -EIO;
    return r == -ESTALE ? -EIO
                        : r; /* a network's file system may say so, and means its own handles */
}

/* Writes one record. 0 once it is on the disk. */
static int write_record(struct ttf_committer *c, struct ttf_slot_record *record,
                        struct ttf_err *err)
{
    int r = ttf_committer_come_back(c, err);

    if (r == -ESTALE)
        return r;
    if (r == 0)
        r = commit(c, record, err);
    if (r == 0 || ttf_committer_power_lost(c))
        return r;
    /* Two tries have failed by now; opening it anew would clear away the slot's files, which can still be fetched. */
    if (c->second_path[0] && !c->moved && !c->second_failed)
        return r;
    r = ttf_committer_reopen(c);
    if (r < 0)
        return ttf_err_set(err, r, c->path, "the dataset cannot be opened anew");
    if (ttf_writer_state(c->writer)->next_index > record->index)
        return 0; /* it had got there after all */
    r = commit(c, record, err);
    if (r == 0)
        ttf_events_emit(c->events, "retry", "record of slot %lld needed a second try",
                        (long long)record->index);
    return r;
}

void ttf_committer_drop_first(struct ttf_committer *c)
{
    struct ttf_slot_work *work = c->pending;

    c->pending = work->next;
    if (!c->pending)
        c->pending_tail = NULL;
    c->n_pending--;
    ttf_stock_give_slot(&c->queue->stock, work);
}

void ttf_committer_keep(struct ttf_committer *c, struct ttf_slot_work *work)
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
int ttf_committer_flush(struct ttf_committer *c, struct ttf_err *err)
{
    while (c->pending) {
        struct ttf_slot_work *work = c->pending;
        bool slot = !work->change;
        int r = slot ? write_record(c, &work->record, err)
                     : ttf_committer_write_change(c, &work->change, err);

        if (r < 0)
            return r;
        if (slot && ttf_ledger_add(&c->ledger, &work->record) == 0)
            acknowledge(c, work);
        ttf_committer_drop_first(c);
    }
    return 0;
}

int ttf_committer_write_event(struct ttf_committer *c, const struct ttf_job *event)
{
    if (!c->writer)
        return -EIO;
    return ttf_writer_event(c->writer, event->event, event->at_ns, event->at_utc_ns, event->text,
                            NULL, NULL);
}

int ttf_committer_say(struct ttf_committer *c, struct ttf_writer *writer, const char *text,
                      const char *detail_json)
{
    struct ttf_utc utc;

    ttf_clock_utc(c->box->clock, &utc);
    return ttf_writer_event(writer, "storage", utc.boot_ns,
                            utc.trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : utc.utc_ns, text,
                            detail_json, NULL);
}

void ttf_committer_write_late(struct ttf_committer *c)
{
    while (c->n_late_segments > 0 &&
           ttf_committer_write_correction(c, &c->late_segments[c->n_late_segments - 1]) == 0)
        c->n_late_segments--;
    while (c->late.n > 0 && ttf_committer_write_event(c, &c->late.wait[0]) == 0)
        ttf_late_events_drop_first(&c->late);
}

/* What waits for a storage that was away. 0 once all records are written. */
int ttf_committer_catch_up(struct ttf_committer *c, struct ttf_err *err)
{
    int r = c->writer ? 0 : ttf_committer_reopen(c);

    if (r == 0)
        r = ttf_committer_flush(c, err);
    if (r == 0)
        ttf_committer_write_late(c);
    return r;
}
