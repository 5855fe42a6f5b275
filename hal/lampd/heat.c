/* SPDX-License-Identifier: Apache-2.0 */
/* heat.c: the thread that reads the box's temperature for the guardian. */
#include <errno.h>
#include <string.h>

#include "lampd_private.h"
#include "ttf/base/time.h"

#define EVERY_NS (2 * TTF_NS_PER_S)    /* a fifth of what may be missing */
#define ROUND_NS (100 * TTF_NS_PER_MS) /* how soon a stop is heard */
#define END_NS   (2 * TTF_NS_PER_S) /* after which a thread that did not hear it hangs in a driver */

static void read_once(struct lampd_heat *heat)
{
    struct ttf_reading readings[TTF_SENSORS_MAX];
    int n = ttf_sensors_read(heat->sensors, readings, NULL);

    for (int i = 0; i < n; i++) {
        const struct ttf_reading *r = &readings[i];

        if (!r->ok || r->kind != TTF_SENSOR_TEMP_MDEGC ||
            (heat->name && strcmp(r->name, heat->name) != 0))
            continue;
        pthread_mutex_lock(&heat->lock);
        heat->fresh = true;
        heat->temp_mdegc = (int32_t)r->value;
        heat->at_ns = r->at_ns;
        pthread_mutex_unlock(&heat->lock);
        return;
    }
}

static void *run(void *arg)
{
    struct lampd_heat *heat = arg;

    for (int64_t due = 0; !atomic_load(&heat->stop);) {
        int64_t now = ttf_clock_now_ns(heat->clock);

        if (now >= due) {
            read_once(heat);
            due = now + EVERY_NS;
        }
        (void)ttf_clock_wait_until(heat->clock, now + ROUND_NS);
    }
    ttf_clock_leave(heat->clock);
    atomic_store(&heat->ended, true);
    return NULL;
}

int lampd_heat_start(struct lampd_heat *heat, const struct ttf_lampd_config *config,
                     struct ttf_err *err)
{
    int r;

    heat->clock = config->clock;
    heat->sensors = config->sensors;
    heat->name = config->temp_sensor;
    if (!heat->sensors)
        return 0;
    pthread_mutex_init(&heat->lock, NULL);
    ttf_clock_join_for(heat->clock);
    r = pthread_create(&heat->thread, NULL, run, heat);
    if (r != 0) {
        ttf_clock_leave(heat->clock);
        pthread_mutex_destroy(&heat->lock);
        return ttf_err_set(err, -r, NULL, "no thread for the temperature");
    }
    heat->running = true;
    return 0;
}

int lampd_heat_take(struct lampd_heat *heat, int32_t *ret_mdegc, int64_t *ret_at_ns)
{
    int fresh;

    if (!heat->running)
        return 0;
    pthread_mutex_lock(&heat->lock);
    fresh = heat->fresh;
    heat->fresh = false;
    *ret_mdegc = heat->temp_mdegc;
    *ret_at_ns = heat->at_ns;
    pthread_mutex_unlock(&heat->lock);
    return fresh;
}

int lampd_heat_stop(struct lampd_heat *heat)
{
    int64_t until_ns;

    if (!heat->running)
        return 0;
    atomic_store(&heat->stop, true);
    until_ns = ttf_clock_now_ns(heat->clock) + END_NS;
    while (!atomic_load(&heat->ended)) {
        int64_t now_ns = ttf_clock_now_ns(heat->clock);

        if (now_ns >= until_ns)
            return -EBUSY;
        (void)ttf_clock_wait_until(heat->clock, now_ns + ROUND_NS / 10);
    }
    pthread_join(heat->thread, NULL);
    pthread_mutex_destroy(&heat->lock);
    heat->running = false;
    return 0;
}
