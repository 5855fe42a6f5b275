/* SPDX-License-Identifier: Apache-2.0 */
/*
 * timeline.h: a run's own time over its segments: what a photoperiod counts in. From slot 0 on; within a
 * boot by its clock, over a boot by slots, so that an outage of unknown length counts as none.
 * Pure, but for ttf_timeline_read.
 */
#ifndef TTF_CAPTURE_PRIVATE_TIMELINE_H
#define TTF_CAPTURE_PRIVATE_TIMELINE_H

#include "ttf/base/attr.h"
#include "ttf/dataset/reader.h"
#include "ttf/hal/clock.h"

/* Who vouched for a segment's UTC: a name that is not known is worth as much as none. */
enum ttf_trust ttf_segment_trust(const struct ttf_segment *segment);

/* Whether it has a UTC that can be reckoned with: from 1933 to 2116. */
bool ttf_segment_has_utc(const struct ttf_segment *segment);

/* Time from where slot 0 was, or would have been, due to where the last of n segments begins. */
int64_t ttf_timeline_elapsed_ns(const struct ttf_segment *segments, int n);

/* What the first segment of a dataset that goes on with a run says of the run's time: 0 where it goes without saying. */
int64_t ttf_timeline_run_ns(const struct ttf_segment *segment, int64_t slot0_ns);

struct ttf_run_past;

/* What lies between the last record of before and the present segment. */
struct ttf_outage {
    bool gap_unknown;    /* of unknown length, and no slot stands for it */
    int64_t given_up_ns; /* what slots stand for that were due before this boot */
};

/*
 * The same of UTC: when slot 0 was due, by what the segments before and this one's UTC say now, less the outages that
 * no slot stands for; 0 where nobody knows. slot0_ns: where it was, or would have been, due on this boot's clock.
 * To be said anew when that UTC is corrected: what it is then later by is no outage.
 */
void ttf_timeline_run_utc(struct ttf_segment *segment, const struct ttf_run_past *past,
                          int64_t slot0_ns, const struct ttf_outage *outage);

/*
 * Of so many slots of a segment that begins there on a new boot's clock, those that were due before that boot: given up
 * as lost to the outage, by what two clocks say of it. A boot clock starts near 0.
 */
int64_t ttf_timeline_given_up_ns(int64_t origin_ns, int64_t interval_ns, int64_t slots);

/* UTC of slot 0, by the last of n segments that knows; TTF_NS_UNKNOWN. */
int64_t ttf_timeline_slot0_utc_ns(const struct ttf_segment *segments, int n);

/* What the segments of a run say of its time, for its end. */
struct ttf_run_past {
    int64_t gaps_ns;      /* outages that no slot stands for, as far as their lengths are known */
    int64_t slot0_utc_ns; /* as ttf_timeline_slot0_utc_ns */
    bool open; /* outages of unknown length lie behind the segment that slot0_utc_ns is of */
    /* Without what a PC's word alone says. The gaps are less by slots that were given up and are no time of the run. */
    int64_t sure_gaps_ns, sure_slot0_utc_ns;
    bool sure_open;
    enum ttf_trust sure_trust; /* who says that UTC of slot 0 */
    /* Slots given up since the last of such clocks spoke, no time of the run so far; those of before, which one may take back. */
    int64_t sure_doubted_ns, sure_given_up_ns;
    /* UTC - boot clock by the clock trusted most in this boot so far, the last of such; NONE: no run in it knew. */
    enum ttf_trust boot_trust;
    int64_t boot_offset_ns, boot_uncertainty_ns;
    bool
        behind_outage; /* this boot is not the first segment's: slots due before it were lost to an outage */
    /* UTC of the last slot taken before this boot, as far as segments know, and who says so; a PC where nobody else does. */
    enum ttf_trust last_trust;
    int64_t last_utc_ns, last_uncertainty_ns;
    int64_t last_run_ns; /* its own time, by then */
    /*
     * It is of the dataset that the run moved on from, which says nothing of whether it was taken or given up while lamps
     * settled: so long before it was due it may have been recorded (whoever knows the plan says how long).
     */
    bool last_moved;
    int64_t last_ahead_ns;
};

/* boot_id: the present one; taken_until: of each segment, as ttf_timeline_read has it; next_index: without a record. */
struct ttf_run_past ttf_timeline_past(const struct ttf_segment *segments,
                                      const int64_t *taken_until, int n, int64_t next_index,
                                      const char *boot_id);

/*
 * What a length ends earlier by than its slots say: outages that no slot stands for, less slots that stand for no
 * outage, as far as two clocks of the box's own (rtc, ntp) tell them; what a PC says on either side tells none. Now
 * that the present segment's clock says that slot 0 was due at that UTC (TTF_NS_UNKNOWN: nobody says so): outages of
 * unknown length are what it lies later by than was known before, and slots given up by a clock ahead what it lies
 * earlier by. Of the segment interval and trust are read.
 */
int64_t ttf_timeline_gaps_ns(const struct ttf_run_past *past, const struct ttf_segment *segment,
                             const struct ttf_outage *outage, int64_t slot0_utc_ns);

/*
 * The segments of a dataset in order, as corrected, and of each one more than its last slot that was not lost (`power`,
 * `missed`: those may have been recorded before they were due), its first index where there is none. To be freed.
 * *ret_n may be 0, the others NULL then. -EINVAL: times that no clock can have shown (a foreign dataset's); what is
 * returned can be reckoned with, as UTC, uncertainty and gap of such are unknown in it.
 */
TTF_MUST_USE int ttf_timeline_read(struct ttf_io *io, const char *path, struct ttf_segment **ret,
                                   int64_t **ret_taken_until, int *ret_n, struct ttf_err *err);

#endif
