/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/capture/note.h"

#include <errno.h>

#include "ttf/base/time.h"

#define PATIENCE_NS (2 * TTF_NS_PER_S)
#define PAUSE_NS    (TTF_NS_PER_S / 20)

int ttf_note_add(struct ttf_clock *clock, struct ttf_io *io, const char *path,
                 const struct ttf_note *note, struct ttf_err *err)
{
    int64_t until = ttf_clock_now_ns(clock) + PATIENCE_NS;
    int r;

    while ((r = ttf_note_append(io, path, note, err)) == -EAGAIN && ttf_clock_now_ns(clock) < until)
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + PAUSE_NS);
    return r;
}
