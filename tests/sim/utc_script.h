/* SPDX-License-Identifier: Apache-2.0 */
/*
 * utc_script.h: what a box believes of UTC, as a test wrote it down: trust of any
 * kind, a step at any instant, and what a power cut does to it. The boot clock, and
 * all else, stays the simulated box's own.
 */
#ifndef TTF_TESTS_UTC_SCRIPT_H
#define TTF_TESTS_UTC_SCRIPT_H

#include <stdbool.h>

#include "ttf/hal/box.h"
#include "ttf/hal/clock_backend.h"

/* Instants since the first power-on. */
struct utc_script {
    struct ttf_clock_ops ops; /* first: the clock's table, with another UTC */
    const struct ttf_box *box;
    int64_t start_utc_ns;  /* true UTC of the first power-on */
    int64_t power_on_ns;   /* of this boot */
    enum ttf_trust trust;  /* once it is trusted */
    int64_t trusted_at_ns; /* since when; 0: from the beginning; TTF_NS_NEVER: not at all */
    int64_t step_at_ns;    /* UTC jumps then */
    int64_t step_ns;
    bool kept;              /* a later boot goes on with the same UTC; else the clock begins anew */
    int64_t given_again_ns; /* without: so long after power-on NTP gives the true UTC; 0: never */
};

/* The box's clock follows the script from now on. The script outlives the box. */
void utc_script_play(struct utc_script *script, struct ttf_box *box, int64_t power_on_ns);

/* What is believed at an instant since the first power-on, in a boot that began then: offset to that time, and trust. */
int64_t utc_script_offset_ns(const struct utc_script *script, int64_t power_on_ns, int64_t at_ns,
                             enum ttf_trust *ret_trust);

/* How sure such a clock is. */
int64_t utc_script_uncertainty_ns(enum ttf_trust trust);

#endif
