/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "datasets/plain_stream.h"
#include "quantile.h"
#include "schedule.h"
#include "timeline.h"
#include "ttf/base/time.h"
#include "ttf/dataset/writer.h"

static struct ttf_segment segment(const char *boot, int64_t first, int64_t origin_s)
{
    struct ttf_segment s = {.first_index = first,
                            .origin_ns = origin_s * TTF_NS_PER_S,
                            .origin_utc_ns = TTF_NS_UNKNOWN,
                            .interval_ns = TTF_NS_PER_MIN};

    snprintf(s.boot_id, sizeof(s.boot_id), "%s", boot);
    return s;
}

/* With all slots taken, up to end. */
static struct ttf_run_past past_of(const struct ttf_segment *s, int n, const char *boot_id,
                                   int64_t end)
{
    int64_t taken_until[8];

    for (int i = 0; i < n; i++)
        taken_until[i] = i + 1 < n ? s[i + 1].first_index : end;
    return ttf_timeline_past(s, taken_until, n, end, boot_id);
}

static const struct ttf_outage NO_GAP = {0}, UNKNOWN_GAP = {.gap_unknown = true};

/* In another boot, by such a clock. */
static int64_t gaps_by(const struct ttf_run_past *past, const char *trust, int64_t slot0_utc_ns,
                       bool gap_unknown)
{
    struct ttf_segment now = segment("x", 100, 20);

    snprintf(now.trust, sizeof(now.trust), "%s", trust);
    return ttf_timeline_gaps_ns(past, &now, gap_unknown ? &UNKNOWN_GAP : &NO_GAP, slot0_utc_ns);
}

static void over_segments_of_a_boot_its_clock_counts_over_a_boot_the_slots(void **state)
{
    /* Ten slots; another interval, begun 30 s later than the grid would; then another boot. */
    struct ttf_segment s[3] = {segment("a", 0, 100), segment("a", 10, 730), segment("b", 15, 20)};

    (void)state;
    assert_int_equal(ttf_timeline_elapsed_ns(s, 0), 0);
    assert_int_equal(ttf_timeline_elapsed_ns(s, 1), 0);
    assert_int_equal(ttf_timeline_elapsed_ns(s, 2), 630 * TTF_NS_PER_S);
    assert_int_equal(ttf_timeline_elapsed_ns(s, 3), (630 + 300) * TTF_NS_PER_S);
}

static void a_dataset_that_a_run_moved_to_knows_what_came_before(void **state)
{
    struct ttf_segment s = segment("a", 10, 730);

    (void)state;
    /* Its own grid, or what the line says where that is not it. */
    assert_int_equal(ttf_timeline_elapsed_ns(&s, 1), 600 * TTF_NS_PER_S);
    s.run_ns = 630 * TTF_NS_PER_S;
    assert_int_equal(ttf_timeline_elapsed_ns(&s, 1), 630 * TTF_NS_PER_S);
}

static void a_run_s_time_is_only_said_where_the_grid_does_not_say_it(void **state)
{
    struct ttf_segment s = segment("a", 10, 730);

    (void)state;
    assert_int_equal(ttf_timeline_run_ns(&s, 130 * TTF_NS_PER_S), 0);
    assert_int_equal(ttf_timeline_run_ns(&s, 100 * TTF_NS_PER_S), 630 * TTF_NS_PER_S);
    /* Before slot 0 there was no run. */
    assert_int_equal(ttf_timeline_run_ns(&s, 800 * TTF_NS_PER_S), 0);
}

static void slot_0_is_where_the_last_segment_with_utc_says(void **state)
{
    struct ttf_segment s[2] = {segment("a", 0, 100), segment("b", 10, 20)};

    (void)state;
    assert_int_equal(ttf_timeline_slot0_utc_ns(s, 2), TTF_NS_UNKNOWN);
    assert_int_equal(ttf_timeline_slot0_utc_ns(s, 0), TTF_NS_UNKNOWN);
    s[0].origin_utc_ns = 1000 * TTF_NS_PER_S;
    assert_int_equal(ttf_timeline_slot0_utc_ns(s, 2), 1000 * TTF_NS_PER_S);
    s[1].origin_utc_ns = 1605 * TTF_NS_PER_S;
    assert_int_equal(ttf_timeline_slot0_utc_ns(s, 2), 1005 * TTF_NS_PER_S);
}

