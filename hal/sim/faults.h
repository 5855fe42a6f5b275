/* SPDX-License-Identifier: Apache-2.0 */
/*
 * faults.h: when which fault is in force. Private to hal/sim. All times are
 * elapsed time, since the box's first power-on, so a later boot sees the same faults;
 * one that struck before this boot, or while the box was off, is not repeated.
 * Which fault does what is the devices' business. The caller serialises.
 */
#ifndef TTF_HAL_SIM_FAULTS_H
#define TTF_HAL_SIM_FAULTS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/hal/sim.h"

struct sim_faults {
    uint64_t seed;
    int64_t power_on_ns;
    unsigned n;
    struct ttf_fault fault[TTF_SIM_FAULTS_MAX]; /* amounts and durations resolved */
    unsigned target[TTF_SIM_FAULTS_MAX]; /* index of lamp or sensor; of a storage + 1, 0: all */
    bool spent[TTF_SIM_FAULTS_MAX];      /* a one-time fault that has struck */
    uint64_t storage_operations;
};

/* 64 well mixed bits of three numbers. */
uint64_t sim_mix(uint64_t a, uint64_t b, uint64_t c);

/* config has passed ttf_sim_config_check. */
void sim_faults_init(struct sim_faults *f, const struct ttf_sim_config *config);

/* Index of the thing that fault i is about, or -1 if there is no such thing. */
int sim_fault_target(const struct ttf_sim_config *config, const struct ttf_fault *fault);

/* True if fault i, of a lasting kind (lamps, sensors, door, hang), is in force at t. */
bool sim_fault_active(const struct sim_faults *f, unsigned i, int64_t t);

/* The next instant after t at which that may change; TTF_NS_NEVER. */
int64_t sim_fault_next_change(const struct sim_faults *f, unsigned i, int64_t t);

/* When a fault of such a kind that is in force at t began; TTF_NS_NEVER if it is not. */
int64_t sim_fault_began(const struct sim_faults *f, unsigned i, int64_t t);

/* When one that began at `began` ends; TTF_NS_NEVER. */
int64_t sim_fault_ends(const struct sim_faults *f, unsigned i, int64_t began);

/*
 * Does a fault of this kind strike the frame (or submission) at t? Takes a
 * one-time fault away. ret_amount: of the fault; NULL allowed.
 */
bool sim_fault_on_frame(struct sim_faults *f, enum ttf_fault_kind kind, int64_t t,
                        int64_t *ret_amount);

/* Does sensor `sensor` fail to answer a reading at t? */
bool sim_fault_on_sensor(struct sim_faults *f, unsigned sensor, int64_t t);

/* Does an operation of storage 0 or 1 at t fail in this way? */
bool sim_fault_on_storage(struct sim_faults *f, enum ttf_fault_kind kind, unsigned storage,
                          int64_t t);

/* Is fault i one of this storage's, and does it last at t? */
bool sim_fault_storage_lasts(const struct sim_faults *f, unsigned i, unsigned storage, int64_t t);

/* The first power cut after this boot began, and its fault; TTF_NS_NEVER if none comes. */
int64_t sim_fault_cut_ns(const struct sim_faults *f, unsigned *ret_i);

/* True if fault i of a kind that strikes at instants (clock step, power cut) strikes at the whole minute `minute`. */
bool sim_fault_at_minute(const struct sim_faults *f, unsigned i, int64_t minute);

#endif
