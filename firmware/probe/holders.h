/* SPDX-License-Identifier: Apache-2.0 */
/* holders.h: who has a GPIO line. */
#ifndef FIRMWARE_PROBE_HOLDERS_H
#define FIRMWARE_PROBE_HOLDERS_H

#include "probe.h"

/*
 * The kernel is asked; where it may not be, its list is read. 1 and who, "" for one without a name; 0: nobody;
 * -ENOENT and err: there is no such line; -EACCES: it is told neither way; 0 where nobody was to be asked.
 */
int probe_line_holder(const struct probe_machine *machine, const struct ttf_line_spec *wire,
                      char ret[64], struct ttf_err *err);

#endif