static void what_a_pc_alone_says_of_the_past_is_told_apart(void **state)
{
    struct ttf_segment s[3] = {segment("a", 0, 100), segment("b", 10, 20), segment("c", 12, 20)};
    struct ttf_run_past past = past_of(s, 3, "d", 15);

    (void)state;
    assert_int_equal(past.gaps_ns, 0);
    assert_int_equal(past.slot0_utc_ns, TTF_NS_UNKNOWN);
    assert_int_equal(past.sure_slot0_utc_ns, TTF_NS_UNKNOWN);
    s[0].origin_utc_ns = 1000 * TTF_NS_PER_S;
    s[1].gap_ns = 7 * TTF_NS_PER_S;
    s[1].origin_utc_ns = 1607 * TTF_NS_PER_S;
    s[2].gap_ns = 5 * TTF_NS_PER_S;
    s[2].origin_utc_ns = 1732 * TTF_NS_PER_S;
    snprintf(s[0].trust, sizeof(s[0].trust), "rtc");
    snprintf(s[1].trust, sizeof(s[1].trust), "ntp");
    snprintf(s[2].trust, sizeof(s[2].trust), "host");
    past = past_of(s, 3, "d", 15);
    assert_int_equal(past.gaps_ns, 12 * TTF_NS_PER_S);
    assert_int_equal(past.slot0_utc_ns, 1012 * TTF_NS_PER_S);
    assert_int_equal(past.sure_gaps_ns, 7 * TTF_NS_PER_S);
    assert_int_equal(past.sure_slot0_utc_ns, 1007 * TTF_NS_PER_S);
    s[2].gap_ns = TTF_NS_UNKNOWN;
    assert_int_equal(past_of(s, 3, "d", 15).gaps_ns, 7 * TTF_NS_PER_S);
}

/* NTP until slot 10; twice power and no clock; NTP, or first a PC's. */
static void outages_without_a_clock_between_are_told_by_the_next_clock(void **state)
{
    struct ttf_segment s[4] = {segment("a", 0, 100), segment("b", 10, 20), segment("c", 10, 20),
                               segment("d", 12, 20)};
    const int64_t slot0 = 1000 * TTF_NS_PER_S, gap = TTF_NS_PER_H;
    struct ttf_run_past past;

    (void)state;
    s[0].origin_utc_ns = slot0;
    snprintf(s[0].trust, sizeof(s[0].trust), "ntp");
    for (int i = 1; i < 4; i++)
        s[i].gap_ns = TTF_NS_UNKNOWN;
    past = past_of(s, 2, "x", 10);
    assert_true(past.open && past.sure_open);
    assert_int_equal(gaps_by(&past, "ntp", TTF_NS_UNKNOWN, true), 0);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + gap, false), gap);
    assert_int_equal(gaps_by(&past, "ntp", slot0 - gap, true), 0);
    /* The third knows. */
    s[2].origin_utc_ns = slot0 + 600 * TTF_NS_PER_S + gap;
    snprintf(s[2].trust, sizeof(s[2].trust), "ntp");
    past = past_of(s, 3, "x", 12);
    assert_false(past.open || past.sure_open);
    assert_int_equal(past.gaps_ns, gap);
    assert_int_equal(past.sure_gaps_ns, gap);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + 3 * gap, false), gap); /* it was set */
    assert_int_equal(gaps_by(&past, "ntp", slot0 + 3 * gap, true), 3 * gap);
    /* A PC's, wrong by days, and by itself no more than that. */
    s[2].origin_utc_ns += 9 * TTF_NS_PER_DAY;
    snprintf(s[2].trust, sizeof(s[2].trust), "host");
    past = past_of(s, 3, "x", 12);
    assert_int_equal(past.gaps_ns, gap + 9 * TTF_NS_PER_DAY);
    assert_int_equal(past.sure_gaps_ns, 0);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + 2 * gap, false), 2 * gap);
    s[3].origin_utc_ns = slot0 + 720 * TTF_NS_PER_S + 2 * gap;
    s[3].gap_ns = 0; /* behind that PC's */
    snprintf(s[3].trust, sizeof(s[3].trust), "ntp");
    assert_int_equal(past_of(s, 4, "x", 12).sure_gaps_ns, 2 * gap);
}

