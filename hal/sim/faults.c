/* SPDX-License-Identifier: Apache-2.0 */
#include "faults.h"

#include <errno.h>
#include <string.h>

#include "ttf/base/time.h"

/* How far ahead a random power cut is looked for. */
#define CUT_HORIZON_MINUTES (INT64_C(400) * 24 * 60)

static const struct {
    const char *name;
    int64_t amount;   /* where the fault says 0 */
    int64_t duration; /* where the fault says 0, of kinds that last; TTF_NS_NEVER: for good */
} kinds[TTF_FAULT_KIND_COUNT] = {
    [TTF_FAULT_FRAME_LATE] = {"frame-late", 500, 0},
    [TTF_FAULT_FRAME_SHORT] = {"frame-short", 500, 0},
    [TTF_FAULT_FRAME_CORRUPT] = {"frame-corrupt", 0, 0},
    [TTF_FAULT_FRAME_MISSING] = {"frame-missing", 0, 0},
    [TTF_FAULT_CAMERA_HANG] = {"camera-hang", 0, 10 * TTF_NS_PER_MIN},
    [TTF_FAULT_WRONG_SETTINGS] = {"wrong-settings", 250, 0},
    [TTF_FAULT_LAMP_DEAD] = {"lamp-dead", 0, TTF_NS_NEVER},
    [TTF_FAULT_LAMP_FADING] = {"lamp-fading", 50, TTF_NS_NEVER},
    [TTF_FAULT_LAMP_STUCK] = {"lamp-stuck", 0, TTF_NS_NEVER},
    [TTF_FAULT_SENSOR_GONE] = {"sensor-gone", 0, 0},
    [TTF_FAULT_DISK_FULL] = {"disk-full", 0, 0},
    [TTF_FAULT_IO_ERROR] = {"io-error", 0, 0},
    [TTF_FAULT_CLOCK_STEP] = {"clock-step", 3600, 0},
    [TTF_FAULT_POWER_CUT] = {"power-cut", 0, 0},
    [TTF_FAULT_DOOR_OPEN] = {"door-open", 0, 10 * TTF_NS_PER_S},
    [TTF_FAULT_READ_ONLY] = {"read-only", 0, TTF_NS_NEVER},
};

const char *ttf_fault_name(enum ttf_fault_kind kind)
{
    return (unsigned)kind < TTF_FAULT_KIND_COUNT ? kinds[kind].name : NULL;
}

int ttf_fault_find(const char *name)
{
    for (int i = 0; i < TTF_FAULT_KIND_COUNT; i++)
        if (strcmp(kinds[i].name, name) == 0)
            return i;
    return -ENOENT;
}

/* The finaliser of splitmix64 (Steele, Lea, Flood 2014), folded over three words. */
uint64_t sim_mix(uint64_t a, uint64_t b, uint64_t c)
{
    const uint64_t words[3] = {a, b, c};
    uint64_t x = 0;

    for (int i = 0; i < 3; i++) {
        x += words[i] + UINT64_C(0x9e3779b97f4a7c15);
        x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
        x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
        x ^= x >> 31;
    }
    return x;
}

int sim_fault_target(const struct ttf_sim_config *config, const struct ttf_fault *fault)
{
    unsigned n = 0;

    switch (fault->kind) {
    case TTF_FAULT_LAMP_DEAD:
    case TTF_FAULT_LAMP_FADING:
    case TTF_FAULT_LAMP_STUCK:
        n = config->n_lamps;
        for (unsigned i = 0; i < n; i++)
            if (!fault->target[0] || strcmp(fault->target, config->lamps[i].info.name) == 0)
                return (int)i;
        return -1;
    case TTF_FAULT_SENSOR_GONE:
        n = config->n_sensors;
        for (unsigned i = 0; i < n; i++)
            if (!fault->target[0] || strcmp(fault->target, config->sensors[i].name) == 0)
                return (int)i;
        return -1;
    case TTF_FAULT_DISK_FULL:
    case TTF_FAULT_IO_ERROR:
    case TTF_FAULT_READ_ONLY:
        if (!fault->target[0])
            return 0;
        return strcmp(fault->target, "first") == 0    ? 1
               : strcmp(fault->target, "second") == 0 ? 2
                                                      : -1;
    default:
        return fault->target[0] ? -1 : 0;
    }
}

