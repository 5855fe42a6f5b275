/* SPDX-License-Identifier: Apache-2.0 */
/* wire.h: what client and guardian send each other; README.md, "On the wire". Same machine, same byte order. */
#ifndef TTF_HAL_LAMPD_WIRE_H
#define TTF_HAL_LAMPD_WIRE_H

#include <stdint.h>

#include "ttf/hal/lamps.h"

#define WIRE_MAGIC 0x33444c54u /* "TLD3": another layout has another digit */

enum wire_op {
    WIRE_HELLO = 1, /* how many lamps */
    WIRE_INFO,      /* what lamp i is */
    WIRE_ACQUIRE,
    WIRE_RENEW,
    WIRE_SET,
    WIRE_STATE,
    WIRE_CLEAR,
    WIRE_RELEASE,
    WIRE_DOOR
};

#define WIRE_SILENT 1u /* no answer is wanted */

struct wire_request {
    uint32_t magic;
    uint16_t op;
    uint16_t flags;
    uint32_t number; /* comes back in the answer */
    uint32_t lamp;
    uint32_t permille;
};

struct wire_answer {
    uint32_t magic;
    uint16_t op;
    uint16_t n_lamps;
    uint32_t number;
    int32_t result;                         /* 0 (of DOOR: 0, 1), or a negative errno */
    struct ttf_lamp_state state;            /* of SET, STATE, CLEAR */
    struct ttf_lamp_info info;              /* of INFO */
    int64_t door_opened_ns, door_closed_ns; /* the last time each; TTF_NS_UNKNOWN */
};

#endif
