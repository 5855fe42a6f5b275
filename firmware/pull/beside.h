/* SPDX-License-Identifier: Apache-2.0 */
/* beside.h: what lies beside a dataset's records: what happened (events.jsonl), and what people add. One thread. */
#ifndef PULL_BESIDE_H
#define PULL_BESIDE_H

#include "landing.h"
#include "one.h"

struct beside {
    struct wire *wire;
    struct landing *landing;
    void (*tell)(void *ctx, int64_t slots, const char *text);
    void *tell_ctx;
    struct one_result *result;
};

/* The box's events; of what is here, only what the box has too stays. 0 where the box has none: then what is here stays. */
TTF_MUST_USE int beside_events(struct beside *beside, struct ttf_err *err);

/* notes.jsonl, samples.json, report.json, outside the seal: brought where there is none, or what is here is its beginning. */
TTF_MUST_USE int beside_people(struct beside *beside, struct ttf_err *err);

#endif
