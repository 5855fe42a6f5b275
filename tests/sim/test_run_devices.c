/* SPDX-License-Identifier: Apache-2.0 */
/* Devices that the box lacks, and drivers that answer with errors: what becomes of the run. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/hal/camera_backend.h"
#include "ttf/hal/lamps_backend.h"

/* ---- what a box may lack ---- */

static struct ttf_box whole;

static void camera_and_clock_alone(struct sim_run *run)
{
    whole = *run->box;
    run->box->lamps = NULL;
    run->box->sensors = NULL;
    run->box->panel = NULL;
    run->box->watchdog = NULL;
    run->box->power_lost = NULL;
}

static void give_back(struct sim_run *run)
{
    *run->box = whole;
}

static void a_camera_and_a_clock_are_box_enough(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.on_box = camera_and_clock_alone;
    run.at_end = give_back;
    run.plan.lamps = TTF_LAMPS_NONE;
    run.plan.settle_ns = 0;
    run.plan.shots[0].n_levels = 0;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 2, &record);
    assert_int_equal(record.n_sensors, 0);
    assert_int_equal(record.images[0].shots[0].n_lamps, 0);
    ttf_slot_record_free(&record);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* ---- lamps ---- */

static const struct ttf_lamps_ops *lamps_ops;
static struct ttf_lamps_ops bad_lamps;
static unsigned calls, stale_at, stale_to, acquired;
static unsigned acquire_fails_from, acquire_fails_to; /* the n-th on, up to; 0: never */

static int no_state(struct ttf_lamps *lamps, unsigned i, struct ttf_lamp_state *ret)
{
    (void)lamps;
    (void)i;
    (void)ret;
    return -EIO;
}

static int no_set(struct ttf_lamps *lamps, unsigned i, unsigned permille, struct ttf_err *err)
{
    if (permille > 0)
        return ttf_err_set(err, -EIO, "left", "the controller does not answer");
    return lamps_ops->set(lamps, i, permille, err);
}

static int goes_stale(struct ttf_lamps *lamps, int64_t alive_until_ns, struct ttf_err *err)
{
    calls++;
    if (stale_at > 0 && calls >= stale_at && calls <= stale_to)
        return -ESTALE;
    return lamps_ops->alive(lamps, alive_until_ns, err);
}

static int counted_acquire(struct ttf_lamps *lamps, int64_t alive_until_ns, struct ttf_err *err)
{
    acquired++;
    if (acquire_fails_from > 0 && acquired >= acquire_fails_from && acquired <= acquire_fails_to)
        return ttf_err_set(err, -EBUSY, "lamps", "somebody else has them");
    lamps_ops->release(lamps); /* a lease that has lapsed is none */
    return lamps_ops->acquire(lamps, alive_until_ns, err);
}

static void swap_lamps(struct sim_run *run)
{
    lamps_ops = run->box->lamps->ops;
    run->box->lamps->ops = &bad_lamps;
    bad_lamps.name = lamps_ops->name;
    bad_lamps.acquire = bad_lamps.acquire ? bad_lamps.acquire : lamps_ops->acquire;
    bad_lamps.alive = bad_lamps.alive ? bad_lamps.alive : lamps_ops->alive;
    bad_lamps.set = bad_lamps.set ? bad_lamps.set : lamps_ops->set;
    bad_lamps.state = bad_lamps.state ? bad_lamps.state : lamps_ops->state;
    bad_lamps.clear = lamps_ops->clear;
    bad_lamps.release = lamps_ops->release;
    bad_lamps.destroy = lamps_ops->destroy;
    calls = acquired = 0;
}

static void with_lamps(struct sim_run *run, struct ttf_lamps_ops ops)
{
    sim_run_init(run);
    run->on_box = swap_lamps;
    bad_lamps = ops;
    acquire_fails_from = acquire_fails_to = 0;
    stale_at = stale_to = 0;
}

static void lamps_that_tell_nothing_of_themselves_are_flagged_unknown(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    with_lamps(&run, (struct ttf_lamps_ops){.state = no_state});
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 2, &record);
    assert_int_equal(record.images[0].shots[0].n_lamps, 0);
    ttf_slot_record_free(&record);
    sim_run_expect_flag(&run, 0, "lamp-unknown");
    sim_run_expect_flag(&run, 5, "lamp-unknown");
    assert_int_equal(sim_run_events(&run, "lamp-trip", "lamp left does cannot be known"), 1);
    sim_run_finish(&run);
}

