/* SPDX-License-Identifier: Apache-2.0 */
/*
 * resume.h: where a run's grid lies on this boot's clock, for a new dataset and
 * for one that is gone on with. Pure: README.md, "Resuming".
 */
#ifndef TTF_CAPTURE_PRIVATE_RESUME_H
#define TTF_CAPTURE_PRIVATE_RESUME_H

#include <stdbool.h>

#include "plan_end.h"
#include "schedule.h"
#include "timeline.h"
#include "ttf/base/err.h"
#include "ttf/capture/session.h"
#include "ttf/dataset/writer.h"
#include "ttf/hal/clock.h"

struct ttf_resume_input {
    const struct ttf_writer_state *state; /* n_segments 0: a new dataset */
    const char *boot_id;
    struct ttf_utc utc;
    int64_t now_ns;
    int64_t ready_ns; /* earliest due time that can still be met; not before now_ns */
    const struct ttf_plan *plan;
    int64_t start_utc_ns;
    bool same_plan;     /* the one of the last segment */
    int64_t elapsed_ns; /* the run's own time at the first slot without a record (timeline.h) */
    struct ttf_run_past past; /* of a run that is gone on with */
    struct ttf_absence absence;
};

struct ttf_resume {
    struct ttf_grid grid; /* of the new segment: its first_index is the first without a record */
    struct ttf_run_clock clock; /* by which the plan ends */
    int64_t count;              /* slots that the plan comes to */
    int64_t lost_until;         /* slots first_index .. lost_until-1 cannot be captured any more */
    int64_t
        unready_from; /* those from here on are not due yet, but sooner than the box is ready (lamps settle): missed */
    enum ttf_result lost_result; /* of those before */
    const char *lost_reason;
    struct ttf_absence absence; /* what else is known of them; zeroed: nothing */
    int64_t gap_ns;             /* of the segment: time that no index stands for; TTF_NS_UNKNOWN */
    bool continued;             /* not a new dataset */
    bool on_grid;               /* the grid of before the interruption was kept */
    bool end_passed;            /* the plan's end is known to have come before the last slot */
    bool clock_implausible; /* UTC is vouched for then and now, but the grid is not kept by it */
    bool pc_gives_up;   /* why: a PC's word would leave no slot. The end does not go by it either */
    bool waits_in_vain; /* why: the next slot would be too far off */
    int64_t outage_ns;  /* from when the last slot that was taken was due to now; TTF_NS_UNKNOWN */
    struct ttf_outage outage; /* for the run's time */
};

/* -EINVAL: a start time with a clock nobody vouches for. */
TTF_MUST_USE int ttf_resume_resolve(const struct ttf_resume_input *in, struct ttf_resume *ret,
                                    struct ttf_err *err);

/*
 * How much earlier than the last slot taken in a boot before a clock may be: some seconds, one in so many of the run so
 * far (the system clock ran free, and the RTC chip by itself), and what both say of their own uncertainty. One of the
 * same trust by more: nothing says which of the two was wrong, and a right one that is refused costs the boot its UTC.
 */
#define TTF_BEHIND_NS      (10 * TTF_NS_PER_S)
#define TTF_BEHIND_DRIFT   10000 /* 100 ppm */
#define TTF_BEHIND_SAME_NS (15 * TTF_NS_PER_MIN)

/*
 * Whether a clock stands before the last slot that was taken in a boot before, by more than that: not believed, unless
 * it is vouched for better than that slot's was. Of the instant that it is told at: with time it comes past that slot.
 */
bool ttf_resume_clock_behind(const struct ttf_run_past *past, const struct ttf_utc *utc);

/*
 * What is believed of UTC when a run is gone on with: the present, unless it is behind as above; or a better clock that
 * a run before this one in this boot knew. Label, grid and end go by it, and by no other.
 */
struct ttf_utc ttf_resume_utc(const struct ttf_run_past *past, const struct ttf_utc *now);

/* Why that slot, of those that are lost, has no picture, and what its record says it is. */
const char *ttf_resume_lost(const struct ttf_resume *resume, int64_t index,
                            enum ttf_result *ret_result);

/*
 * The gap of a segment that began with a clock nobody vouched for, now that UTC
 * of its origin is known: from where `before` would have had the slot due. 0: it came at once, before that.
 * TTF_NS_UNKNOWN where it lies before the slot before it: of two clocks one is wrong, and tells no outage.
 */
int64_t ttf_resume_gap_ns(const struct ttf_segment *before, int64_t first_index,
                          int64_t origin_utc_ns);

#endif
