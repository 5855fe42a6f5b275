/* SPDX-License-Identifier: Apache-2.0 */
#include "until_run.h"

#include "cmocka_includes.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN

void until_init(struct sim_run *run, enum ttf_plan_end end, int64_t slots)
{
    living_init(run);
    run->plan.count = slots;
    run->plan.end = end;
    if (end == TTF_END_UNTIL)
        run->plan.until_utc_ns = run->config.start_utc_ns + slots * MIN;
    if (end == TTF_END_LENGTH)
        run->plan.length_ns = (slots - 1) * MIN + 30 * S;
}

void until_expect_end(struct sim_run *run, const char *letters, const char *reason)
{
    char *text = sim_run_text(run, "records.jsonl");
    char what[64];
    const char *end;

    assert_non_null(text);
    sim_run_expect(run, letters);
    assert_true(run->result.sealed);
    end = strstr(text, "\"type\":\"end\"");
    assert_non_null(end);
    snprintf(what, sizeof(what), "\"reason\":\"%s\"", reason);
    if (!strstr(end, what))
        print_error("not %s: %s\n", what, end);
    assert_non_null(strstr(end, what));
    free(text);
    run->plan.count = (int64_t)strlen(letters);
    assert_int_equal(run->result.total, run->plan.count);
    sim_run_expect_whole(run, true);
}

/* ---- a box that believes what it is told of UTC ---- */

static const struct until_clock *clock_of(const struct ttf_clock *clock)
{
    return (const struct until_clock *)((const char *)clock->ops -
                                        offsetof(struct until_clock, ops));
}

static void believed_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    const struct until_clock *b = clock_of(clock);
    int64_t at;
    unsigned i = 0;

    ret->boot_ns = ttf_clock_now_ns(clock);
    at = ttf_sim_elapsed_ns(b->run.box, ret->boot_ns);
    while (i + 1 < b->n && at >= b->beliefs[i + 1].from_ns)
        i++;
    ret->utc_ns = b->run.config.start_utc_ns + at + b->beliefs[i].ahead_ns;
    ret->trust = b->beliefs[i].trust;
    ret->uncertainty_ns = ret->trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : S;
    ret->steps = 0;
}

static void believe(struct sim_run *run)
{
    struct until_clock *b = (struct until_clock *)run;

    b->ops = *run->box->clock->ops;
    b->ops.utc = believed_utc;
    run->box->clock->ops = &b->ops;
}

void until_clock_init(struct until_clock *b, enum ttf_plan_end end, int64_t slots,
                      const struct until_belief *beliefs, unsigned n)
{
    until_init(&b->run, end, slots);
    b->run.on_box = believe;
    b->beliefs = beliefs;
    b->n = n;
}
