/* SPDX-License-Identifier: Apache-2.0 */
/* clock_utc.h: what the simulated box believes of UTC. Private to hal/sim; locks for itself. */
#ifndef TTF_HAL_SIM_CLOCK_UTC_H
#define TTF_HAL_SIM_CLOCK_UTC_H

#include <pthread.h>

#include "faults.h"
#include "ttf/hal/clock.h"

struct sim_utc {
    pthread_mutex_t lock; /* of the cursors */
    const struct ttf_sim_config *config;
    const struct sim_faults *faults; /* only its constant parts are read */
    int64_t elapsed_offset_ns;       /* elapsed time - boot clock */
    struct {
        int64_t minute; /* looked at up to here */
        int64_t sum_s;
        uint32_t count;
    } cursor[TTF_SIM_FAULTS_MAX]; /* of random clock steps */
};

int sim_utc_init(struct sim_utc *utc, const struct ttf_sim_config *config,
                 const struct sim_faults *faults);
void sim_utc_finish(struct sim_utc *utc);

/* The belief at boot_ns; instants must not go back by more than a minute. */
void sim_utc_at(struct sim_utc *utc, int64_t boot_ns, struct ttf_utc *ret);

/* By how much clock-step faults since the first power-on (since_boot: since this one) have moved UTC, and how often. */
int64_t sim_utc_stepped_ns(struct sim_utc *utc, int64_t boot_ns, bool since_boot,
                           uint32_t *ret_count);

#endif
