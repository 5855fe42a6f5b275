/* SPDX-License-Identifier: Apache-2.0 */
#include "timeline.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/checked.h"
#include "ttf/base/time.h"

/*
 * What can be reckoned with: runs of 146 years (a plan may take 100), and UTC until 2116. Two of such can be added up, and
 * what is between 1933 and then, and outages of 73 years, as well.
 */
#define TIME_MAX_NS (INT64_C(1) << 62)
#define UTC_MIN_NS  (-(INT64_C(1) << 60))
#define GAPS_MAX_NS (INT64_C(1) << 61)

/* From where `a` begins to where the segment behind it does. */
static int64_t step_ns(const struct ttf_segment *a, const struct ttf_segment *b)
{
    if (strcmp(a->boot_id, b->boot_id) == 0)
        return b->origin_ns - a->origin_ns;
    return (b->first_index - a->first_index) * a->interval_ns;
}

int64_t ttf_timeline_run_ns(const struct ttf_segment *segment, int64_t slot0_ns)
{
    int64_t run_ns = segment->origin_ns - slot0_ns;
    int64_t by_grid_ns;

    if (run_ns < 0 || (ttf_mul_i64(segment->first_index, segment->interval_ns, &by_grid_ns) &&
                       by_grid_ns == run_ns))
        return 0;
    return run_ns;
}

int64_t ttf_timeline_elapsed_ns(const struct ttf_segment *segments, int n)
{
    int64_t elapsed = 0;

    if (n > 0)
        elapsed = segments[0].run_ns > 0 ? segments[0].run_ns
                                         : segments[0].first_index * segments[0].interval_ns;

    for (int i = 1; i < n; i++)
        elapsed += step_ns(&segments[i - 1], &segments[i]);
    return elapsed;
}

int64_t ttf_timeline_slot0_utc_ns(const struct ttf_segment *segments, int n)
{
    for (; n > 0; n--)
        if (segments[n - 1].origin_utc_ns != TTF_NS_UNKNOWN)
            return segments[n - 1].origin_utc_ns - ttf_timeline_elapsed_ns(segments, n);
    return TTF_NS_UNKNOWN;
}

static enum ttf_trust trust_of(const char *name)
{
    for (int trust = TTF_TRUST_NONE + 1; trust < TTF_TRUST_COUNT; trust++)
        if (strcmp(name, ttf_trust_name((enum ttf_trust)trust)) == 0)
            return (enum ttf_trust)trust;
    return TTF_TRUST_NONE;
}

enum ttf_trust ttf_segment_trust(const struct ttf_segment *segment)
{
    return trust_of(segment->trust);
}

bool ttf_segment_has_utc(const struct ttf_segment *segment)
{
    return segment->origin_utc_ns > UTC_MIN_NS && segment->origin_utc_ns < TIME_MAX_NS;
}

static bool by_host(const struct ttf_segment *segment)
{
    return ttf_segment_trust(segment) == TTF_TRUST_HOST;
}

/* One of this boot. */
static void learn_of_boot(struct ttf_run_past *past, const struct ttf_segment *segment)
{
    enum ttf_trust trust = ttf_segment_trust(segment);

    if (segment->origin_utc_ns == TTF_NS_UNKNOWN || trust < past->boot_trust)
        return;
    past->boot_trust = trust;
    past->boot_offset_ns = segment->origin_utc_ns - segment->origin_ns;
    past->boot_uncertainty_ns = segment->uncertainty_ns;
}

/* One of a boot before; of one without a slot the origin may be a start that is still to come. */
static void learn_of_last(struct ttf_run_past *past, const struct ttf_segment *segment,
                          int64_t taken_until, int64_t elapsed_ns)
{
    int64_t after_ns = (taken_until - 1 - segment->first_index) * segment->interval_ns;
    enum ttf_trust trust = ttf_segment_trust(segment);

    if (taken_until <= segment->first_index || segment->origin_utc_ns == TTF_NS_UNKNOWN ||
        trust == TTF_TRUST_NONE || (trust == TTF_TRUST_HOST && past->last_trust > TTF_TRUST_HOST))
        return;
    past->last_trust = trust;
    past->last_utc_ns = segment->origin_utc_ns + after_ns;
    past->last_uncertainty_ns = segment->uncertainty_ns;
    past->last_run_ns = elapsed_ns + after_ns;
    past->last_moved = false;
}