/* A hang that something cures lasts until it is cured. */
static int64_t lasts_by_default(const struct ttf_fault *fault)
{
    if (fault->kind == TTF_FAULT_CAMERA_HANG && fault->amount < 3)
        return TTF_NS_NEVER;
    return kinds[fault->kind].duration;
}

void sim_faults_init(struct sim_faults *f, const struct ttf_sim_config *config)
{
    memset(f, 0, sizeof(*f));
    f->seed = config->seed;
    f->power_on_ns = config->power_on_ns;
    f->n = config->n_faults;
    for (unsigned i = 0; i < f->n; i++) {
        struct ttf_fault *fault = &f->fault[i];
        int target = sim_fault_target(config, &config->faults[i]);

        *fault = config->faults[i];
        f->target[i] = target > 0 ? (unsigned)target : 0;
        if (fault->amount == 0)
            fault->amount = fault->kind == TTF_FAULT_POWER_CUT
                                ? (config->outage_ns + TTF_NS_PER_S - 1) / TTF_NS_PER_S
                                : kinds[fault->kind].amount;
        if (fault->duration_ns == 0 && fault->rate_per_million == 0)
            fault->duration_ns = lasts_by_default(fault);
        f->spent[i] = fault->rate_per_million == 0 && fault->duration_ns == 0 &&
                      fault->at_ns < f->power_on_ns;
    }
}

static bool draw(const struct sim_faults *f, unsigned i, uint64_t key)
{
    uint64_t rate = f->fault[i].rate_per_million;

    return rate > 0 && sim_mix(f->seed ^ UINT64_C(0xfa017), i, key) % 1000000 < rate;
}

bool sim_fault_at_minute(const struct sim_faults *f, unsigned i, int64_t minute)
{
    return draw(f, i, (uint64_t)minute);
}

static int64_t minute_of(int64_t t)
{
    return t / TTF_NS_PER_MIN;
}

/* A lasting fault at random begins with a whole minute and lasts whole minutes. */
static int64_t minutes_lasting(const struct ttf_fault *fault)
{
    int64_t n = fault->duration_ns / TTF_NS_PER_MIN + (fault->duration_ns % TTF_NS_PER_MIN > 0);

    return n > 0 ? n : 1;
}

bool sim_fault_active(const struct sim_faults *f, unsigned i, int64_t t)
{
    return sim_fault_began(f, i, t) != TTF_NS_NEVER;
}

int64_t sim_fault_began(const struct sim_faults *f, unsigned i, int64_t t)
{
    const struct ttf_fault *fault = &f->fault[i];

    if (fault->rate_per_million == 0)
        return t >= fault->at_ns && t - fault->at_ns < fault->duration_ns ? fault->at_ns
                                                                          : TTF_NS_NEVER;
    for (int64_t k = minutes_lasting(fault) - 1; k >= 0; k--) {
        int64_t minute = minute_of(t) - k;

        if (minute >= 0 && minute * TTF_NS_PER_MIN >= fault->at_ns && draw(f, i, (uint64_t)minute))
            return minute * TTF_NS_PER_MIN;
    }
    return TTF_NS_NEVER;
}

int64_t sim_fault_ends(const struct sim_faults *f, unsigned i, int64_t began)
{
    const struct ttf_fault *fault = &f->fault[i];
    int64_t lasts =
        fault->rate_per_million > 0 ? minutes_lasting(fault) * TTF_NS_PER_MIN : fault->duration_ns;

    return lasts < TTF_NS_NEVER - began ? began + lasts : TTF_NS_NEVER;
}

