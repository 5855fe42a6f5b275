/* SPDX-License-Identifier: Apache-2.0 */
#include "idle.h"

#include <errno.h>

#include "calibrate.h"
#include "light.h"
#include "log.h"
#include "view.h"

#define LOOK_NS (250 * TTF_NS_PER_MS) /* how soon an end is seen while nothing runs */
#define WORK_NS (2 * TTF_NS_PER_MIN)  /* that devices may take over a picture: lamps warm up, too */

/* Of a run that waits, or waits to be tried again, as of one that captures. */
static void stop_by_button(struct daemon *d, int64_t generation)
{
    struct ttf_err err = {0};

    log_line(LOG_LEVEL_NOTICE, "button", "press=long");
    daemon_decided(orders_ended(d->orders, generation, ORDER_STOPPED, &err), &err);
}

/* A short press: the light says anew what is, beginning with a wink. */
static void look_at_button(struct daemon *d, int64_t generation, struct ttf_panel *panel,
                           enum ttf_led led)
{
    struct ttf_panel_event event;

    while (panel && ttf_panel_poll(panel, &event) == 1) {
        if (event.kind == TTF_PANEL_BUTTON_LONG)
            stop_by_button(d, generation);
        if (event.kind == TTF_PANEL_BUTTON_SHORT) {
            log_line(LOG_LEVEL_INFO, "button", "press=short");
            (void)!ttf_panel_led(panel, TTF_LED_CAPTURING);
            (void)!ttf_panel_led(panel, led);
        }
    }
}

/* A press that is under way is waited for: what it is to be is known after 3 s. */
static bool is_held(struct ttf_panel *panel)
{
    return panel && ttf_panel_held(panel) == 1;
}

static bool goes_on(struct daemon *d, int64_t generation)
{
    return !daemon_told_to_end(d) && orders_generation(d->orders) == generation;
}

struct working {
    struct daemon *d;
    int64_t generation;
    struct ttf_watchdog *watchdog;
};

/* The watchdog's time is that of a picture meanwhile; one that is done with anything else is ended by whoever decides. */
static int work(void *ctx, struct workshop_job *job, struct ttf_err *err)
{
    struct working *working = ctx;
    struct daemon *d = working->d;
    int r;

    __atomic_store_n(&d->view_stop, 0, __ATOMIC_SEQ_CST);
    if (!goes_on(
            d, working->generation)) /* decided before this, it has set nothing that is seen now */
        return ttf_err_set(err, -EBUSY, NULL, "a run has the devices");
    if (working->watchdog)
        manager_wait(&d->manager, WORK_NS);
    r = view_work(d, job, err);
    if (working->watchdog)
        (void)!ttf_watchdog_arm(working->watchdog, d->manager.watchdog_ns);
    return r;
}

/* No run has the devices here, but one may be asked for meanwhile: it ends the step. */
static bool calibrate_step(struct daemon *d, const struct working *working)
{
    __atomic_store_n(&d->view_stop, 0, __ATOMIC_SEQ_CST);
    return goes_on(d, working->generation) && calibrate_work(d, working->watchdog);
}

void idle(struct daemon *d, int64_t generation, int64_t for_ns, enum ttf_led led)
{
    int64_t now_ns = ttf_clock_now_ns(d->clock);
    int64_t until_ns = for_ns == TTF_NS_NEVER ? TTF_NS_NEVER : now_ns + for_ns;
    struct ttf_watchdog *watchdog;
    struct working working;
    struct ttf_panel *light;
    bool worked = false;
    int fed = 0;

    if (daemon_told_to_end(d))
        return;
    watchdog = manager_watchdog(&d->manager);
    working = (struct working){d, generation, watchdog};
    light = light_show(&d->board, d->clock, led);
    while (goes_on(d, generation) && (now_ns < until_ns || is_held(light))) {
        bool ends = until_ns > now_ns && until_ns - now_ns < LOOK_NS;

        if (!worked)
            (void)!ttf_gate_wait(d->wake, ends ? until_ns : now_ns + LOOK_NS);
        /* One at a time: who looks through the camera without an end keeps nothing else from being done. */
        worked = goes_on(d, generation) && workshop_work(d->workshop, work, &working);
        worked = (goes_on(d, generation) && calibrate_step(d, &working)) || worked;
        view_close(d, false);
        look_at_button(d, generation, light, led);
        if (watchdog && fed == 0)
            fed = ttf_watchdog_feed(watchdog);
        now_ns = ttf_clock_now_ns(d->clock);
    }
    ttf_panel_destroy(light);
    ttf_watchdog_destroy(watchdog);
}