/* Outages and UTC of slot 0 as known up to a segment. */
struct known {
    int64_t gaps_ns, slot0_utc_ns;
    enum ttf_trust trust;
    bool open;
    /* Of slots given up: those that no clock of these has judged yet, and those that one has, and may take back. */
    int64_t doubted_ns, given_up_ns;
};

static int64_t later_by(int64_t slot0_utc_ns, int64_t than_ns)
{
    int64_t ns;

    if (slot0_utc_ns <= than_ns)
        return 0;
    return ttf_add_i64(slot0_utc_ns, -than_ns, &ns) ? ns : GAPS_MAX_NS;
}

static int64_t with_gap(int64_t gaps_ns, int64_t gap_ns)
{
    return gap_ns < GAPS_MAX_NS - gaps_ns ? gaps_ns + gap_ns : GAPS_MAX_NS;
}

static int64_t without(int64_t gaps_ns, int64_t ns)
{
    return gaps_ns > ns - GAPS_MAX_NS ? gaps_ns - ns : -GAPS_MAX_NS;
}

int64_t ttf_timeline_given_up_ns(int64_t origin_ns, int64_t interval_ns, int64_t slots)
{
    int64_t n, ns;

    if (origin_ns >= 0 || interval_ns <= 0 || slots <= 0)
        return 0;
    n = -(origin_ns + 1) / interval_ns + 1;
    return ttf_mul_i64(n < slots ? n : slots, interval_ns, &ns) && ns < GAPS_MAX_NS ? ns
                                                                                    : GAPS_MAX_NS;
}

/*
 * One clock on either side of what lies between. Slots that were given up by one that was ahead of both are no time of
 * the run: as many as slot 0 is said to be earlier now. More is no outage that was shorter, but a clock that was set.
 */
static void tell_outages(struct known *known, const struct ttf_segment *segment,
                         int64_t slot0_utc_ns)
{
    const int64_t earlier_ns = later_by(known->slot0_utc_ns, slot0_utc_ns);

    if (earlier_ns > 0 && segment->interval_ns > 0) {
        int64_t ns = earlier_ns - earlier_ns % segment->interval_ns;

        if (ns > known->given_up_ns)
            ns = known->given_up_ns;
        known->gaps_ns = without(known->gaps_ns, ns);
        known->given_up_ns -= ns;
    } else if (known->open) {
        known->gaps_ns = with_gap(known->gaps_ns, later_by(slot0_utc_ns, known->slot0_utc_ns));
    } else if (segment->gap_ns > 0) {
        known->gaps_ns = with_gap(known->gaps_ns, segment->gap_ns);
    }
}

/*
 * slot0_utc_ns: as this segment has it; TTF_NS_UNKNOWN: it does not, or its word does not count. given_up_ns: what it
 * began with of slots that were due before its boot.
 */
static void go_on(struct known *known, const struct ttf_segment *segment, bool new_boot,
                  int64_t slot0_utc_ns, int64_t given_up_ns)
{
    known->doubted_ns = with_gap(known->doubted_ns, given_up_ns);
    if (slot0_utc_ns == TTF_NS_UNKNOWN) {
        known->open = known->open || new_boot || segment->gap_ns != 0;
        return;
    }
    if (known->slot0_utc_ns == TTF_NS_UNKNOWN) {
        /* The first whose word counts: nobody's did who told the outages of before. */
        known->gaps_ns = without(known->gaps_ns, known->doubted_ns);
    } else {
        known->given_up_ns = with_gap(known->given_up_ns, known->doubted_ns);
        tell_outages(known, segment, slot0_utc_ns);
    }
    known->doubted_ns = 0;
    known->slot0_utc_ns = slot0_utc_ns;
    known->trust = ttf_segment_trust(segment);
    known->open = false;
}

