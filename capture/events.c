/* SPDX-License-Identifier: Apache-2.0 */
#include "events.h"

#include <stdarg.h>
#include <stdio.h>

void ttf_events_emit(struct ttf_events *events, const char *kind, const char *fmt, ...)
{
    struct ttf_job *job = ttf_job_new(events->queue, TTF_JOB_EVENT);
    struct ttf_utc utc;
    va_list args;

    if (!job)
        return; /* an event is not worth more than the run */
    ttf_clock_utc(events->clock, &utc);
    job->at_ns = utc.boot_ns;
    job->at_utc_ns = utc.trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : utc.utc_ns;
    snprintf(job->event, sizeof(job->event), "%s", kind);
    va_start(args, fmt);
    vsnprintf(job->text, sizeof(job->text), fmt, args);
    va_end(args);
    ttf_queue_push(events->queue, job);
}
