/* SPDX-License-Identifier: Apache-2.0 */
/* test_panel.c: button, light and door on wires in a file that the tests move and look at. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "button.h"
#include "conformance/conformance.h"
#include "lampd_fixture.h"
#include "light.h"
#include "ttf/hal/clock_backend.h"
#include "ttf/hal/panel_lines.h"

#define MS(n) ((n)*TTF_NS_PER_MS)

/* ---- presses, without wires ---- */

/* What comes of a button in the time until then, looked at every ms; how many. */
static unsigned events_until(struct button *b, int64_t *now_ns, int64_t until_ns,
                             struct ttf_panel_event *last)
{
    unsigned n = 0;

    for (; *now_ns < until_ns; *now_ns += MS(1))
        n += button_look(b, *now_ns, last);
    return n;
}

static void a_press_is_told_once_it_is_let_go(void **state)
{
    struct ttf_panel_event e;
    struct button b;
    int64_t now = 0;

    (void)state;
    button_init(&b, false, 0);
    assert_int_equal(events_until(&b, &now, MS(100), &e), 0);
    button_level(&b, true, now);
    assert_int_equal(events_until(&b, &now, MS(1100), &e), 0);
    button_level(&b, false, now);
    assert_int_equal(events_until(&b, &now, MS(9000), &e), 1);
    assert_int_equal(e.kind, TTF_PANEL_BUTTON_SHORT);
    assert_int_equal(e.at_ns, MS(1100));
}

static void one_that_is_held_is_told_after_three_seconds_and_not_again(void **state)
{
    struct ttf_panel_event e;
    struct button b;
    int64_t now = 0;

    (void)state;
    button_init(&b, false, 0);
    button_level(&b, true, 0);
    assert_int_equal(events_until(&b, &now, MS(3000), &e), 0);
    assert_true(button_held(&b)); /* whoever waits for what it will be has to wait on */
    assert_int_equal(events_until(&b, &now, MS(3010), &e), 1);
    assert_false(button_held(&b));
    assert_int_equal(e.kind, TTF_PANEL_BUTTON_LONG);
    assert_int_equal(events_until(&b, &now, MS(8000), &e), 0);
    button_level(&b, false, now);
    assert_int_equal(events_until(&b, &now, MS(9000), &e), 0);
}

static void contacts_that_bounce_are_one_press(void **state)
{
    struct ttf_panel_event e;
    struct button b;
    unsigned n = 0;
    int64_t now = 0;

    (void)state;
    button_init(&b, false, 0);
    for (int i = 0; i < 20; i++) {
        button_level(&b, i % 2 == 0, now);
        n += events_until(&b, &now, now + MS(3), &e);
    }
    button_level(&b, true, now);
    n += events_until(&b, &now, now + MS(200), &e);
    for (int i = 0; i < 20; i++) {
        button_level(&b, i % 2 != 0, now);
        n += events_until(&b, &now, now + MS(3), &e);
    }
    button_level(&b, false, now);
    n += events_until(&b, &now, now + MS(200), &e);
    assert_int_equal(n, 1);
    assert_int_equal(e.kind, TTF_PANEL_BUTTON_SHORT);
    button_level(&b, true, now); /* a spark, not a finger */
    n = events_until(&b, &now, now + MS(20), &e);
    button_level(&b, false, now);
    assert_int_equal(n + events_until(&b, &now, now + MS(5000), &e), 0);
}

static void a_press_whose_end_was_missed_is_none(void **state)
{
    struct ttf_panel_event e;
    struct button b;
    int64_t now = 0;

    (void)state;
    button_init(&b, false, 0);
    button_level(&b, true, now);
    assert_int_equal(events_until(&b, &now, MS(2999), &e), 0);
    button_missed(&b, false, now);
    assert_int_equal(events_until(&b, &now, MS(9000), &e), 0);
    assert_false(button_held(&b));
    button_level(&b, true, now); /* the next one is one */
    assert_int_equal(events_until(&b, &now, MS(12500), &e), 1);
    assert_int_equal(e.kind, TTF_PANEL_BUTTON_LONG);
}

