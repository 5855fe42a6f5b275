/* SPDX-License-Identifier: Apache-2.0 */
#include "light.h"

#include "ttf/base/time.h"

/* A wave that repeats, lit at first; `once`: dark for so long after it was told, then lit. Times in ms. */
static const struct {
    int64_t period, lit, once;
} WAVES[TTF_LED_COUNT] = {
    [TTF_LED_OFF] = {0, 0, 0},          [TTF_LED_IDLE] = {4000, 200, 0},
    [TTF_LED_CAPTURING] = {0, 0, 200}, /* told anew at each slot */
    [TTF_LED_WARNING] = {1000, 500, 0}, [TTF_LED_STOPPED] = {250, 125, 0},
};

bool light_at(enum ttf_led led, int64_t since_ns, int64_t now_ns, int64_t *ret_next_ns)
{
    int64_t period = WAVES[led].period * TTF_NS_PER_MS, lit = WAVES[led].lit * TTF_NS_PER_MS;
    int64_t once = WAVES[led].once * TTF_NS_PER_MS, at;

    *ret_next_ns = TTF_NS_NEVER;
    if (once > 0) {
        if (now_ns - since_ns < once)
            *ret_next_ns = since_ns + once;
        return now_ns - since_ns >= once;
    }
    if (period == 0)
        return false;
    at = (now_ns - since_ns) % period;
    *ret_next_ns = now_ns - at + (at < lit ? lit : period);
    return at < lit;
}