/* A PC until slot 10; power and no clock; NTP: how late that PC was nobody knows, so it is no outage; nor after the next cut. */
static void what_lies_behind_a_pc_s_word_is_no_outage(void **state)
{
    const int64_t slot0 = 1000 * TTF_NS_PER_S, gap = TTF_NS_PER_H;
    struct ttf_segment s[4] = {segment("a", 0, 100), segment("b", 10, 20), segment("c", 12, 20),
                               segment("d", 14, 20)};
    struct ttf_run_past past;

    (void)state;
    s[0].origin_utc_ns = slot0;
    snprintf(s[0].trust, sizeof(s[0].trust), "host");
    s[1].gap_ns = s[2].gap_ns = TTF_NS_UNKNOWN;
    past = past_of(s, 2, "c", 12);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + gap, true), 0);
    s[2].origin_utc_ns = slot0 + 12 * TTF_NS_PER_MIN + gap;
    snprintf(s[2].trust, sizeof(s[2].trust), "ntp");
    past = past_of(s, 3, "d", 14);
    assert_int_equal(past.sure_gaps_ns, 0);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + 3 * gap, true), 2 * gap); /* since then */
    assert_int_equal(gaps_by(&past, "host", slot0 + 3 * gap, true), 0);
    /* What a PC says from then on adds nothing by itself, and the next one that knows tells all of it. */
    s[3].gap_ns = gap;
    s[3].origin_utc_ns = slot0 + 14 * TTF_NS_PER_MIN + 2 * gap;
    snprintf(s[3].trust, sizeof(s[3].trust), "host");
    past = past_of(s, 4, "x", 16);
    assert_int_equal(past.sure_gaps_ns, 0);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + 5 * gap, true), 4 * gap);
}

static void slots_that_were_due_before_the_boot_were_given_up(void **state)
{
    static const struct {
        int64_t origin_s, interval_s, slots, given_up_s;
    } cases[] = {{20, 60, 9, 0},    {0, 60, 9, 0},      {-1, 60, 9, 60}, {-60, 60, 9, 60},
                 {-61, 60, 9, 120}, {-600, 60, 9, 540}, {-1, 60, 0, 0},  {-1, 0, 9, 0}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
        assert_int_equal(ttf_timeline_given_up_ns(cases[i].origin_s * TTF_NS_PER_S,
                                                  cases[i].interval_s * TTF_NS_PER_S,
                                                  cases[i].slots),
                         cases[i].given_up_s * TTF_NS_PER_S);
}

/* On the same grid behind an outage of three slots, by such clocks; then what another says of slot 0. */
static void slots_given_up_are_time_of_the_run_as_far_as_sure_clocks_say_so(void **state)
{
    static const struct {
        const char *before, *then, *now;
        int64_t earlier_s, gaps_s;
    } cases[] = {{"ntp", "rtc", "none", 0, 0},      {"ntp", "rtc", "ntp", 0, 0},
                 {"ntp", "rtc", "ntp", 59, 0},      {"ntp", "rtc", "ntp", 60, -60},
                 {"ntp", "rtc", "ntp", 179, -120},  {"ntp", "rtc", "ntp", 6000, -180},
                 {"ntp", "rtc", "host", 6000, 0},   {"ntp", "host", "none", 0, -180},
                 {"ntp", "host", "host", 0, -180},  {"ntp", "host", "ntp", 0, 0},
                 {"ntp", "host", "ntp", 120, -120}, {"ntp", "host", "ntp", -120, 120},
                 {"host", "rtc", "none", 0, -180},  {"host", "rtc", "ntp", 0, -180}};
    const int64_t slot0 = 100000 * TTF_NS_PER_S;

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct ttf_segment s[2] = {segment("a", 0, 100), segment("b", 10, -170)};
        struct ttf_run_past past;

        snprintf(s[0].trust, sizeof(s[0].trust), "%s", cases[i].before);
        snprintf(s[1].trust, sizeof(s[1].trust), "%s", cases[i].then);
        s[0].origin_utc_ns = slot0;
        s[1].origin_utc_ns = slot0 + 10 * TTF_NS_PER_MIN;
        past = past_of(s, 2, "x", 20);
        assert_int_equal(gaps_by(&past, cases[i].now,
                                 strcmp(cases[i].now, "none") == 0
                                     ? TTF_NS_UNKNOWN
                                     : slot0 - cases[i].earlier_s * TTF_NS_PER_S,
                                 false),
                         cases[i].gaps_s * TTF_NS_PER_S);
    }
}

