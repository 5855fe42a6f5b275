/* SPDX-License-Identifier: Apache-2.0 */
#include "search/kept.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "search/factors.h"

/* Frames that are held besides while those are read that are not kept (learner.c): all together are no more than is allowed. */
#define OTHERS ((size_t)2 * TTF_FACTORS_BATCH)

/* Pages of this size, where the system has them, cost one fault each instead of 512. */
#define LARGE_PAGE ((size_t)2 << 20)

/* What one takes at most that is the machine's: 0.2 ms on a server, and ten times that for slower memory. */
#define SLOW_NS  2000000
#define SLOW_MAX 2u

size_t ttf_kept_bytes(const struct ttf_kept *kept)
{
    return kept->frames > 0 ? kept->frames * kept->frame + TTF_KEPT_SLACK : 0;
}

int ttf_kept_create(size_t pixels, uint32_t frames, size_t bytes_max, struct ttf_kept *ret)
{
    struct ttf_kept kept = {.frame = pixels * 3};
    size_t fit = bytes_max > TTF_KEPT_SLACK ? (bytes_max - TTF_KEPT_SLACK) / kept.frame : 0;
    size_t bytes;
    void *codes = NULL;

    if (kept.frame > UINT32_MAX)
        fit = 0;
    if (fit < frames)
        fit -= fit / 8 < OTHERS ? fit / 8 : OTHERS;
    kept.frames = fit < frames ? (uint32_t)fit : frames;
    bytes = ttf_kept_bytes(&kept);
    if (bytes > 0 && posix_memalign(&codes, LARGE_PAGE, bytes) != 0)
        return -ENOMEM;
    if (bytes > 0)
        (void)madvise(codes, bytes,
                      MADV_HUGEPAGE); /* a wish: without it all is the same, but slower */
    kept.codes = codes;
    *ret = kept;
    return 0;
}

void ttf_kept_touch(struct ttf_kept *kept, uint32_t from, uint32_t to, int64_t (*now_ns)(void *ctx),
                    void *ctx)
{
    size_t bytes = ttf_kept_bytes(kept);
    size_t end = (to < kept->frames ? to : kept->frames) * kept->frame;
    size_t begin = (from * kept->frame + LARGE_PAGE - 1) / LARGE_PAGE * LARGE_PAGE;

    if (kept->touched < begin)
        kept->touched = begin;
    while (now_ns && !kept->small && kept->touched < end) {
        int64_t start_ns = now_ns(ctx);

        *(volatile uint8_t *)(kept->codes + kept->touched) = 0;
        kept->slow = now_ns(ctx) - start_ns > SLOW_NS ? kept->slow + 1 : 0;
        kept->small = kept->slow == SLOW_MAX;
        kept->touched += LARGE_PAGE;
        if (kept->small && kept->touched < bytes)
            (void)madvise(kept->codes + kept->touched, bytes - kept->touched, MADV_NOHUGEPAGE);
    }
}

void ttf_kept_free(struct ttf_kept *kept)
{
    free(kept->codes);
    memset(kept, 0, sizeof(*kept));
}
