/* SPDX-License-Identifier: Apache-2.0 */
#include "charts.h"

#include <inttypes.h>
#include <stdio.h>

#include "chart_text.h"
#include "history.h"

int charts_answer(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const struct history_of *of = NULL;
    char *text = NULL;
    size_t bytes = 0;
    int r = history_hold(request, HISTORY_AT_ONCE, &of);

    if (r < 0)
        return r;
    r = chart_text(request->match->name, &of->points, &of->segments, r == 0, &text, &bytes);
    (void)snprintf(ret->etag, sizeof ret->etag, "%" PRIx64 "-%" PRIx64 "-%" PRIx64,
                   of->growth.inode, (uint64_t)of->growth.bytes, of->begun);
    history_release(request);
    if (r == 0)
        answer_json(ret, text, bytes);
    return r;
}