/* The second dataset does not say which they were; what UTC of slot 0 is earlier than its first segment says tells of them. */
static void slots_given_up_before_a_move_are_no_time_of_the_run_after_it(void **state)
{
    const int64_t slot0 = 100000 * TTF_NS_PER_S;
    struct ttf_segment before[2] = {segment("a", 0, 100), segment("b", 10, -170)};
    struct ttf_segment after = segment("c", 20, 20);
    struct ttf_run_past past;

    (void)state;
    before[0].origin_utc_ns = slot0;
    before[1].origin_utc_ns = slot0 + 10 * TTF_NS_PER_MIN;
    after.origin_utc_ns = slot0 + 17 * TTF_NS_PER_MIN;
    snprintf(before[0].trust, sizeof(before[0].trust), "ntp");
    snprintf(before[1].trust, sizeof(before[1].trust), "rtc");
    snprintf(after.trust, sizeof(after.trust), "ntp");
    past = past_of(before, 2, "c", 20);
    ttf_timeline_run_utc(&after, &past, after.origin_ns - 20 * TTF_NS_PER_MIN, &UNKNOWN_GAP);
    assert_int_equal(after.run_utc_ns, slot0);
    past = past_of(&after, 1, "d", 25);
    assert_int_equal(past.sure_gaps_ns, -3 * TTF_NS_PER_MIN);
}

/* NTP, an outage, NTP; an outage, and it moves on there: to a dataset that has but its own segments. */
static void what_was_known_before_a_move_is_known_after_it(void **state)
{
    const int64_t slot0 = 1000 * TTF_NS_PER_S, gap = TTF_NS_PER_H;
    struct ttf_segment before[2] = {segment("a", 0, 100), segment("b", 10, 20)};
    const int64_t slot0_ns = (20 - 12 * 60) * TTF_NS_PER_S; /* on the clock of boot c */
    struct ttf_segment after[2] = {segment("c", 12, 20), segment("d", 14, 20)};
    struct ttf_run_past past = past_of(before, 2, "c", 12);

    (void)state;
    ttf_timeline_run_utc(&after[0], &past, slot0_ns, &UNKNOWN_GAP);
    assert_int_equal(after[0].run_utc_ns, 0); /* nobody knew */
    before[0].origin_utc_ns = slot0;
    before[1].origin_utc_ns = slot0 + 600 * TTF_NS_PER_S + gap;
    before[1].gap_ns = gap;
    snprintf(before[0].trust, sizeof(before[0].trust), "ntp");
    snprintf(before[1].trust, sizeof(before[1].trust), "host");
    past = past_of(before, 2, "c", 12);
    ttf_timeline_run_utc(&after[0], &past, slot0_ns, &UNKNOWN_GAP);
    assert_int_equal(after[0].run_utc_ns, slot0);
    assert_string_equal(after[0].run_trust, "ntp");
    /* Both outages, as soon as somebody says when it is. */
    past = past_of(after, 1, "d", 14);
    assert_true(past.open && past.sure_open);
    assert_int_equal(past.last_trust, TTF_TRUST_NTP);
    assert_int_equal(past.last_utc_ns, slot0 + 11 * TTF_NS_PER_MIN); /* if it was taken */
    assert_true(past.last_moved);
    assert_int_equal(gaps_by(&past, "ntp", slot0 + 3 * gap, true), 3 * gap);
    after[0].origin_utc_ns = slot0 + 12 * TTF_NS_PER_MIN + 2 * gap;
    snprintf(after[0].trust, sizeof(after[0].trust), "rtc");
    past = past_of(after, 1, "d", 14);
    assert_false(past.open || past.sure_open);
    assert_int_equal(past.sure_gaps_ns, 2 * gap);
    assert_false(past.last_moved); /* slot 13 was taken, there */
    /* Said when that is known already, it says the same; that all of it was set since is no outage. */
    past = past_of(before, 2, "c", 12);
    ttf_timeline_run_utc(&after[0], &past, slot0_ns, &UNKNOWN_GAP);
    assert_int_equal(after[0].run_utc_ns, slot0);
    assert_string_equal(after[0].run_trust, "rtc");
    before[1] = segment("b", 10, 20);
    before[1].origin_utc_ns = slot0 + 600 * TTF_NS_PER_S;
    snprintf(before[1].trust, sizeof(before[1].trust), "ntp");
    past = past_of(before, 2, "c", 12);
    ttf_timeline_run_utc(&after[0], &past, slot0_ns, &NO_GAP);
    assert_int_equal(after[0].run_utc_ns, slot0 + 2 * gap);
    assert_string_equal(after[0].run_trust, "rtc");
    assert_int_equal(past_of(after, 1, "d", 14).sure_gaps_ns, 0);
    /* Of this boot it says nothing of the last slot of one before. */
    assert_int_equal(past_of(after, 1, "c", 14).last_trust, TTF_TRUST_NONE);
    /* What a PC says of the last outage leaves what better clocks said before. */
    snprintf(after[0].trust, sizeof(after[0].trust), "host");
    ttf_timeline_run_utc(&after[0], &past, slot0_ns, &NO_GAP);
    assert_int_equal(after[0].run_utc_ns, slot0);
    assert_string_equal(after[0].run_trust, "ntp");
    /* A PC's word alone stays one. */
    after[0].origin_utc_ns = TTF_NS_UNKNOWN;
    snprintf(after[0].run_trust, sizeof(after[0].run_trust), "host");
    past = past_of(after, 1, "d", 14);
    assert_int_equal(past.slot0_utc_ns, slot0);
    assert_int_equal(past.sure_slot0_utc_ns, TTF_NS_UNKNOWN);
    /* What nobody vouches for, or somebody unheard of, is as good as not said. */
    snprintf(after[0].run_trust, sizeof(after[0].run_trust), "sundial");
    past = past_of(after, 1, "d", 14);
    assert_int_equal(past.slot0_utc_ns, TTF_NS_UNKNOWN);
    assert_int_equal(past.sure_slot0_utc_ns, TTF_NS_UNKNOWN);
}