static void a_button_that_is_jammed_at_the_start_is_no_press(void **state)
{
    struct ttf_panel_event e;
    struct button b;
    int64_t now = 0;

    (void)state;
    button_init(&b, true, 0);
    assert_int_equal(events_until(&b, &now, MS(9000), &e), 0);
    button_level(&b, false, now);
    assert_int_equal(events_until(&b, &now, MS(9500), &e), 0);
    button_level(&b, true, now);
    assert_int_equal(events_until(&b, &now, MS(13000), &e), 1);
}

/* How often the light changes within 8 s, and for how many ms it is lit. */
static unsigned flashes(enum ttf_led led, unsigned *ret_lit_ms)
{
    unsigned changes = 0, lit = 0;
    int64_t next = 0;
    bool before = false;

    for (int64_t t = 0; t < MS(8000); t += MS(1)) {
        bool now = light_at(led, 0, t, &next);

        if (t > 0 && now != before)
            changes++;
        assert_true(next > t);
        lit += now;
        before = now;
    }
    *ret_lit_ms = lit;
    return changes;
}

static void each_state_of_the_box_looks_different(void **state)
{
    unsigned lit;

    (void)state;
    assert_int_equal(flashes(TTF_LED_OFF, &lit), 0);
    assert_int_equal(lit, 0);
    assert_int_equal(flashes(TTF_LED_IDLE, &lit), 3); /* a pulse every 4 s */
    assert_int_equal(lit, 400);
    assert_int_equal(flashes(TTF_LED_CAPTURING, &lit), 1); /* a wink, then steady */
    assert_int_equal(lit, 7800);
    assert_int_equal(flashes(TTF_LED_WARNING, &lit), 15);
    assert_int_equal(flashes(TTF_LED_STOPPED, &lit), 63);
}

/* ---- on wires: the button is wire 0, the light wire 1 of the panel's file ---- */

struct bench {
    struct lampd_fixture *guardian;
    char path[128];
    struct ttf_lamps *lamps;
    struct ttf_panel *panel;
};

static void write_wire(const struct bench *b, unsigned i, char level)
{
    int fd = open(b->path, O_WRONLY | O_CLOEXEC);

    assert_true(fd >= 0 && pwrite(fd, &level, 1, i) == 1);
    (void)close(fd);
}

static char read_wire(const struct bench *b, unsigned i)
{
    char level = '?';
    int fd = open(b->path, O_RDONLY | O_CLOEXEC);

    assert_true(fd >= 0 && pread(fd, &level, 1, i) == 1);
    (void)close(fd);
    return level;
}

static int make_panel(struct bench *b)
{
    const struct ttf_line_spec specs[2] = {{.label = "button", .input = true, .line = "0"},
                                           {.label = "light", .line = "1"}};
    struct ttf_panel_lines_config config = {
        .button = 0, .led = 1, .clock = b->guardian->clock, .lamps = b->lamps};
    int r = ttf_lines_file_create(b->path, specs, 2, &config.lines, NULL);

    return r < 0 ? r : ttf_panel_lines_create(&config, &b->panel, NULL);
}

static int setup(void **state)
{
    struct bench *b = calloc(1, sizeof(*b));

    if (!b)
        return -1;
    b->guardian = lampd_fixture_make();
    lampd_fixture_start(b->guardian);
    snprintf(b->path, sizeof(b->path), "%s/panel", b->guardian->folder);
    assert_int_equal(
        ttf_lamps_lampd_create(b->guardian->socket, b->guardian->clock, &b->lamps, NULL), 0);
    assert_int_equal(make_panel(b), 0);
    *state = b;
    return 0;
}

static int teardown(void **state)
{
    struct bench *b = *state;

    ttf_lamps_destroy(b->lamps);
    ttf_panel_destroy(b->panel);
    (void)unlink(b->path);
    lampd_fixture_free(b->guardian);
    free(b);
    return 0;
}

static void nap(const struct bench *b, int64_t ns)
{
    (void)ttf_clock_wait_until(b->guardian->clock, ttf_clock_now_ns(b->guardian->clock) + ns);
}

