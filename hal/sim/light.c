/* SPDX-License-Identifier: Apache-2.0 */
#include "light.h"

#include <math.h>
#include <string.h>

#include "ttf/base/time.h"

static const double two_pi = 6.283185307179586;

static double seconds(int64_t ns)
{
    return (double)ns / (double)TTF_NS_PER_S;
}

void sim_light_init(struct sim_light *light, const struct ttf_sim_config *config,
                    const struct sim_faults *faults, int64_t from_ns)
{
    memset(light, 0, sizeof(*light));
    light->config = config;
    light->faults = faults;
    light->n = 1;
    light->segment[0].from_ns = from_ns;
}

static const struct sim_light_segment *segment_at(const struct sim_light *light, int64_t t)
{
    unsigned i = light->n - 1;

    while (i > 0 && light->segment[i].from_ns > t)
        i--;
    return &light->segment[i];
}

/* Distance from a segment's start, in time constants, not negative. */
static double since(const struct sim_light_segment *s, int64_t t, int64_t tau_ns)
{
    return t > s->from_ns ? (double)(t - s->from_ns) / (double)tau_ns : 0.0;
}

/* Relaxation towards 1 when lit and 0 when dark. */
static double warmth(const struct sim_light *light, const struct sim_light_segment *s, unsigned i,
                     int64_t t)
{
    double end = s->state.level[i] > 0 ? 1.0 : 0.0;

    return end + (s->warmth[i] - end) * exp(-since(s, t, light->config->lamps[i].warm_tau_ns));
}

/* The mean of it over from..to within one segment. */
static double warmth_mean(const struct sim_light *light, const struct sim_light_segment *s,
                          unsigned i, int64_t from, int64_t to)
{
    int64_t tau = light->config->lamps[i].warm_tau_ns;
    double end = s->state.level[i] > 0 ? 1.0 : 0.0;
    double span = (double)(to - from) / (double)tau;
    double decayed = span > 0 ? -expm1(-span) / span : 1.0;

    return end + (s->warmth[i] - end) * exp(-since(s, from, tau)) * decayed;
}

static double heat_end(const struct sim_light *light, const struct sim_light_state *state)
{
    double sum = 0.0;

    for (unsigned i = 0; i < light->config->n_lamps; i++)
        sum += light->config->lamps[i].heat_degc * state->level[i] / TTF_LAMP_FULL;
    return sum;
}

static double heat(const struct sim_light *light, const struct sim_light_segment *s, int64_t t)
{
    double end = heat_end(light, &s->state);

    return end + (s->heat_degc - end) * exp(-since(s, t, light->config->heat_tau_ns));
}

void sim_light_switch(struct sim_light *light, int64_t t, const struct sim_light_state *state)
{
    const struct sim_light_segment *last = &light->segment[light->n - 1];
    struct sim_light_segment next = {.from_ns = t, .state = *state};

    for (unsigned i = 0; i < light->config->n_lamps; i++)
        next.warmth[i] = warmth(light, last, i, t);
    next.heat_degc = heat(light, last, t);
    if (light->n == SIM_LIGHT_SEGMENTS) {
        const unsigned drop = SIM_LIGHT_SEGMENTS / 4;

        memmove(&light->segment[0], &light->segment[drop],
                (light->n - drop) * sizeof(light->segment[0]));
        light->n -= drop;
    }
    light->segment[light->n++] = next;
}

const struct sim_light_state *sim_light_now(const struct sim_light *light)
{
    return &light->segment[light->n - 1].state;
}

/* Loss with age and by fading: slow, so taken at one instant of an exposure. */
static double loss(const struct sim_light *light, unsigned i, int64_t t)
{
    double hours = seconds(t) / 3600.0;
    double kept = 1.0 - light->config->lamps[i].ageing_per_kh * hours / 1000.0;

    for (unsigned k = 0; k < light->faults->n; k++) {
        const struct ttf_fault *fault = &light->faults->fault[k];
        int64_t began;

        if (fault->kind != TTF_FAULT_LAMP_FADING || light->faults->target[k] != i)
            continue;
        began = sim_fault_began(light->faults, k, t);
        if (began != TTF_NS_NEVER)
            kept *= fmax(0.0, 1.0 - (double)fault->amount / 1000.0 * seconds(t - began) / 3600.0);
    }
    return fmax(0.0, kept);
}