static void the_best_that_this_boot_knew_is_remembered(void **state)
{
    static const struct {
        const char *trust;
        int64_t offset_s;
        enum ttf_trust best;
        int64_t best_s;
    } cases[] = {{"none", 7, TTF_TRUST_NONE, 0},  {"host", 7, TTF_TRUST_HOST, 7},
                 {"ntp", 8, TTF_TRUST_NTP, 8},    {"host", 9, TTF_TRUST_NTP, 8},
                 {"a star", 9, TTF_TRUST_NTP, 8}, {"ntp", 10, TTF_TRUST_NTP, 10}};
    struct ttf_segment s[7] = {segment("a", 0, 100)};

    (void)state;
    s[0].origin_utc_ns = 5000 * TTF_NS_PER_S; /* of another boot */
    snprintf(s[0].trust, sizeof(s[0].trust), "ntp");
    for (int i = 1; i < 7; i++) {
        struct ttf_run_past past;

        s[i] = segment("b", 10 * i, 600 * i);
        if (i > 1)
            s[i].origin_utc_ns = s[i].origin_ns + cases[i - 1].offset_s * TTF_NS_PER_S;
        s[i].uncertainty_ns = cases[i - 1].offset_s;
        snprintf(s[i].trust, sizeof(s[i].trust), "%s", cases[i - 1].trust);
        past = past_of(s, i + 1, "b", 100);
        assert_int_equal(past.boot_trust, cases[i - 1].best);
        assert_int_equal(past.boot_offset_ns, cases[i - 1].best_s * TTF_NS_PER_S);
        if (past.boot_trust != TTF_TRUST_NONE)
            assert_int_equal(past.boot_uncertainty_ns, cases[i - 1].best_s);
    }
}