/* Within 20 s, on a machine that is busy. */
static struct ttf_panel_event next_event(struct bench *b)
{
    struct ttf_panel_event event = {0};

    for (int i = 0; i < 2000; i++) {
        if (ttf_panel_poll(b->panel, &event) == 1)
            return event;
        nap(b, MS(10));
    }
    fail_msg("nothing happened");
    return event;
}

static void wait_for_light(const struct bench *b, char level)
{
    for (int i = 0; i < 2000 && read_wire(b, 1) != level; i++)
        nap(b, MS(10));
    assert_int_equal(read_wire(b, 1), level);
}

static void a_finger_on_the_button_is_felt(void **state)
{
    struct bench *b = *state;
    struct ttf_panel_event none;

    assert_int_equal(ttf_panel_poll(b->panel, &none), 0);
    write_wire(b, 0, '1');
    nap(b, MS(300));
    assert_int_equal(ttf_panel_poll(b->panel, &none), 0);
    write_wire(b, 0, '0');
    assert_int_equal(next_event(b).kind, TTF_PANEL_BUTTON_SHORT);
    assert_int_equal(ttf_panel_poll(b->panel, &none), 0);
}

static void the_light_follows_and_ends_dark(void **state)
{
    struct bench *b = *state;

    assert_int_equal(read_wire(b, 1), '0');
    assert_int_equal(ttf_panel_led(b->panel, TTF_LED_CAPTURING), 0);
    wait_for_light(b, '1');
    assert_int_equal(ttf_panel_led(b->panel, TTF_LED_OFF), 0);
    wait_for_light(b, '0');
    assert_int_equal(ttf_panel_led(b->panel, TTF_LED_CAPTURING), 0);
    wait_for_light(b, '1');
    ttf_panel_destroy(b->panel);
    b->panel = NULL;
    assert_int_equal(read_wire(b, 1), '0');
}

static void a_door_that_moved_unseen_is_told_with_its_instants(void **state)
{
    struct bench *b = *state;
    int64_t before = ttf_clock_now_ns(b->guardian->clock);
    struct ttf_panel_event opened, closed, none;

    assert_int_equal(ttf_panel_door(b->panel), 0);
    /* Nobody asks between: the guardian alone felt it. */
    move_wire(b->guardian, 2, '1');
    for (int i = 0; i < 2000 && ttf_panel_door(b->panel) != 1; i++)
        nap(b, MS(10));
    move_wire(b->guardian, 2, '0');
    for (int i = 0; i < 2000 && ttf_panel_door(b->panel) != 0; i++)
        nap(b, MS(10));
    opened = next_event(b);
    closed = next_event(b);
    assert_int_equal(opened.kind, TTF_PANEL_DOOR_OPENED);
    assert_int_equal(closed.kind, TTF_PANEL_DOOR_CLOSED);
    assert_true(before <= opened.at_ns && opened.at_ns < closed.at_ns);
    assert_true(closed.at_ns <= ttf_clock_now_ns(b->guardian->clock));
    assert_int_equal(ttf_panel_poll(b->panel, &none), 0);
}

static void a_chip_that_vanishes_and_comes_back_is_found_again(void **state)
{
    struct bench *b = *state;

    assert_int_equal(ttf_panel_led(b->panel, TTF_LED_CAPTURING), 0);
    wait_for_light(b, '1');
    assert_int_equal(unlink(b->path), 0);
    nap(b, MS(200));
    /* Another file of that name: the adapter is plugged in again. */
    (void)close(open(b->path, O_CREAT | O_WRONLY | O_CLOEXEC, 0644));
    for (int i = 0; i < 2000; i++) {
        char level = 0;
        int fd = open(b->path, O_RDONLY | O_CLOEXEC);

        if (pread(fd, &level, 1, 1) == 1 && level == '1')
            i = 2000;
        (void)close(fd);
        nap(b, MS(10));
    }
    assert_int_equal(read_wire(b, 1), '1');
}

