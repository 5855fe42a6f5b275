/* SPDX-License-Identifier: Apache-2.0 */
/*
 * kept.h: the first frames of the sources as the 8-bit codes that they are matched by, kept as they are read for the
 * factors, so that putting output together needs no second reading.
 */
#ifndef TTF_SYNTH_SEARCH_KEPT_H
#define TTF_SYNTH_SEARCH_KEPT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

/* After each frame's codes so many bytes may be read (they mean nothing). */
#define TTF_KEPT_SLACK 64u

struct ttf_kept {
    uint32_t frames; /* the first so many */
    size_t frame;    /* bytes of one: pixels x 3 */
    uint8_t *codes;  /* frames x frame, and slack */
    size_t touched;  /* bytes of them whose memory was asked for or read into, in large pages */
    unsigned slow;   /* so many of them, the last, were slow */
    bool small;      /* the rest is better taken in small ones */
};

/* As many of `frames` as fit into bytes_max; none (no error) where not one does, or one has 4 GiB and more. -ENOMEM. */
TTF_MUST_USE int ttf_kept_create(size_t pixels, uint32_t frames, size_t bytes_max,
                                 struct ttf_kept *ret);

/*
 * Asks for the memory of frames up to `to`, of which those from `from` on are read into later: by one thread at a time, also while others read those
 * before. Large pages cost least where they are the machine's already; a virtual machine's may have been given back to its host, and then each takes twenty times as long (4.4 ms of 2 MiB instead of
 * 0.2), while small ones are less often: what is given back is large blocks. So after two in a row that are slow by the clock (one may be a thread that had
 * to wait) the rest are small. It is reckoned in large pages of 2 MiB; where a machine's are larger, no two in a row are slow, and all stay as they are.
 * now_ns NULL: nothing is asked for.
 */
void ttf_kept_touch(struct ttf_kept *kept, uint32_t from, uint32_t to, int64_t (*now_ns)(void *ctx),
                    void *ctx);

void ttf_kept_free(struct ttf_kept *kept); /* a zeroed one is fine */

/* Memory of it. */
size_t ttf_kept_bytes(const struct ttf_kept *kept);

#endif
