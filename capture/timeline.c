/* SPDX-License-Identifier: Apache-2.0 */
#include "timeline.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"

/* From where `a` begins to where the segment behind it does. */
static int64_t step_ns(const struct ttf_segment *a, const struct ttf_segment *b)
{
    if (strcmp(a->boot_id, b->boot_id) == 0)
        return b->origin_ns - a->origin_ns;
    return (b->first_index - a->first_index) * a->interval_ns;
}

int64_t ttf_timeline_run_ns(const struct ttf_segment *segment, int64_t slot0_ns)
{
    int64_t run_ns = segment->origin_ns - slot0_ns;

    return run_ns == segment->first_index * segment->interval_ns || run_ns < 0 ? 0 : run_ns;
}

int64_t ttf_timeline_elapsed_ns(const struct ttf_segment *segments, int n)
{
    int64_t elapsed = 0;

    if (n > 0)
        elapsed = segments[0].run_ns > 0 ? segments[0].run_ns
                                         : segments[0].first_index * segments[0].interval_ns;

    for (int i = 1; i < n; i++)
        elapsed += step_ns(&segments[i - 1], &segments[i]);
    return elapsed;
}

int64_t ttf_timeline_slot0_utc_ns(const struct ttf_segment *segments, int n)
{
    for (; n > 0; n--)
        if (segments[n - 1].origin_utc_ns != TTF_NS_UNKNOWN)
            return segments[n - 1].origin_utc_ns - ttf_timeline_elapsed_ns(segments, n);
    return TTF_NS_UNKNOWN;
}

enum ttf_trust ttf_segment_trust(const struct ttf_segment *segment)
{
    for (int trust = TTF_TRUST_NONE + 1; trust < TTF_TRUST_COUNT; trust++)
        if (strcmp(segment->trust, ttf_trust_name((enum ttf_trust)trust)) == 0)
            return (enum ttf_trust)trust;
    return TTF_TRUST_NONE;
}

static bool by_host(const struct ttf_segment *segment)
{
    return ttf_segment_trust(segment) == TTF_TRUST_HOST;
}

/* One of this boot. */
static void learn_of_boot(struct ttf_run_past *past, const struct ttf_segment *segment)
{
    enum ttf_trust trust = ttf_segment_trust(segment);

    if (segment->origin_utc_ns == TTF_NS_UNKNOWN || trust < past->boot_trust)
        return;
    past->boot_trust = trust;
    past->boot_offset_ns = segment->origin_utc_ns - segment->origin_ns;
}

/* One of a boot before. */
static void learn_of_last(struct ttf_run_past *past, const struct ttf_segment *segment,
                          int64_t end_index)
{
    enum ttf_trust trust = ttf_segment_trust(segment);

    if (segment->origin_utc_ns == TTF_NS_UNKNOWN || trust == TTF_TRUST_NONE ||
        (trust == TTF_TRUST_HOST && past->last_trust > TTF_TRUST_HOST))
        return;
    past->last_trust = trust;
    past->last_utc_ns =
        segment->origin_utc_ns + (end_index - 1 - segment->first_index) * segment->interval_ns;
}

struct ttf_run_past ttf_timeline_past(const struct ttf_segment *segments, int n,
                                      const char *boot_id, int64_t end_index)
{
    struct ttf_run_past past = {.slot0_utc_ns = ttf_timeline_slot0_utc_ns(segments, n),
                                .sure_slot0_utc_ns = TTF_NS_UNKNOWN};

    for (int i = 0; i < n; i++) {
        const struct ttf_segment *s = &segments[i];

        if (s->gap_ns > 0)
            past.gaps_ns += s->gap_ns;
        if (s->gap_ns > 0 && !by_host(s))
            past.sure_gaps_ns += s->gap_ns;
        if (s->origin_utc_ns != TTF_NS_UNKNOWN && !by_host(s))
            past.sure_slot0_utc_ns = s->origin_utc_ns - ttf_timeline_elapsed_ns(segments, i + 1);
        if (strcmp(s->boot_id, boot_id) == 0)
            learn_of_boot(&past, s);
        else
            learn_of_last(&past, s, i + 1 < n ? segments[i + 1].first_index : end_index);
    }
    return past;
}

int ttf_timeline_read(struct ttf_io *io, const char *path, struct ttf_segment **ret, int *ret_n,
                      struct ttf_err *err)
{
    struct ttf_segment *segments = NULL;
    struct ttf_reader *reader;
    int r = ttf_reader_open(io, path, &reader, err);
    int n;

    if (r < 0)
        return r;
    n = ttf_reader_summary(reader)->n_segments;
    if (n > 0) {
        segments = calloc((size_t)n, sizeof(*segments));
        if (!segments)
            r = ttf_err_set(err, -ENOMEM, path, "no memory");
    }
    for (int i = 0; i < n && r == 0; i++)
        r = ttf_reader_segment(reader, i, &segments[i]);
    ttf_reader_close(reader);
    if (r < 0) {
        free(segments);
        return r;
    }
    *ret = segments;
    *ret_n = n;
    return 0;
}
