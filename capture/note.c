/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/capture/note.h"

#include <errno.h>
#include <stdbool.h>

#include "ttf/base/time.h"

#define PATIENCE_NS (2 * TTF_NS_PER_S)
#define PAUSE_NS    (TTF_NS_PER_S / 20)

/* Tries again while somebody else writes. */
struct patience {
    struct ttf_clock *clock;
    int64_t until_ns;
};

static struct patience begin(struct ttf_clock *clock)
{
    return (struct patience){clock, ttf_clock_now_ns(clock) + PATIENCE_NS};
}

static bool again(const struct patience *patience, int r)
{
    int64_t now_ns = ttf_clock_now_ns(patience->clock);

    if (r != -EAGAIN || now_ns >= patience->until_ns)
        return false;
    (void)ttf_clock_wait_until(patience->clock, now_ns + PAUSE_NS);
    return true;
}

int ttf_note_add(struct ttf_clock *clock, struct ttf_io *io, const char *path,
                 const struct ttf_note *note, struct ttf_err *err)
{
    const struct patience patience = begin(clock);
    int r;

    do
        r = ttf_note_append(io, path, note, err);
    while (again(&patience, r));
    return r;
}

int ttf_samples_say(struct ttf_clock *clock, struct ttf_io *io, const char *path,
                    const struct ttf_sample_change *changes, unsigned n, struct ttf_err *err)
{
    const struct patience patience = begin(clock);
    int r;

    do
        r = ttf_samples_change(io, path, changes, n, err);
    while (again(&patience, r));
    return r;
}