static void when_the_last_slot_of_the_boots_before_was_is_known(void **state)
{
    struct ttf_segment s[3] = {segment("a", 0, 100), segment("b", 10, 20), segment("c", 12, 20)};
    struct ttf_run_past past = past_of(s, 3, "d", 15);

    (void)state;
    assert_int_equal(past.last_trust, TTF_TRUST_NONE);
    s[0].origin_utc_ns = 1000 * TTF_NS_PER_S;
    s[2].origin_utc_ns = 5000 * TTF_NS_PER_S;
    s[2].uncertainty_ns = 3;
    snprintf(s[0].trust, sizeof(s[0].trust), "rtc");
    snprintf(s[2].trust, sizeof(s[2].trust), "ntp");
    past = past_of(s, 3, "d", 15);
    assert_int_equal(past.last_trust, TTF_TRUST_NTP);
    assert_int_equal(past.last_utc_ns, 5120 * TTF_NS_PER_S); /* slot 14 */
    assert_int_equal(past.last_run_ns, 14 * TTF_NS_PER_MIN);
    assert_int_equal(past.last_uncertainty_ns, 3);
    /* All of the last boot were given up, and some of the first: the last one that was taken counts. */
    past = ttf_timeline_past(s, (const int64_t[]){8, 10, 12}, 3, 15, "d");
    assert_int_equal(past.last_trust, TTF_TRUST_RTC);
    assert_int_equal(past.last_utc_ns, 1420 * TTF_NS_PER_S); /* slot 7 */
    snprintf(s[2].trust, sizeof(s[2].trust), "host");
    past = past_of(s, 3, "d", 15);
    assert_int_equal(past.last_trust, TTF_TRUST_RTC);
    assert_int_equal(past.last_utc_ns, 1540 * TTF_NS_PER_S); /* slot 9 */
    past = past_of(s, 3, "a", 15); /* of others than this boot a PC alone says something */
    assert_int_equal(past.last_trust, TTF_TRUST_HOST);
    assert_int_equal(past.last_utc_ns, 5120 * TTF_NS_PER_S);
}

/* The machine's, but syncing costs nothing, and it counts what is read. */
struct counting_io {
    struct ttf_io io; /* first */
    struct ttf_io_ops ops;
    int reads;
};

static int64_t count_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    ((struct counting_io *)io)->reads++;
    return ttf_io_posix()->ops->pread(io, file, buf, n, offset);
}

static int no_sync(struct ttf_io *io, int file, bool data_only)
{
    (void)io;
    (void)file;
    (void)data_only;
    return 0;
}

static void commit(struct ttf_writer *writer, int64_t index, int segment, enum ttf_result result)
{
    struct ttf_slot_record record;

    ttf_slot_record_init(&record);
    record.index = index;
    record.segment = segment;
    record.result = result;
    snprintf(record.reason, sizeof(record.reason), "for a test");
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
}

/* Slots 0 to 2, of which one was taken, and a pause; an outage of so many slots, in which nothing was. */
static void make_outage(struct ttf_io *io, const char *path, int64_t lost)
{
    struct ttf_segment s = segment("a", 0, 100);
    struct ttf_manifest manifest;
    struct ttf_writer *writer = NULL;

    memset(&manifest, 0, sizeof(manifest));
    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    plain_stream(&manifest, "linear-srgb");
    assert_int_equal(ttf_writer_create(io, path, &manifest, "# plan\n", "{}", &writer, NULL), 0);
    snprintf(s.trust, sizeof(s.trust), "none");
    for (int i = 0; i < 3; i++) {
        s.segment = i;
        assert_int_equal(ttf_writer_segment(writer, &s, NULL), 0);
        if (i == 0)
            for (int64_t k = 0; k < 3; k++)
                commit(writer, k, i, k == 1 ? TTF_RESULT_PAUSED : TTF_RESULT_MISSED);
        s.first_index = 3;
    }
    for (int64_t k = 3; k < 3 + lost; k++)
        commit(writer, k, 2, k % 2 == 0 ? TTF_RESULT_MISSED : TTF_RESULT_POWER);
    ttf_writer_close(writer);
}

