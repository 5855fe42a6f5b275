/* SPDX-License-Identifier: Apache-2.0 */
/* lampd_private.h: what the guardian's files share. */
#ifndef TTF_HAL_LAMPD_PRIVATE_H
#define TTF_HAL_LAMPD_PRIVATE_H

#include <pthread.h>
#include <stdatomic.h>

#include "ttf/hal/guardian.h"
#include "ttf/hal/lampd.h"
#include "wire.h"

#define LAMPD_CLIENTS_MAX 8

/* The temperature, from a thread that may hang in a sensor's driver without harm: a missing one darkens the lamps. */
struct lampd_heat {
    struct ttf_clock *clock;
    struct ttf_sensors *sensors;
    const char *name;
    pthread_t thread;
    bool running;
    atomic_bool stop, ended;
    pthread_mutex_t lock; /* of what follows */
    bool fresh;           /* a reading that the guardian has not taken yet */
    int32_t temp_mdegc;
    int64_t at_ns;
};

TTF_MUST_USE int lampd_heat_start(struct lampd_heat *heat, const struct ttf_lampd_config *config,
                                  struct ttf_err *err);
/* 1 and the reading, once each; 0. */
int lampd_heat_take(struct lampd_heat *heat, int32_t *ret_mdegc, int64_t *ret_at_ns);
/* 0; -EBUSY: its thread hangs in a driver, and goes on to use all that heat holds. */
TTF_MUST_USE int lampd_heat_stop(struct lampd_heat *heat);

struct ttf_lampd {
    struct ttf_lampd_config config;
    char path[108]; /* of the socket */
    int listening;
    int client[LAMPD_CLIENTS_MAX]; /* -1: free */
    int holder;                    /* of the lease: an index of client; -1: nobody */
    struct ttf_guardian guardian;
    unsigned driven[TTF_LAMPS_MAX];         /* what the lines were last told */
    bool failed[TTF_LAMPS_MAX];             /* and did not take */
    bool lost;                              /* the chip is gone */
    int64_t door_opened_ns, door_closed_ns; /* the last time each was felt; TTF_NS_UNKNOWN */
    int64_t reopen_at_ns, look_at_ns;
    struct lampd_heat heat;
};

/* Lets time pass and drives the lines to what the guardian says. */
void lampd_drive(struct ttf_lampd *d, int64_t now_ns);

/* requests.c: one message of client c has come; a client that ended or speaks another language is let go. */
void lampd_hear(struct ttf_lampd *d, unsigned c);
void lampd_let_go(struct ttf_lampd *d, unsigned c);

#endif