static void a_lamp_that_takes_no_command_is_told_once_and_flagged(void **state)
{
    struct sim_run run;

    (void)state;
    with_lamps(&run, (struct ttf_lamps_ops){.set = no_set});
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 0, "lamp-tripped");
    sim_run_expect_flag(&run, 5, "lamp-tripped");
    assert_in_range(sim_run_events(&run, "lamp-trip", "the controller does not answer"), 1, 6);
    sim_run_finish(&run);
}

static void a_lease_that_lapsed_is_taken_anew(void **state)
{
    struct sim_run run;

    (void)state;
    with_lamps(&run, (struct ttf_lamps_ops){.alive = goes_stale, .acquire = counted_acquire});
    stale_at = stale_to = 40;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(acquired, 2);
    assert_int_equal(sim_run_events(&run, "lamp-trip", "taken anew"), 1);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_lease_that_is_not_to_be_had_is_told_once_and_asked_for_until_it_is(void **state)
{
    struct sim_run run;

    (void)state;
    with_lamps(&run, (struct ttf_lamps_ops){.alive = goes_stale, .acquire = counted_acquire});
    stale_at = 40; /* the guardian is away for ten ticks */
    stale_to = 49;
    acquire_fails_from = 2;
    acquire_fails_to = 10;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(acquired, 11);
    assert_int_equal(sim_run_events(&run, "lamp-trip", "no new lease on the lamps"), 1);
    assert_int_equal(sim_run_events(&run, "lamp-trip", "taken anew"), 1);
    sim_run_expect(&run, "cccccc");
    sim_run_finish(&run);
}

static void lamps_that_somebody_else_has_refuse_the_run(void **state)
{
    struct sim_run run;

    (void)state;
    with_lamps(&run, (struct ttf_lamps_ops){.acquire = counted_acquire});
    acquire_fails_from = acquire_fails_to = 1;
    assert_int_equal(sim_run_boot(&run), -EBUSY);
    assert_string_equal(run.err.what, "somebody else has them");
    sim_run_finish(&run);
}

/* ---- watchdog, panel, sensors ---- */

static const struct ttf_watchdog_ops *watchdog_ops;
static struct ttf_watchdog_ops bad_watchdog;
static unsigned armed, fed;
static bool never_arms;

static int counted_arm(struct ttf_watchdog *watchdog, int64_t timeout_ns)
{
    armed++;
    return never_arms ? -EIO : watchdog_ops->arm(watchdog, timeout_ns);
}

/* Somebody disarmed it behind our back. */
static int feed_or_not(struct ttf_watchdog *watchdog)
{
    return ++fed == 5 ? -EPIPE : watchdog_ops->feed(watchdog);
}

static void swap_watchdog(struct sim_run *run)
{
    watchdog_ops = run->box->watchdog->ops;
    bad_watchdog = *watchdog_ops;
    bad_watchdog.arm = counted_arm;
    bad_watchdog.feed = feed_or_not;
    run->box->watchdog->ops = &bad_watchdog;
    armed = fed = 0;
}

static void a_watchdog_that_was_disarmed_is_armed_again(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.on_box = swap_watchdog;
    never_arms = false;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(armed, 2);
    assert_true(fed > 20);
    assert_int_equal(run.bites, 0);
    sim_run_expect(&run, "cccccc");
    sim_run_finish(&run);
}

static void without_a_watchdog_that_arms_the_run_goes_on(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.on_box = swap_watchdog;
    never_arms = true;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(fed, 0);
    sim_run_expect(&run, "cccccc");
    never_arms = false;
    sim_run_finish(&run);
}

static const struct ttf_panel_ops *panel_ops;
static struct ttf_panel_ops bad_panel;
static struct sim_run *on_panel;
static bool pressed;

/* At 150 s somebody presses the button, then holds it. */
static int press(struct ttf_panel *panel, struct ttf_panel_event *ret)
{
    int64_t now = ttf_sim_elapsed_ns(on_panel->box, ttf_clock_now_ns(on_panel->box->clock));

    (void)panel;
    if (now < 150 * TTF_NS_PER_S || pressed)
        return 0;
    ret->kind = now < 155 * TTF_NS_PER_S ? TTF_PANEL_BUTTON_SHORT : TTF_PANEL_BUTTON_LONG;
    ret->at_ns = ttf_clock_now_ns(on_panel->box->clock);
    pressed = ret->kind == TTF_PANEL_BUTTON_LONG;
    return 1;
}

/* Its events are lost; what it says when asked is true. */
static int door_from_130_to_170_s(struct ttf_panel *panel)
{
    int64_t now = ttf_sim_elapsed_ns(on_panel->box, ttf_clock_now_ns(on_panel->box->clock));

    (void)panel;
    return now > 130 * TTF_NS_PER_S && now < 170 * TTF_NS_PER_S;
}

static int no_event(struct ttf_panel *panel, struct ttf_panel_event *ret)
{
    (void)panel;
    (void)ret;
    return 0;
}

static int no_led(struct ttf_panel *panel, enum ttf_led led)
{
    (void)panel;
    (void)led;
    return -EIO;
}

static int no_door(struct ttf_panel *panel)
{
    (void)panel;
    return -ENOTSUP;
}

static void swap_panel(struct sim_run *run)
{
    on_panel = run;
    panel_ops = run->box->panel->ops;
    if (!bad_panel.led)
        bad_panel.led = panel_ops->led;
    if (!bad_panel.door)
        bad_panel.door = panel_ops->door;
    if (!bad_panel.poll)
        bad_panel.poll = panel_ops->poll;
    bad_panel.name = panel_ops->name;
    bad_panel.destroy = panel_ops->destroy;
    run->box->panel->ops = &bad_panel;
    pressed = false;
}

static void with_panel(struct sim_run *run, struct ttf_panel_ops ops)
{
    sim_run_init(run);
    run->on_box = swap_panel;
    bad_panel = ops;
}

static void a_button_that_is_held_ends_the_run_and_it_can_be_gone_on_with(void **state)
{
    struct sim_run run;

    (void)state;
    with_panel(&run, (struct ttf_panel_ops){.poll = press, .led = no_led, .door = no_door});
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.sealed);
    assert_int_equal(sim_run_events(&run, "button", "the run is to end"), 1);
    assert_int_equal(sim_run_events(&run, "stop", "ended as asked"), 1);
    sim_run_expect(&run, "ccc");
    run.on_box = NULL;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_door_whose_events_are_lost_is_noticed_all_the_same(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    with_panel(&run, (struct ttf_panel_ops){.poll = no_event, .door = door_from_130_to_170_s});
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "door-open");
    assert_int_equal(sim_run_events(&run, "door", "opened"), 1);
    assert_int_equal(sim_run_events(&run, "door", "closed"), 1);
    sim_run_record(&run, 3, &record);
    assert_string_equal(record.images[0].flags, "");
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static struct ttf_sensors_ops bad_sensors;

static int no_readings(struct ttf_sensors *sensors, struct ttf_reading ret[TTF_SENSORS_MAX],
                       struct ttf_err *err)
{
    (void)sensors;
    (void)ret;
    return ttf_err_set(err, -EIO, "i2c", "the bus hangs");
}

static void swap_sensors(struct sim_run *run)
{
    bad_sensors = *run->box->sensors->ops;
    bad_sensors.read = no_readings;
    run->box->sensors->ops = &bad_sensors;
}

static void sensors_that_cannot_be_read_cost_their_readings_only(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.on_box = swap_sensors;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 3, &record);
    assert_int_equal(record.n_sensors, 0);
    ttf_slot_record_free(&record);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_camera_and_a_clock_are_box_enough),
        cmocka_unit_test(lamps_that_tell_nothing_of_themselves_are_flagged_unknown),
        cmocka_unit_test(a_lamp_that_takes_no_command_is_told_once_and_flagged),
        cmocka_unit_test(a_lease_that_lapsed_is_taken_anew),
        cmocka_unit_test(a_lease_that_is_not_to_be_had_is_told_once_and_asked_for_until_it_is),
        cmocka_unit_test(lamps_that_somebody_else_has_refuse_the_run),
        cmocka_unit_test(a_watchdog_that_was_disarmed_is_armed_again),
        cmocka_unit_test(without_a_watchdog_that_arms_the_run_goes_on),
        cmocka_unit_test(a_button_that_is_held_ends_the_run_and_it_can_be_gone_on_with),
        cmocka_unit_test(a_door_whose_events_are_lost_is_noticed_all_the_same),
        cmocka_unit_test(sensors_that_cannot_be_read_cost_their_readings_only),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
