/* SPDX-License-Identifier: Apache-2.0 */
/* gate.h: gates of the machine's clock. Private to hal/real; see clock.h. */
#ifndef TTF_HAL_REAL_GATE_H
#define TTF_HAL_REAL_GATE_H

#include "ttf/hal/clock_backend.h"

struct ttf_gate *real_gate_create(struct ttf_clock *clock);
void real_gate_destroy(struct ttf_gate *gate);
void real_gate_open(struct ttf_gate *gate);
int real_gate_wait(struct ttf_gate *gate, int64_t deadline_ns);

#endif
