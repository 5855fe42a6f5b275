/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lamps.h: the box's lamps, as their client sees them.
 *
 * Behind this interface stands the guardian (guardian.h): it alone holds the
 * lamp lines, and it turns lamps off without asking. A client commands levels
 * and must show that it is alive: ttf_lamps_alive() declares its next sign of
 * life. Until then the back-end renews the lease every 100 ms; a sign of life
 * that is overdue lets the lease lapse 400 ms after the last renewal, and every
 * lamp goes off.
 *
 * Threads: any one thread at a time.
 */
#ifndef TTF_HAL_LAMPS_H
#define TTF_HAL_LAMPS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_LAMPS_MAX       8
#define TTF_LAMP_FULL       1000 /* permille */
#define TTF_LEASE_LAPSE_NS  INT64_C(400000000)
#define TTF_LEASE_RENEW_NS  INT64_C(100000000)
#define TTF_TEMP_MISSING_NS INT64_C(10000000000)

struct ttf_lamps;

enum ttf_lamp_kind {
    TTF_LAMP_SWITCH = 0, /* 0 or 1000 */
    TTF_LAMP_STEPS,      /* `steps` equal steps above 0 */
    TTF_LAMP_PWM         /* any permille */
};

/* What a lamp is and what it may do; from the board's description. */
struct ttf_lamp_info {
    char name[32]; /* [a-z0-9-], unique on the board */
    enum ttf_lamp_kind kind;
    unsigned steps;             /* of TTF_LAMP_STEPS, >= 1 */
    int64_t max_on_ns;          /* longest time on at a stretch; 0 = no limit */
    unsigned max_duty_permille; /* of duty_window_ns; 1000 = no limit */
    int64_t duty_window_ns;     /* > 0 if max_duty_permille < 1000 */
    int32_t max_temp_mdegc;     /* trip above; 0 = no temperature watched */
    int32_t hysteresis_mdegc;   /* may be lit again below max - hysteresis */
    bool interlock_door;        /* off while the door is open */
    int64_t warm_up_ns;         /* settle time it needs, as the board's maker measured it */
    int64_t pwm_period_ns;      /* its light's cycle at levels between; 0: steady, or not known */
};

/* Why a lamp is dark although commanded otherwise. Kept until cleared. */
enum ttf_lamp_trip {
    TTF_TRIP_NONE = 0,
    TTF_TRIP_LEASE,        /* the client's sign of life is overdue */
    TTF_TRIP_MAX_ON,       /* on for longer than max_on */
    TTF_TRIP_MAX_DUTY,     /* on for more than its share */
    TTF_TRIP_TEMP,         /* too hot */
    TTF_TRIP_TEMP_MISSING, /* its temperature has been missing for 10 s */
    TTF_TRIP_DOOR,         /* door open */
    TTF_TRIP_COUNT
};

/* "none", "lease", "max-on", "max-duty", "temperature", "temperature-missing", "door". */
const char *ttf_lamp_trip_name(enum ttf_lamp_trip trip);

struct ttf_lamp_state {
    unsigned commanded_permille; /* as the client asked, rounded to what the lamp can do */
    unsigned actual_permille;    /* as the guardian drives it */
    int measured_permille;       /* as a light sensor sees it; -1 = nobody measures */
    enum ttf_lamp_trip trip;
    int64_t on_since_ns; /* TTF_NS_UNKNOWN when off */
    int64_t on_total_ns; /* hours of the lamp, as far as this box knows */
};

unsigned ttf_lamps_count(const struct ttf_lamps *lamps);

/* Belongs to lamps; i < count. */
const struct ttf_lamp_info *ttf_lamps_info(const struct ttf_lamps *lamps, unsigned i);

/* Index of the lamp of that name, or -ENOENT. */
int ttf_lamps_find(const struct ttf_lamps *lamps, const char *name);

/*
 * Takes the lease; -EBUSY if another client holds it. alive_until_ns: the next
 * sign of life will come before this.
 */
TTF_MUST_USE int ttf_lamps_acquire(struct ttf_lamps *lamps, int64_t alive_until_ns,
                                   struct ttf_err *err);

/* A sign of life, and when to expect the next. -ESTALE if the lease has lapsed: acquire again. */
TTF_MUST_USE int ttf_lamps_alive(struct ttf_lamps *lamps, int64_t alive_until_ns,
                                 struct ttf_err *err);

/*
 * Commands a level, 0..1000 permille; a switch takes >= 500 as on, steps round
 * to the nearest. Turning on is refused with -EPERM while the lamp is tripped
 * (err says why), with -ESTALE without a lease; turning off always works.
 */
TTF_MUST_USE int ttf_lamps_set(struct ttf_lamps *lamps, unsigned i, unsigned permille,
                               struct ttf_err *err);

/* What the lamp does now. */
TTF_MUST_USE int ttf_lamps_state(struct ttf_lamps *lamps, unsigned i, struct ttf_lamp_state *ret);

/* A person says that lamp i may be tried again after a trip. -EPERM while the cause persists. */
TTF_MUST_USE int ttf_lamps_clear(struct ttf_lamps *lamps, unsigned i, struct ttf_err *err);

/* All lamps off, lease given back. */
void ttf_lamps_release(struct ttf_lamps *lamps);

/* Releases and frees. NULL allowed. */
void ttf_lamps_destroy(struct ttf_lamps *lamps);

#endif