static double output(const struct ttf_sim_lamp *lamp, unsigned level, double warm)
{
    return (double)level / TTF_LAMP_FULL *
           (lamp->cold_fraction + (1.0 - lamp->cold_fraction) * warm);
}

double sim_light_lamp(const struct sim_light *light, unsigned i, int64_t t)
{
    const struct sim_light_segment *s = segment_at(light, t);

    if (s->state.level[i] == 0)
        return 0.0;
    return output(&light->config->lamps[i], s->state.level[i], warmth(light, s, i, t)) *
           loss(light, i, t);
}

/* Mean of 1 + ripple cos(2 pi 2 f t) over from..to; whole half-periods of the mains give 1. */
static double ripple_mean(double ripple, double mains_hz, int64_t from, int64_t to)
{
    double cycles = 2.0 * mains_hz * seconds(from);
    double phase = two_pi * (cycles - floor(cycles));
    double span = two_pi * 2.0 * mains_hz * seconds(to - from);

    if (ripple == 0.0)
        return 1.0;
    if (span < 1e-9)
        return 1.0 + ripple * cos(phase);
    return 1.0 + ripple * (sin(phase + span) - sin(phase)) / span;
}

double sim_light_lamp_mean(const struct sim_light *light, unsigned i, int64_t from, int64_t to)
{
    const struct ttf_sim_lamp *lamp = &light->config->lamps[i];
    double sum = 0.0;
    unsigned k = light->n;

    /* From the newest segment backwards: an exposure lies in the last one or two. */
    while (k-- > 0) {
        const struct sim_light_segment *s = &light->segment[k];
        int64_t end = k + 1 < light->n ? light->segment[k + 1].from_ns : TTF_NS_NEVER;
        int64_t a = k > 0 && s->from_ns > from ? s->from_ns : from;
        int64_t b = end < to ? end : to;

        if (b > a && s->state.level[i] > 0)
            sum += output(lamp, s->state.level[i], warmth_mean(light, s, i, a, b)) *
                   ripple_mean(lamp->ripple, light->config->mains_hz, a, b) * (double)(b - a);
        if (s->from_ns <= from)
            break;
    }
    return sum / (double)(to - from) * loss(light, i, from + (to - from) / 2);
}

/* Since midnight UTC, in days. */
static double day_fraction(const struct sim_light *light, int64_t t)
{
    int64_t utc = light->config->start_utc_ns + t;

    return (double)(utc % TTF_NS_PER_DAY) / (double)TTF_NS_PER_DAY;
}

double sim_light_ambient(const struct sim_light *light, int64_t t)
{
    double sun = sin(two_pi * (day_fraction(light, t) - 0.25)); /* up from 06:00 to 18:00 */
    double sum = light->config->ambient;

    if (sun > 0.0)
        sum += light->config->daylight * sun;
    if (segment_at(light, t)->state.door_open)
        sum += SIM_DOOR_LIGHT;
    return sum;
}

double sim_light_temp_degc(const struct sim_light *light, int64_t t)
{
    /* Warmest at 15:00. */
    double room = light->config->ambient_degc +
                  light->config->day_swing_degc * sin(two_pi * (day_fraction(light, t) - 0.375));

    return room + heat(light, segment_at(light, t), t);
}

double sim_light_temp_bound_degc(const struct sim_light *light, int64_t t)
{
    const struct sim_light_segment *s = segment_at(light, t);

    return light->config->ambient_degc + fabs(light->config->day_swing_degc) +
           fmax(heat(light, s, t), heat_end(light, &s->state));
}