static void a_panel_without_wires_has_the_door_alone(void **state)
{
    struct bench *b = *state;
    struct ttf_panel_lines_config config = {
        .button = -1, .led = -1, .clock = b->guardian->clock, .lamps = b->lamps};
    struct ttf_panel *panel;
    struct ttf_panel_event none;

    assert_int_equal(ttf_panel_lines_create(&config, &panel, NULL), 0);
    assert_int_equal(ttf_panel_door(panel), 0);
    assert_int_equal(ttf_panel_led(panel, TTF_LED_IDLE), -ENOTSUP);
    assert_int_equal(ttf_panel_poll(panel, &none), 0);
    ttf_panel_destroy(panel);
    config.lamps = NULL;
    assert_int_equal(ttf_panel_lines_create(&config, &panel, NULL), 0);
    assert_int_equal(ttf_panel_door(panel), -ENOTSUP);
    ttf_panel_destroy(panel);
    config.button = 0;
    assert_int_equal(ttf_panel_lines_create(&config, &panel, NULL), -EINVAL);
}

/* ---- on a line whose edges get lost, in time that the test makes ---- */

struct lossy {
    struct ttf_lines base; /* first: downcast by address */
    int fd;                /* readable while there is something to feel */
    _Atomic bool level;
    _Atomic unsigned edges, felt; /* alternating, up first */
    _Atomic unsigned rounds;      /* in which the panel found no edge more */
};

static int lossy_set(struct ttf_lines *base, unsigned i, unsigned permille)
{
    (void)base;
    (void)i;
    (void)permille;
    return 0;
}

static int lossy_get(struct ttf_lines *base, unsigned i)
{
    (void)i;
    return ((struct lossy *)base)->level;
}

static int lossy_fd(const struct ttf_lines *base)
{
    return ((const struct lossy *)base)->fd;
}

static int lossy_event(struct ttf_lines *base, struct ttf_line_event *ret)
{
    struct lossy *l = (struct lossy *)base;
    uint64_t count;

    if (l->felt < l->edges) {
        *ret = (struct ttf_line_event){.i = 0, .active = l->felt++ % 2 == 0};
        return 1;
    }
    (void)!read(l->fd, &count, sizeof(count));
    l->rounds++;
    return 0;
}

static int lossy_reopen(struct ttf_lines *base, struct ttf_err *err)
{
    (void)base;
    (void)err;
    return 0;
}

static void lossy_destroy(struct ttf_lines *base)
{
    (void)base;
}

static const struct ttf_lines_ops LOSSY = {.name = "lossy",
                                           .set = lossy_set,
                                           .get = lossy_get,
                                           .fd = lossy_fd,
                                           .event = lossy_event,
                                           .reopen = lossy_reopen,
                                           .destroy = lossy_destroy};

/* A clock that stands until the test moves it. */
struct hand {
    struct ttf_clock base; /* first: downcast by address */
    _Atomic int64_t now_ns;
};

static int64_t hand_now(struct ttf_clock *clock)
{
    return ((struct hand *)clock)->now_ns;
}

static const struct ttf_clock_ops HAND = {.name = "by hand", .now_ns = hand_now};

struct lonely {
    struct lossy lines;
    struct hand clock;
    struct ttf_panel *panel;
};

static int lonely_setup(void **state)
{
    struct lonely *l = calloc(1, sizeof(*l));
    struct ttf_panel_lines_config config = {.button = 0, .led = -1};

    if (!l)
        return -1;
    l->lines.base = (struct ttf_lines){.ops = &LOSSY, .n = 1};
    l->lines.base.spec[0] = (struct ttf_line_spec){.label = "button", .input = true};
    l->lines.fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    l->clock.base.ops = &HAND;
    l->clock.now_ns = TTF_NS_PER_S;
    config.lines = &l->lines.base;
    config.clock = &l->clock.base;
    *state = l;
    return l->lines.fd < 0 ? -1 : ttf_panel_lines_create(&config, &l->panel, NULL);
}

static int lonely_teardown(void **state)
{
    struct lonely *l = *state;

    ttf_panel_destroy(l->panel);
    (void)close(l->lines.fd);
    free(l);
    return 0;
}

