/* SPDX-License-Identifier: Apache-2.0 */
/*
 * cancel.h: a request to end, as whoever called looks for it.
 *
 * An int of the caller's that becomes non-zero: by a signal handler, or by any thread with an atomic store. It
 * carries nothing but itself, so no order with other memory is needed.
 */
#ifndef TTF_SYNTH_CANCEL_H
#define TTF_SYNTH_CANCEL_H

#include <stdbool.h>

/* NULL: nobody asks. */
static inline bool ttf_cancelled(const volatile int *cancel)
{
    return cancel && __atomic_load_n(cancel, __ATOMIC_RELAXED) != 0;
}

#endif
