/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "month.h"

#define S TTF_NS_PER_S
#define M TTF_NS_PER_MIN

#define HANG_KINDS 4

static enum ttf_fault_kind kind_of(unsigned kind)
{
    return kind < MONTH_PLAIN_KINDS ? (enum ttf_fault_kind)kind : TTF_FAULT_CAMERA_HANG;
}

/* Of a hang: which step cures it. */
static int64_t hang_of(unsigned kind)
{
    return kind < MONTH_PLAIN_KINDS ? 0 : (int64_t)(kind - MONTH_PLAIN_KINDS) + 1;
}

const char *month_kind_name(unsigned kind)
{
    static const char *const hangs[HANG_KINDS] = {"camera-hang (requeue)", "camera-hang (restart)",
                                                  "camera-hang (reopen)", "camera-hang (nothing)"};

    return kind_of(kind) == TTF_FAULT_CAMERA_HANG ? hangs[hang_of(kind)]
                                                  : ttf_fault_name(kind_of(kind));
}

/* splitmix64 (Steele, Lea, Flood 2014). */
static int64_t between(struct month *m, int64_t low, int64_t high)
{
    uint64_t x = m->state += UINT64_C(0x9e3779b97f4a7c15);

    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    x ^= x >> 31;
    return low + (int64_t)(x % (uint64_t)(high - low + 1));
}

/* What each kind is like: how long before the due time of a slot, and how long. */
static void draw_fault(struct month *m, struct month_fault *f, int64_t due_ns)
{
    struct ttf_fault *fault = &f->fault;
    int64_t before = between(m, 30 * S, 4 * M);
    bool both_tries = between(m, 0, 1) == 1;

    fault->kind = kind_of(f->kind);
    fault->at_ns = due_ns - before;
    switch (fault->kind) {
    case TTF_FAULT_FRAME_LATE:
        fault->amount = 5000;
        /* fall through */
    case TTF_FAULT_FRAME_SHORT:
    case TTF_FAULT_FRAME_CORRUPT:
    case TTF_FAULT_FRAME_MISSING:
    case TTF_FAULT_WRONG_SETTINGS:
        /* One frame, or both tries of a slot. */
        fault->duration_ns = both_tries ? before + 20 * S : 0;
        break;
    case TTF_FAULT_CAMERA_HANG:
        fault->amount = hang_of(f->kind);
        fault->duration_ns = fault->amount == 3 ? before + between(m, 1, 25 * 60) * S : 0;
        break;
    case TTF_FAULT_LAMP_FADING:
        fault->amount = 1000; /* dark after an hour */
        fault->duration_ns = between(m, 45, 55) * M;
        break;
    case TTF_FAULT_LAMP_DEAD:
    case TTF_FAULT_LAMP_STUCK:
    case TTF_FAULT_SENSOR_GONE:
    case TTF_FAULT_DOOR_OPEN:
        fault->duration_ns = before + between(m, 1, 25 * 60) * S;
        break;
    case TTF_FAULT_DISK_FULL:
    case TTF_FAULT_IO_ERROR:
        /* One operation, or up to two slots: at three the run would end. */
        fault->duration_ns = between(m, 0, 3) == 0 ? 0 : before + between(m, 1, 13 * 60) * S;
        break;
    case TTF_FAULT_CLOCK_STEP:
        fault->amount = between(m, 1, 7200) * (both_tries ? 1 : -1);
        break;
    case TTF_FAULT_POWER_CUT:
        fault->amount = between(m, 30, 1800);
        fault->at_ns = due_ns - between(m, -60 * 10, 60 * 10) * S / 2; /* any moment */
        break;
    default:
        break;
    }
    f->lasts_ns = fault->kind == TTF_FAULT_POWER_CUT ? fault->amount * S : fault->duration_ns;
}