static void slots_of_a_long_outage_are_not_read_one_by_one(void **state)
{
    struct counting_io c = {.io = {&c.ops}, .ops = *ttf_io_posix()->ops};
    char folder[] = "/tmp/ttf-timeline-XXXXXX", path[64], line[64];
    int64_t *taken_until = NULL;
    struct ttf_segment *segments = NULL;
    int n = 0;

    (void)state;
    c.ops.pread = count_pread;
    c.ops.sync = no_sync;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/d", folder);
    make_outage(&c.io, path, 1000);
    c.reads = 0;
    assert_int_equal(ttf_timeline_read(&c.io, path, &segments, &taken_until, &n, NULL), 0);
    assert_int_equal(n, 3);
    assert_int_equal(taken_until[0], 2); /* slot 1: it was paused, when it was due */
    assert_int_equal(taken_until[1], 3); /* its first index: it has no slot */
    assert_int_equal(taken_until[2], 3); /* none was taken */
    assert_in_range(c.reads, 1, 100);
    free(segments);
    free(taken_until);
    snprintf(line, sizeof(line), "rm -rf %s", folder);
    assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a test's */
}

/* A dataset with these segments, read as a run that goes on with it reads it. NULL: refused. */
static struct ttf_segment *read_again(const struct ttf_segment *s, int n)
{
    struct counting_io c = {.io = {&c.ops}, .ops = *ttf_io_posix()->ops};
    char folder[] = "/tmp/ttf-timeline-XXXXXX", path[64], line[64];
    struct ttf_segment *segments = NULL;
    int64_t *taken_until = NULL;
    struct ttf_manifest manifest;
    struct ttf_writer *writer = NULL;
    int got = 0, r;

    c.ops.sync = no_sync;
    memset(&manifest, 0, sizeof(manifest));
    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    plain_stream(&manifest, "linear-srgb");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/d", folder);
    assert_int_equal(ttf_writer_create(&c.io, path, &manifest, "# plan\n", "{}", &writer, NULL), 0);
    for (int i = 0; i < n; i++) {
        struct ttf_segment one = s[i];

        one.segment = i;
        assert_int_equal(ttf_writer_segment(writer, &one, NULL), 0);
    }
    ttf_writer_close(writer);
    r = ttf_timeline_read(&c.io, path, &segments, &taken_until, &got, NULL);
    assert_true(r == 0 || r == -EINVAL);
    assert_int_equal(got, r == 0 ? n : 0);
    free(taken_until);
    snprintf(line, sizeof(line), "rm -rf %s", folder);
    assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a test's */
    return segments;
}

/* A foreign dataset's, or one that somebody spoiled: whole, by its crc. */
static void times_beyond_all_clocks_are_not_reckoned_with(void **state)
{
    static const int64_t huge = INT64_MAX - 1;
    static const struct {
        int64_t origin_ns, interval_ns, first_index, run_ns;
    } refused[] = {{huge, 1, 0, 0}, {-huge, 1, 0, 0}, {0, huge, 0, 0},
                   {0, 1, huge, 0}, {0, 1, 0, huge},  {0, INT64_C(1) << 32, INT64_C(1) << 31, 0}};
    struct ttf_segment s[2] = {segment("a", 0, 100), segment("b", 10, 20)}, *got;

    (void)state;
    for (unsigned i = 0; i < sizeof(refused) / sizeof(refused[0]); i++) {
        struct ttf_segment one = s[0];

        one.origin_ns = refused[i].origin_ns;
        one.interval_ns = refused[i].interval_ns;
        one.first_index = refused[i].first_index;
        one.run_ns = refused[i].run_ns;
        snprintf(one.trust, sizeof(one.trust), "ntp");
        assert_null(read_again(&one, 1));
    }
    /* What may be unknown is. */
    snprintf(s[0].trust, sizeof(s[0].trust), "ntp");
    snprintf(s[1].trust, sizeof(s[1].trust), "ntp");
    s[0].origin_utc_ns = huge;
    s[0].uncertainty_ns = s[0].gap_ns = s[0].run_utc_ns = s[0].run_given_up_ns = huge;
    s[1].origin_utc_ns = -huge;
    got = read_again(s, 2);
    assert_non_null(got);
    assert_int_equal(got[0].origin_utc_ns, TTF_NS_UNKNOWN);
    assert_int_equal(got[0].uncertainty_ns, TTF_NS_UNKNOWN);
    assert_int_equal(got[0].gap_ns, TTF_NS_UNKNOWN);
    assert_int_equal(got[0].run_utc_ns, 0);
    assert_int_equal(got[0].run_gaps_ns, TTF_NS_UNKNOWN);
    assert_int_equal(got[1].origin_utc_ns, TTF_NS_UNKNOWN);
    free(got);
    /* A hundred years of slots, which a plan may ask for, are not. */
    s[1].first_index = INT64_C(100) * 366 * 24 * 60;
    got = read_again(s, 2);
    assert_non_null(got);
    free(got);
}