/* Both, with a PC's word and without. */
static void go_on_both(struct known *all, struct known *sure, const struct ttf_segment *segment,
                       bool new_boot, int64_t slot0_utc_ns, int64_t given_up_ns)
{
    go_on(all, segment, new_boot, slot0_utc_ns, given_up_ns);
    go_on(sure, segment, new_boot, by_host(segment) ? TTF_NS_UNKNOWN : slot0_utc_ns, given_up_ns);
}

/* In a run's time: what is told of outages, less the slots that nobody sure told one for. */
static int64_t gaps_of(const struct known *known)
{
    return without(known->gaps_ns, known->doubted_ns);
}

/* A dataset of before these were said lets slots be taken back as many as there were. */
static void know_sums(struct known *sure, const struct ttf_segment *first)
{
    sure->gaps_ns = first->run_gaps_ns;
    sure->doubted_ns = first->run_doubted_ns;
    sure->given_up_ns = first->run_given_up_ns;
    if (sure->slot0_utc_ns != TTF_NS_UNKNOWN)
        sure->slot0_utc_ns += first->run_gaps_ns;
}

/*
 * What the dataset that a run moved on from knew: outages up to the first segment are what UTC of slot 0 is later by.
 * Where a clock of the present boot says it, it says nothing of the last slot of one before.
 */
static void go_on_from_before(struct known *all, struct known *sure, struct ttf_run_past *past,
                              const struct ttf_segment *first, const char *boot_id)
{
    const enum ttf_trust trust = trust_of(first->run_trust);

    if (first->run_utc_ns <= 0 || trust == TTF_TRUST_NONE)
        return;
    *all = (struct known){.slot0_utc_ns = first->run_utc_ns,
                          .trust = trust,
                          .open = true,
                          .given_up_ns = ttf_timeline_elapsed_ns(first, 1)};
    if (trust != TTF_TRUST_HOST)
        *sure = *all;
    if (first->run_gaps_ns != TTF_NS_UNKNOWN)
        know_sums(sure, first);
    if (first->origin_utc_ns != TTF_NS_UNKNOWN && strcmp(first->boot_id, boot_id) == 0)
        return;
    past->last_trust = trust;
    past->last_run_ns = ttf_timeline_elapsed_ns(first, 1) - first->interval_ns;
    past->last_utc_ns = first->run_utc_ns + past->last_run_ns;
    past->last_moved = true;
}

static struct known all_of(const struct ttf_run_past *past)
{
    return (struct known){
        .gaps_ns = past->gaps_ns, .slot0_utc_ns = past->slot0_utc_ns, .open = past->open};
}

/* Without what a PC's word alone says. */
static struct known sure_of(const struct ttf_run_past *past)
{
    return (struct known){past->sure_gaps_ns, past->sure_slot0_utc_ns, past->sure_trust,
                          past->sure_open,    past->sure_doubted_ns,   past->sure_given_up_ns};
}

/* Both, and the present segment, which begins with such an outage. */
static void go_on_now(struct known *all, struct known *sure, const struct ttf_segment *segment,
                      const struct ttf_outage *outage, int64_t slot0_utc_ns)
{
    struct ttf_segment now = *segment;

    now.gap_ns = outage->gap_unknown ? TTF_NS_UNKNOWN : 0;
    all->open |= outage->gap_unknown;
    sure->open |= outage->gap_unknown;
    go_on_both(all, sure, &now, false, slot0_utc_ns, outage->given_up_ns);
}

void ttf_timeline_run_utc(struct ttf_segment *segment, const struct ttf_run_past *past,
                          int64_t slot0_ns, const struct ttf_outage *outage)
{
    struct known all = all_of(past), sure = sure_of(past);
    int64_t slot0 = TTF_NS_UNKNOWN;

    if (segment->origin_utc_ns != TTF_NS_UNKNOWN)
        slot0 = segment->origin_utc_ns - (segment->origin_ns - slot0_ns);
    go_on_now(&all, &sure, segment, outage, slot0);
    segment->run_utc_ns = 0;
    segment->run_trust[0] = '\0';
    segment->run_gaps_ns = sure.gaps_ns;
    segment->run_doubted_ns = sure.doubted_ns;
    segment->run_given_up_ns = sure.given_up_ns;
    if (all.slot0_utc_ns == TTF_NS_UNKNOWN)
        return;
    if (sure.slot0_utc_ns != TTF_NS_UNKNOWN)
        all = sure;
    else
        all.trust = TTF_TRUST_HOST;
    segment->run_utc_ns = all.slot0_utc_ns - all.gaps_ns;
    snprintf(segment->run_trust, sizeof(segment->run_trust), "%s", ttf_trust_name(all.trust));
}

