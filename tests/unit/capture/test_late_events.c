/* SPDX-License-Identifier: Apache-2.0 */
/* Events that wait for a storage, and those that found no place: told by their number, where they would stand. */
#include "cmocka_includes.h"

#include <stdio.h>
#include <string.h>

#include "events.h"
#include "late_events.h"
#include "ttf/base/time.h"

static struct ttf_job event_at(unsigned second)
{
    struct ttf_job event = {.kind = TTF_JOB_EVENT, .at_utc_ns = TTF_NS_UNKNOWN};

    event.at_ns = second * TTF_NS_PER_S;
    snprintf(event.event, sizeof(event.event), "door");
    snprintf(event.text, sizeof(event.text), "%u", second);
    return event;
}

static void keep(struct ttf_late_events *late, unsigned from, unsigned n)
{
    for (unsigned i = from; i < from + n; i++) {
        struct ttf_job event = event_at(i);

        ttf_late_events_keep(late, &event);
    }
}

static void sixty_four_wait_in_order(void **state)
{
    struct ttf_late_events late = {0};

    (void)state;
    keep(&late, 0, 64);
    assert_int_equal(ttf_late_events_all(&late).n, 64);
    for (unsigned i = 0; i < 64; i++) {
        assert_string_equal(late.wait[0].event, "door");
        assert_int_equal(late.wait[0].at_ns, i * TTF_NS_PER_S);
        ttf_late_events_drop_first(&late);
    }
    assert_int_equal(late.n, 0);
}

static void one_too_many_is_said(void **state)
{
    struct ttf_late_events late = {0};

    (void)state;
    keep(&late, 0, 65);
    assert_int_equal(late.n, 65);
    assert_string_equal(late.wait[64].event, "lost");
    assert_int_equal(late.wait[64].at_ns, 64 * TTF_NS_PER_S);
    assert_int_equal(late.wait[64].at_utc_ns, TTF_NS_UNKNOWN);
    assert_string_equal(
        late.wait[64].text,
        "1 event is lost, within 0 s: the storage took none, and no more could wait");
    assert_int_equal(ttf_late_events_all(&late).n, 65);
}

static void a_thousand_too_many_are_one_event(void **state)
{
    struct ttf_late_events late = {0};

    (void)state;
    keep(&late, 0, 1064);
    assert_int_equal(late.n, 65);
    assert_int_equal(late.wait[64].at_ns, 64 * TTF_NS_PER_S);
    assert_string_equal(
        late.wait[64].text,
        "1000 events are lost, within 999 s: the storage took none, and no more could wait");
    assert_int_equal(ttf_late_events_all(&late).n, 1064);
}

/* The storage takes a few and fails again: what is lost then stands behind what waits by then. */
static void two_gaps_are_told_each_in_its_place(void **state)
{
    struct ttf_late_events late = {0};

    (void)state;
    keep(&late, 0, 66);
    for (int i = 0; i < 10; i++)
        ttf_late_events_drop_first(&late);
    keep(&late, 100, 9 + 5);
    assert_int_equal(late.n, 65);
    assert_int_equal(late.wait[0].at_ns, 10 * TTF_NS_PER_S);
    assert_string_equal(late.wait[54].event, "lost");
    assert_int_equal(late.wait[54].lost.n, 2);
    assert_int_equal(late.wait[55].at_ns, 100 * TTF_NS_PER_S);
    assert_string_equal(late.wait[64].event, "lost");
    assert_int_equal(late.wait[64].lost.n, 5);
    assert_int_equal(ttf_late_events_all(&late).n, 54 + 2 + 9 + 5);
}

static void what_told_of_lost_ones_and_is_lost_itself_is_counted_as_they(void **state)
{
    struct ttf_late_events late = {0};
    const struct ttf_lost seven = {7, 70 * TTF_NS_PER_S, TTF_NS_UNKNOWN, 90 * TTF_NS_PER_S};
    struct ttf_job lost;

    (void)state;
    keep(&late, 0, 65);
    ttf_late_events_lost(&lost, &seven);
    ttf_late_events_keep(&late, &lost);
    assert_int_equal(late.wait[64].lost.n, 8);
    assert_int_equal(late.wait[64].at_ns, 64 * TTF_NS_PER_S);
    assert_non_null(strstr(late.wait[64].text, "8 events are lost, within 26 s"));
    assert_int_equal(ttf_late_events_all(&late).n, 64 + 8);
}

/* ---- on their way there ---- */

static void with_a_queue(struct ttf_queue *queue, struct ttf_events *events)
{
    struct ttf_stock_size size = {.n_images = 1, .n_shots = 1, .rooms = 1, .slots = 1};

    size.jobs[TTF_JOB_EVENT] = TTF_QUEUE_EVENTS_MAX;
    events->clock = ttf_clock_real_create();
    events->queue = queue;
    assert_non_null(events->clock);
    assert_int_equal(ttf_queue_init(queue, events->clock, &size), 0);
}

static void emit(struct ttf_events *events, unsigned n)
{
    for (unsigned i = 0; i < n; i++)
        ttf_events_emit(events, "door", "%u", i);
}

/* The committer hangs in the disk. */
static void events_beyond_a_crowded_queue_are_said_by_the_next_that_finds_a_place(void **state)
{
    struct ttf_queue queue;
    struct ttf_events events;
    struct ttf_job *job;

    (void)state;
    with_a_queue(&queue, &events);
    emit(&events, TTF_QUEUE_EVENTS_MAX + 3);
    assert_int_equal(ttf_queue_length(&queue), TTF_QUEUE_EVENTS_MAX);
    job = ttf_queue_pop(&queue);
    assert_int_equal(job->lost_before.n, 0);
    ttf_job_free(&queue, job);
    emit(&events, 3);
    for (unsigned i = 1; i < TTF_QUEUE_EVENTS_MAX; i++)
        ttf_job_free(&queue, ttf_queue_pop(&queue));
    job = ttf_queue_pop(&queue);
    assert_int_equal(job->lost_before.n, 3);
    assert_true(job->lost_before.first_ns <= job->lost_before.last_ns);
    assert_true(job->lost_before.last_ns <= job->at_ns);
    ttf_job_free(&queue, job);
    assert_int_equal(ttf_queue_take_lost(&queue).n, 2);
    assert_int_equal(ttf_queue_take_lost(&queue).n, 0);
    emit(&events, 1);
    job = ttf_queue_pop(&queue);
    assert_int_equal(job->lost_before.n, 0);
    ttf_job_free(&queue, job);
    ttf_queue_finish(&queue);
    ttf_clock_destroy(events.clock);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sixty_four_wait_in_order),
        cmocka_unit_test(one_too_many_is_said),
        cmocka_unit_test(a_thousand_too_many_are_one_event),
        cmocka_unit_test(two_gaps_are_told_each_in_its_place),
        cmocka_unit_test(what_told_of_lost_ones_and_is_lost_itself_is_counted_as_they),
        cmocka_unit_test(events_beyond_a_crowded_queue_are_said_by_the_next_that_finds_a_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