/* As far as it goes; there and back again, as often as it likes. */
static void a_clock_that_is_set_to_and_fro_adds_up_to_no_nonsense(void **state)
{
    static const int64_t ends[] = {-(INT64_C(1) << 60) + 1, (INT64_C(1) << 62) - 1};
    struct ttf_segment s[8];
    struct ttf_run_past past;

    (void)state;
    for (int i = 0; i < 8; i++) {
        char boot[2] = {(char)('a' + i), '\0'};

        s[i] = segment(boot, 10 * i, 100);
        if (i % 2 == 0)
            s[i].origin_utc_ns = ends[i / 2 % 2];
        snprintf(s[i].trust, sizeof(s[i].trust), i % 2 == 0 ? "ntp" : "none");
        s[i].gap_ns = i > 0 ? TTF_NS_UNKNOWN : 0;
    }
    past = past_of(s, 8, "x", 80);
    assert_true(past.gaps_ns > 0 && past.sure_gaps_ns == past.gaps_ns);
    assert_true(gaps_by(&past, "ntp", ends[1], true) >= past.gaps_ns);
}

static void a_due_time_beyond_all_time_is_never(void **state)
{
    struct ttf_grid grid = {0, INT64_MAX - 10, TTF_NS_PER_DAY};

    (void)state;
    assert_int_equal(ttf_grid_due_ns(&grid, 1), TTF_NS_NEVER);
    assert_int_equal(ttf_grid_due_ns(&grid, INT64_MAX / 2), TTF_NS_NEVER);
}

static void quantiles_of_errors_hold_at_both_ends(void **state)
{
    static struct ttf_quantile q;

    (void)state;
    assert_int_equal(ttf_quantile_ns(&q, 0.99), 0);
    ttf_quantile_add(&q, -5);
    assert_int_equal(ttf_quantile_ns(&q, 0), 5);
    assert_int_equal(ttf_quantile_ns(&q, 1), 5);
    /* An error of years: the largest there is, and never more than was seen. */
    ttf_quantile_add(&q, INT64_MAX);
    assert_int_equal(ttf_quantile_ns(&q, 0.5), 5);
    assert_true(ttf_quantile_ns(&q, 1) <= INT64_MAX && ttf_quantile_ns(&q, 1) > TTF_NS_PER_DAY);
    assert_int_equal(q.max_ns, INT64_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(over_segments_of_a_boot_its_clock_counts_over_a_boot_the_slots),
        cmocka_unit_test(a_dataset_that_a_run_moved_to_knows_what_came_before),
        cmocka_unit_test(a_run_s_time_is_only_said_where_the_grid_does_not_say_it),
        cmocka_unit_test(slot_0_is_where_the_last_segment_with_utc_says),
        cmocka_unit_test(what_a_pc_alone_says_of_the_past_is_told_apart),
        cmocka_unit_test(outages_without_a_clock_between_are_told_by_the_next_clock),
        cmocka_unit_test(what_lies_behind_a_pc_s_word_is_no_outage),
        cmocka_unit_test(slots_that_were_due_before_the_boot_were_given_up),
        cmocka_unit_test(slots_given_up_are_time_of_the_run_as_far_as_sure_clocks_say_so),
        cmocka_unit_test(slots_given_up_before_a_move_are_no_time_of_the_run_after_it),
        cmocka_unit_test(what_was_known_before_a_move_is_known_after_it),
        cmocka_unit_test(the_best_that_this_boot_knew_is_remembered),
        cmocka_unit_test(when_the_last_slot_of_the_boots_before_was_is_known),
        cmocka_unit_test(slots_of_a_long_outage_are_not_read_one_by_one),
        cmocka_unit_test(times_beyond_all_clocks_are_not_reckoned_with),
        cmocka_unit_test(a_clock_that_is_set_to_and_fro_adds_up_to_no_nonsense),
        cmocka_unit_test(a_due_time_beyond_all_time_is_never),
        cmocka_unit_test(quantiles_of_errors_hold_at_both_ends),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