int64_t ttf_timeline_gaps_ns(const struct ttf_run_past *past, const struct ttf_segment *segment,
                             const struct ttf_outage *outage, int64_t slot0_utc_ns)
{
    struct known all = all_of(past), sure = sure_of(past);

    go_on_now(&all, &sure, segment, outage, slot0_utc_ns);
    return gaps_of(&sure);
}

struct ttf_run_past ttf_timeline_past(const struct ttf_segment *segments,
                                      const int64_t *taken_until, int n, int64_t next_index,
                                      const char *boot_id)
{
    struct known all = {.slot0_utc_ns = TTF_NS_UNKNOWN}, sure = all;
    struct ttf_run_past past = {0};

    if (n > 0) {
        past.behind_outage = strcmp(segments[0].boot_id, boot_id) != 0;
        go_on_from_before(&all, &sure, &past, &segments[0], boot_id);
    }
    for (int i = 0; i < n; i++) {
        const struct ttf_segment *s = &segments[i];
        bool new_boot = i > 0 && strcmp(s->boot_id, segments[i - 1].boot_id) != 0;
        const int64_t until = i + 1 < n ? segments[i + 1].first_index : next_index;
        int64_t slot0 = TTF_NS_UNKNOWN, given_up = 0;

        if (s->origin_utc_ns != TTF_NS_UNKNOWN)
            slot0 = s->origin_utc_ns - ttf_timeline_elapsed_ns(segments, i + 1);
        /* Whichever run of a boot recorded them. Of the first one's boot they are what a start had passed by. */
        if (strcmp(s->boot_id, segments[0].boot_id) != 0)
            given_up =
                ttf_timeline_given_up_ns(s->origin_ns, s->interval_ns, until - s->first_index);
        go_on_both(&all, &sure, s, new_boot, slot0, given_up);
        if (strcmp(s->boot_id, boot_id) == 0)
            learn_of_boot(&past, s);
        else
            learn_of_last(&past, s, taken_until[i], ttf_timeline_elapsed_ns(segments, i + 1));
    }
    past.gaps_ns = all.gaps_ns;
    past.slot0_utc_ns = all.slot0_utc_ns;
    past.open = all.open;
    past.sure_gaps_ns = sure.gaps_ns;
    past.sure_slot0_utc_ns = sure.slot0_utc_ns;
    past.sure_open = sure.open;
    past.sure_trust = sure.trust;
    past.sure_doubted_ns = sure.doubted_ns;
    past.sure_given_up_ns = sure.given_up_ns;
    return past;
}

/*
 * One more than the last slot from `from` on that was taken, of the slot lines before *at; from: none was. What a resume
 * gives up while its lamps settle is recorded before it is due, and says nothing of when it was recorded.
 */
static int64_t find_taken(const struct ttf_reader *reader, int64_t from, int64_t *at)
{
    int64_t taken_until = from, index;
    enum ttf_result result;

    for (; ttf_reader_brief(reader, *at - 1, &index, &result) == 0 && index >= from; (*at)--)
        if (taken_until == from && result != TTF_RESULT_POWER && result != TTF_RESULT_MISSED)
            taken_until = index + 1;
    return taken_until;
}

static bool in_reach(int64_t ns)
{
    return ns > -TIME_MAX_NS && ns < TIME_MAX_NS;
}

