/* SPDX-License-Identifier: Apache-2.0 */
/* chart_text.h: points of charts as JSON (openapi.yaml), with the times that segments give them. */
#ifndef HTTP_CHART_TEXT_H
#define HTTP_CHART_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "chart_points.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/record.h"

/* When each segment began, as corrected last. */
struct chart_segments {
    struct chart_origin {
        int64_t origin_ns, origin_utc_ns;
    } * origin;
    size_t n, room;
};

/* Zeroed: none. -ENOMEM. */
TTF_MUST_USE int chart_segments_put(struct chart_segments *segments,
                                    const struct ttf_segment *segment);
void chart_segments_free(struct chart_segments *segments);

/* By malloc. complete: there are no more records than these. */
TTF_MUST_USE int chart_text(const char *dataset, const struct chart_points *points,
                            const struct chart_segments *segments, bool complete, char **ret_text,
                            size_t *ret_bytes);

#endif
