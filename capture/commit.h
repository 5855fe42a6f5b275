/* SPDX-License-Identifier: Apache-2.0 */
/*
 * commit.h: the committer: the one thread that writes to the dataset while a run
 * is under way. Storage that fails for a while costs slots, never the run: see
 * README.md.
 */
#ifndef TTF_CAPTURE_PRIVATE_COMMIT_H
#define TTF_CAPTURE_PRIVATE_COMMIT_H

#include "events.h"
#include "focus_watch.h"
#include "image_files.h"
#include "late_events.h"
#include "ledger.h"
#include "pulse.h"
#include "rehearsal.h"
#include "ttf/capture/session.h"

/* The run stops when so many slots on end could not be recorded, over at least so long. */
#define TTF_COMMIT_STRIKES     3
#define TTF_COMMIT_PATIENCE_NS TTF_NS_PER_MIN

/* Records that wait for a storage that is away: a minute's at ten a second, and some. */
#define TTF_COMMIT_PENDING 1024

/* Whether what a storage answers is worth waiting for: an error, no room (or quota), no memory, a signal. */
bool ttf_storage_may_pass(int code);

struct ttf_committer {
    /* set before begin, borrowed */
    struct ttf_box *box;
    struct ttf_queue *queue;
    struct ttf_events *events;
    struct ttf_io *io;
    const char *path;
    char second_path[4096];  /* of the dataset in the second storage; empty: none */
    char calibration_id[64]; /* empty: none */
    const char *calibration_folder;
    const struct ttf_plan *given; /* to the session; another may be in force */
    const char *given_yaml;       /* NULL: not known */
    struct ttf_manifest manifest; /* of the dataset the run began in */
    int64_t reserve_bytes, slot_bytes, total;
    size_t line_bytes; /* of a record, at the most: the writer is made to hold it */
    struct ttf_darkroom *rooms[TTF_PLAN_SHOTS_MAX];   /* of each shot of the plan */
    struct ttf_rehearsal *rehearsal;                  /* NULL: none */
    struct ttf_focus_watch focus[TTF_PLAN_SHOTS_MAX]; /* of each shot; the committer's own */
    ttf_progress_fn *progress;
    void *progress_ctx;
    struct ttf_control *control; /* for answers; NULL allowed */
    /* the committer's until join */
    uint64_t device, inode;    /* of the dataset's folder (commit_place.h); 0: not known */
    char uuid[37];             /* its own */
    bool doubt;                /* a sync failed, and the dataset was not opened anew since */
    struct ttf_writer *writer; /* NULL while the dataset cannot be opened; owned by the session */
    int away;                  /* why it cannot */
    struct ttf_ledger ledger;
    /* the plan and segment in force on the disk, by the session's numbers; NULL before there is one; owned */
    struct ttf_plan_change *in_force;
    /* what the session's numbers are ahead of the dataset's, once it goes on in a second one; of plans perhaps behind */
    int segment_base, plan_base;
    int64_t slot0_ns; /* set before begin: where the run's slot 0 was, or would have been, due */
    const struct ttf_run_past *past; /* likewise: what the segments before said of its time */
    struct ttf_outage outage;        /* likewise: before this session */
    int n_plans;                     /* by the session's numbers, written so far */
    bool moved;                      /* to the second storage */
    struct ttf_segment continued;    /* the first one there, if it was begun by this session */
    bool has_continued;
    bool
        from_first; /* set before begin: this session begins the second one, by reading the first */
    bool second_failed; /* it was tried, and told */
    bool calibration_lost;
    struct ttf_slot_work *pending, *pending_tail; /* records that could not be written yet */
    unsigned n_pending;
    struct ttf_late_events late; /* events that could not be written yet */
    /* corrections that could not be written yet, one of a segment */
    struct ttf_segment late_segments[TTF_PULSE_EARLIER + 1];
    unsigned n_late_segments;
    unsigned strikes;
    int64_t first_strike_ns;
    bool disk_full, disk_noted;
    /* images of the slot under way: files were written; the storage took none of one */
    bool image_stored, image_refused;
    unsigned image_strikes; /* slots on end with such an image */
    int64_t first_image_strike_ns;
    bool images_alarm, images_noted;
    int64_t fs_errors; /* of the storage in use, at the last look */
    bool fs_errors_noted;
    bool power_lost;
    int64_t busy_since_ns;          /* first image of the slot under way; TTF_NS_UNKNOWN */
    pthread_mutex_t progress_mutex; /* the session's: it tells before begin and after end, too */
    pthread_t thread;
    bool running;
};

/* Starts the thread. The caller has joined the clock. Negative errno. */
TTF_MUST_USE int ttf_committer_begin(struct ttf_committer *committer);

/* Lets it finish what is queued, and ends it; until then the pulse beats on. The caller has joined the clock. */
void ttf_committer_end(struct ttf_committer *committer, struct ttf_pulse *pulse);

/* Tells the watcher; any thread, one at a time. */
void ttf_committer_tell(struct ttf_committer *committer, const struct ttf_progress *progress);

/* Tells it that a person is needed (TTF_PROGRESS_ALARM). */
void ttf_committer_alarm(struct ttf_committer *committer, enum ttf_alarm_until until,
                         const char *text);

#endif
