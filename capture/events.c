/* SPDX-License-Identifier: Apache-2.0 */
#include "events.h"

#include <stdarg.h>
#include <stdio.h>

static void emit(struct ttf_events *events, int64_t total, const char *kind, const char *fmt,
                 va_list args)
{
    struct ttf_job *job = ttf_job_new(events->queue, TTF_JOB_EVENT);
    struct ttf_utc utc;
    int64_t at_utc_ns;

    ttf_clock_utc(events->clock, &utc);
    at_utc_ns = utc.trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : utc.utc_ns;
    if (!job) { /* an event is not worth more than the run */
        ttf_queue_lose_event(events->queue, utc.boot_ns, at_utc_ns);
        return;
    }
    job->at_ns = utc.boot_ns;
    job->at_utc_ns = at_utc_ns;
    job->total = total;
    snprintf(job->event, sizeof(job->event), "%s", kind);
    vsnprintf(job->text, sizeof(job->text), fmt, args);
    ttf_queue_push(events->queue, job);
}

void ttf_events_emit(struct ttf_events *events, const char *kind, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    emit(events, 0, kind, fmt, args);
    va_end(args);
}

void ttf_events_emit_end(struct ttf_events *events, int64_t total, const char *kind,
                         const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    emit(events, total, kind, fmt, args);
    va_end(args);
}