/* The first round may have begun before; the second feels all there is; in the third what came of it was said. */
static void let_it_feel(struct lonely *l)
{
    for (unsigned n = 0; n < 3; n++) {
        const uint64_t one = 1;
        unsigned before = l->lines.rounds;

        assert_int_equal(write(l->lines.fd, &one, sizeof(one)), sizeof(one));
        while (l->lines.rounds == before)
            (void)sched_yield();
    }
}

/* Many edges at once, of which the kernel kept the first ones only; the wire came to rest at this level. */
static void edges_of_which_some_are_kept(struct lonely *l, unsigned kept, bool level)
{
    l->lines.level = level;
    l->lines.felt = 0;
    l->lines.edges = kept;
    let_it_feel(l);
}

static void a_burst_whose_last_edges_the_kernel_dropped_leaves_no_button_down(void **state)
{
    struct lonely *l = *state;
    struct ttf_panel_event event;

    edges_of_which_some_are_kept(l, 15, false);
    assert_int_equal(ttf_panel_held(l->panel), 0);
    for (unsigned n = 0; n < 80; n++) {
        l->clock.now_ns += MS(50);
        let_it_feel(l);
    }
    assert_int_equal(ttf_panel_poll(l->panel, &event), 0);
}

static void the_wire_is_asked_before_a_run_is_ended(void **state)
{
    struct lonely *l = *state;
    struct ttf_panel_event event;

    edges_of_which_some_are_kept(l, 1, true);
    l->clock.now_ns += MS(40);
    let_it_feel(l);
    assert_int_equal(ttf_panel_held(l->panel), 1);
    l->lines.level = false; /* and no edge tells */
    l->clock.now_ns += MS(3000);
    let_it_feel(l);
    l->clock.now_ns += MS(100);
    let_it_feel(l);
    assert_int_equal(ttf_panel_poll(l->panel, &event), 0);
    assert_int_equal(ttf_panel_held(l->panel), 0);
    /* A finger that stays is one. */
    edges_of_which_some_are_kept(l, 1, true);
    l->clock.now_ns += MS(40);
    let_it_feel(l);
    l->clock.now_ns += MS(3000);
    let_it_feel(l);
    assert_int_equal(ttf_panel_poll(l->panel, &event), 1);
    assert_int_equal(event.kind, TTF_PANEL_BUTTON_LONG);
}

/* ---- the suite ---- */

static void destroy_box(struct ttf_box *box)
{
    void *state = box->box_private;

    (void)teardown(&state);
}

static int make(struct ttf_box *ret)
{
    void *state = NULL;

    if (setup(&state) < 0 || !state)
        return -1;
    *ret = (struct ttf_box){.box_private = state, .destroy = destroy_box};
    ret->clock = ((struct bench *)state)->guardian->clock;
    ret->panel = ((struct bench *)state)->panel;
    return 0;
}

int main(void)
{
#define ON_WIRES(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
#define IN_TIME(test)  cmocka_unit_test_setup_teardown(test, lonely_setup, lonely_teardown)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_press_is_told_once_it_is_let_go),
        cmocka_unit_test(one_that_is_held_is_told_after_three_seconds_and_not_again),
        cmocka_unit_test(contacts_that_bounce_are_one_press),
        cmocka_unit_test(a_press_whose_end_was_missed_is_none),
        cmocka_unit_test(a_button_that_is_jammed_at_the_start_is_no_press),
        cmocka_unit_test(each_state_of_the_box_looks_different),
        ON_WIRES(a_finger_on_the_button_is_felt),
        ON_WIRES(the_light_follows_and_ends_dark),
        ON_WIRES(a_door_that_moved_unseen_is_told_with_its_instants),
        ON_WIRES(a_chip_that_vanishes_and_comes_back_is_found_again),
        ON_WIRES(a_panel_without_wires_has_the_door_alone),
        IN_TIME(a_burst_whose_last_edges_the_kernel_dropped_leaves_no_button_down),
        IN_TIME(the_wire_is_asked_before_a_run_is_ended),
    };
    const struct conformance_factory lines = {"lines", make};

    return cmocka_run_group_tests(tests, NULL, NULL) + conformance_panel(&lines);
}