void month_draw(struct month *m, uint64_t seed, int64_t days, int64_t due0_ns)
{
    memset(m, 0, sizeof(*m));
    m->seed = m->state = seed;
    m->days = days;
    m->due0_ns = due0_ns;
    m->read_only = (struct ttf_fault){.kind = TTF_FAULT_READ_ONLY,
                                      .at_ns = due0_ns + (MONTH_BLOCK - 1) * MONTH_INTERVAL_NS -
                                               between(m, -10 * 60, 5 * 60) * S / 5,
                                      .target = "first"};
    for (int64_t day = 0; day < days; day++) {
        unsigned kinds[MONTH_KINDS];

        for (unsigned k = 0; k < MONTH_KINDS; k++)
            kinds[k] = k;
        for (unsigned k = MONTH_KINDS - 1; k > 0; k--) {
            unsigned other = (unsigned)between(m, 0, k);
            unsigned kind = kinds[k];

            kinds[k] = kinds[other];
            kinds[other] = kind;
        }
        for (unsigned k = 1; day == 0 && k < MONTH_KINDS; k++)
            if (kind_of(kinds[k]) ==
                TTF_FAULT_CLOCK_STEP) { /* with the move, which others come behind */
                kinds[k] = kinds[0];
                kinds[0] = TTF_FAULT_CLOCK_STEP;
            }
        for (unsigned k = 0; k < MONTH_KINDS; k++) {
            struct month_fault *f = &m->faults[m->n++];

            f->kind = kinds[k];
            f->first = day * MONTH_DAY_SLOTS + (int64_t)k * MONTH_BLOCK;
            f->last = f->first + MONTH_BLOCK - 1;
            draw_fault(m, f, due0_ns + (f->first + 1) * MONTH_INTERVAL_NS);
        }
    }
}

const struct month_fault *month_fault_of(const struct month *m, int64_t index)
{
    return &m->faults[index / MONTH_BLOCK];
}

bool month_paused(const struct month *m, int64_t index)
{
    const struct month_fault *f = month_fault_of(m, index);
    int64_t in_block = index - f->first;

    return f->fault.kind == TTF_FAULT_CLOCK_STEP && in_block >= MONTH_PAUSE_FIRST &&
           in_block < MONTH_PAUSE_FIRST + MONTH_PAUSE_SLOTS;
}

int64_t month_interval_ns(const struct month *m, int64_t index)
{
    const struct month_fault *f = month_fault_of(m, index);

    if (f->fault.kind == TTF_FAULT_CLOCK_STEP && index - f->first == MONTH_ASK_AFTER + 1)
        return MONTH_INTERVAL_NS / 2;
    if (f->fault.kind == TTF_FAULT_CLOCK_STEP && index - f->first == MONTH_ASK_AFTER + 2)
        return MONTH_INTERVAL_NS * 3 / 2;
    return MONTH_INTERVAL_NS;
}

int64_t month_due_ns(const struct month *m, int64_t index)
{
    int64_t due = m->due0_ns + index * MONTH_INTERVAL_NS;

    return month_interval_ns(m, index) < MONTH_INTERVAL_NS ? due - MONTH_INTERVAL_NS / 2 : due;
}

void month_fill(const struct month *m, struct ttf_sim_config *config, int64_t power_on_ns)
{
    struct ttf_fault *stepped = &config->faults[0];

    /* A clock that is kept has been stepped by all that was before. */
    *stepped = (struct ttf_fault){.kind = TTF_FAULT_CLOCK_STEP, .at_ns = 1};
    config->n_faults = 0;
    for (unsigned i = 0; i < m->n; i++)
        if (m->faults[i].fault.kind == TTF_FAULT_CLOCK_STEP &&
            m->faults[i].fault.at_ns <= power_on_ns)
            stepped->amount += m->faults[i].fault.amount;
    if (stepped->amount != 0)
        config->n_faults = 1;
    config->faults[config->n_faults++] = m->read_only;
    for (unsigned i = 0; i < m->n && config->n_faults < TTF_SIM_FAULTS_MAX; i++) {
        const struct ttf_fault *fault = &m->faults[i].fault;

        if (fault->at_ns + fault->duration_ns > power_on_ns)
            config->faults[config->n_faults++] = *fault;
    }
}