/* Of what may be unknown, what no clock can have said counts as that. */
static void forget_beyond_reach(struct ttf_segment *s)
{
    if (!ttf_segment_has_utc(s))
        s->origin_utc_ns = TTF_NS_UNKNOWN;
    if (s->uncertainty_ns >= TIME_MAX_NS)
        s->uncertainty_ns = TTF_NS_UNKNOWN;
    if (s->gap_ns >= TIME_MAX_NS)
        s->gap_ns = TTF_NS_UNKNOWN;
    if (s->run_utc_ns >= TIME_MAX_NS)
        s->run_utc_ns = 0;
    if (s->run_gaps_ns < -GAPS_MAX_NS || s->run_gaps_ns > GAPS_MAX_NS ||
        s->run_doubted_ns > GAPS_MAX_NS || s->run_given_up_ns > GAPS_MAX_NS)
        s->run_gaps_ns = TTF_NS_UNKNOWN;
}

/* Its slots before `until`, and where it lies on its clock: the run's time is added up of such. */
static bool segment_in_reach(const struct ttf_segment *s, int64_t until)
{
    int64_t span_ns;

    return in_reach(s->origin_ns) && in_reach(s->first_index) && in_reach(until) &&
           in_reach(s->interval_ns) && in_reach(s->run_ns) &&
           ttf_mul_i64(until - s->first_index, s->interval_ns, &span_ns) && in_reach(span_ns);
}

/* A foreign dataset's may be beyond all reckoning: it is refused here, once. until: one more than its last slot. */
static int expect_in_reach(const struct ttf_segment *segments, int n, int64_t until,
                           const char *path, struct ttf_err *err)
{
    int64_t elapsed_ns = 0;

    for (int i = 0; i < n; i++) {
        const struct ttf_segment *s = &segments[i];
        bool ok = segment_in_reach(s, i + 1 < n ? segments[i + 1].first_index : until);

        if (i > 0)
            ok = ok && ttf_add_i64(elapsed_ns, step_ns(&segments[i - 1], s), &elapsed_ns);
        else if (s->run_ns > 0)
            elapsed_ns = s->run_ns;
        else
            ok = ok && ttf_mul_i64(s->first_index, s->interval_ns, &elapsed_ns);
        if (!ok || !in_reach(elapsed_ns))
            return ttf_err_set(err, -EINVAL, path,
                               "segment %d says times that no clock can have shown: this dataset "
                               "cannot be gone on with",
                               i);
    }
    return 0;
}

static int read_segments(struct ttf_reader *reader, struct ttf_segment *segments,
                         int64_t *taken_until, int n, struct ttf_err *err)
{
    const struct ttf_reader_summary *summary = ttf_reader_summary(reader);
    int64_t at = summary->slots;
    int r = 0;

    for (int i = n - 1; i >= 0 && r == 0; i--) {
        r = ttf_reader_segment(reader, i, &segments[i]);
        forget_beyond_reach(&segments[i]);
        taken_until[i] = find_taken(reader, segments[i].first_index, &at);
    }
    return r < 0 ? r
                 : expect_in_reach(segments, n, summary->slots > 0 ? summary->last_index + 1 : 0,
                                   ttf_reader_path(reader), err);
}

int ttf_timeline_read(struct ttf_io *io, const char *path, struct ttf_segment **ret,
                      int64_t **ret_taken_until, int *ret_n, struct ttf_err *err)
{
    struct ttf_segment *segments = NULL;
    int64_t *taken_until = NULL;
    struct ttf_reader *reader;
    int r = ttf_reader_open(io, path, &reader, err);
    int n;

    if (r < 0)
        return r;
    n = ttf_reader_summary(reader)->n_segments;
    if (n > 0) {
        segments = calloc((size_t)n, sizeof(*segments));
        taken_until = calloc((size_t)n, sizeof(*taken_until));
        r = segments && taken_until ? read_segments(reader, segments, taken_until, n, err)
                                    : ttf_err_set(err, -ENOMEM, path, "no memory");
    }
    ttf_reader_close(reader);
    if (r < 0) {
        free(segments);
        free(taken_until);
        return r;
    }
    *ret = segments;
    *ret_taken_until = taken_until;
    *ret_n = n;
    return 0;
}
