/* SPDX-License-Identifier: Apache-2.0 */
/* sim_boot.h: when a simulated box comes back that a run left behind. */
#ifndef FIRMWARE_SIM_BOOT_H
#define FIRMWARE_SIM_BOOT_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/reader.h"
#include "ttf/hal/sim.h"

/*
 * A kill, a crash or Ctrl-C of a simulated capture is a power cut of its box: it
 * boots again at the last record's due time + config->outage_ns (ARCHITECTURE.md,
 * Time), but for one in real time, whose sample went on meanwhile: its age is that of its first segment by
 * the machine's clock. *ret: since the first power-on. The way there is by UTC where a segment's
 * is vouched for, else by adding up boots.
 */
TTF_MUST_USE int sim_boot_power_on(struct ttf_reader *reader, const struct ttf_sim_config *config,
                                   int64_t *ret_power_on_ns, struct ttf_err *err);

#endif