int64_t sim_fault_next_change(const struct sim_faults *f, unsigned i, int64_t t)
{
    const struct ttf_fault *fault = &f->fault[i];

    if (fault->rate_per_million > 0)
        return (minute_of(t) + 1) * TTF_NS_PER_MIN;
    if (t < fault->at_ns)
        return fault->at_ns;
    return t < sim_fault_ends(f, i, fault->at_ns) ? sim_fault_ends(f, i, fault->at_ns)
                                                  : TTF_NS_NEVER;
}

/* Strikes the opportunity at t, whose random key is given? */
static bool strikes(struct sim_faults *f, unsigned i, int64_t t, uint64_t key)
{
    const struct ttf_fault *fault = &f->fault[i];

    if (t < fault->at_ns)
        return false;
    if (fault->rate_per_million > 0)
        return (fault->duration_ns == 0 || t - fault->at_ns < fault->duration_ns) &&
               draw(f, i, key);
    if (fault->duration_ns > 0)
        return t - fault->at_ns < fault->duration_ns;
    if (f->spent[i])
        return false;
    f->spent[i] = true;
    return true;
}

bool sim_fault_on_frame(struct sim_faults *f, enum ttf_fault_kind kind, int64_t t,
                        int64_t *ret_amount)
{
    for (unsigned i = 0; i < f->n; i++) {
        if (f->fault[i].kind != kind || !strikes(f, i, t, (uint64_t)t))
            continue;
        if (ret_amount)
            *ret_amount = f->fault[i].amount;
        return true;
    }
    return false;
}

bool sim_fault_on_sensor(struct sim_faults *f, unsigned sensor, int64_t t)
{
    for (unsigned i = 0; i < f->n; i++) {
        if (f->fault[i].kind != TTF_FAULT_SENSOR_GONE || f->target[i] != sensor)
            continue;
        /* At random it is gone for whole minutes: for this reader as for the guardian. */
        if (f->fault[i].rate_per_million > 0 ? sim_fault_active(f, i, t) : strikes(f, i, t, 0))
            return true;
    }
    return false;
}

static bool of_storage(const struct sim_faults *f, unsigned i, unsigned storage)
{
    return f->target[i] == 0 || f->target[i] == storage + 1;
}

bool sim_fault_storage_lasts(const struct sim_faults *f, unsigned i, unsigned storage, int64_t t)
{
    const struct ttf_fault *fault = &f->fault[i];

    return of_storage(f, i, storage) && fault->rate_per_million == 0 && t >= fault->at_ns &&
           t - fault->at_ns < fault->duration_ns;
}

bool sim_fault_on_storage(struct sim_faults *f, enum ttf_fault_kind kind, unsigned storage,
                          int64_t t)
{
    uint64_t key = sim_mix((uint64_t)f->power_on_ns, f->storage_operations++, 0);

    for (unsigned i = 0; i < f->n; i++)
        if (f->fault[i].kind == kind && of_storage(f, i, storage) &&
            (kind != TTF_FAULT_DISK_FULL || f->fault[i].amount == 0) && strikes(f, i, t, key))
            return true;
    return false;
}

static int64_t next_cut(const struct sim_faults *f, unsigned i)
{
    const struct ttf_fault *fault = &f->fault[i];
    int64_t first = minute_of(f->power_on_ns) + 1;

    if (fault->rate_per_million == 0)
        return fault->at_ns > f->power_on_ns ? fault->at_ns : TTF_NS_NEVER;
    for (int64_t m = first; m < first + CUT_HORIZON_MINUTES; m++)
        if (m * TTF_NS_PER_MIN >= fault->at_ns && draw(f, i, (uint64_t)m))
            return m * TTF_NS_PER_MIN;
    return TTF_NS_NEVER;
}

int64_t sim_fault_cut_ns(const struct sim_faults *f, unsigned *ret_i)
{
    int64_t first = TTF_NS_NEVER;

    for (unsigned i = 0; i < f->n; i++) {
        int64_t t = f->fault[i].kind == TTF_FAULT_POWER_CUT ? next_cut(f, i) : TTF_NS_NEVER;

        if (t < first) {
            first = t;
            *ret_i = i;
        }
    }
    return first;
}
