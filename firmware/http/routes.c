/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/routes.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "box_answers.h"
#include "charts.h"
#include "datasets.h"
#include "gives.h"
#include "health.h"
#include "listeners.h"
#include "preview_video.h"
#include "previews.h"
#include "run_answers.h"
#include "session.h"
#include "thumbs.h"
#include "web.h"

static const struct ttf_http_route ROUTES[] = {
    {"GET", "/", TTF_HTTP_OPEN, web_index, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE, &GIVES_INDEX},
    {"GET", "/web/{path}", TTF_HTTP_OPEN, web_file_of_page, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_PAGE},
    {"GET", "/api/v1/health", TTF_HTTP_OPEN, health_answer, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_JSON},
    {"POST", "/api/v1/session", TTF_HTTP_OPEN, session_begin, TTF_HTTP_JSON, TTF_HTTP_AT_ONCE,
     &GIVES_JSON},
    {"GET", "/api/v1/session", TTF_HTTP_OPEN, session_show, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_JSON},
    {"DELETE", "/api/v1/session", TTF_HTTP_OPEN, session_end, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_JSON},
    {"POST", "/api/v1/session/token", TTF_HTTP_CABLE, session_token, TTF_HTTP_NO_BODY,
     TTF_HTTP_ORDERS, &GIVES_JSON},
    {"GET", "/api/v1/datasets", TTF_HTTP_READ, datasets_list, TTF_HTTP_NO_BODY, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"GET", "/api/v1/datasets/{name}", TTF_HTTP_READ, datasets_one, TTF_HTTP_NO_BODY, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"GET", "/api/v1/datasets/{name}/records", TTF_HTTP_READ, datasets_records, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_LINES},
    {"GET", "/api/v1/datasets/{name}/files/{path}", TTF_HTTP_READ, datasets_file, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_FILE},
    {"GET", "/api/v1/datasets/{name}/tar", TTF_HTTP_READ, datasets_tar, TTF_HTTP_NO_BODY,
     TTF_HTTP_WORK, &GIVES_TAR},
    {"GET", "/api/v1/datasets/{name}/charts", TTF_HTTP_READ, charts_answer, TTF_HTTP_NO_BODY,
     TTF_HTTP_WORK, &GIVES_TAGGED_JSON},
    {"GET", "/api/v1/datasets/{name}/thumbs/{path}", TTF_HTTP_READ, thumbs_answer, TTF_HTTP_NO_BODY,
     TTF_HTTP_PICTURES, &GIVES_THUMB},
    {"GET", "/api/v1/datasets/{name}/preview", TTF_HTTP_READ, previews_state, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_TAGGED_JSON},
    {"GET", "/api/v1/datasets/{name}/preview.avi", TTF_HTTP_READ, preview_video, TTF_HTTP_NO_BODY,
     TTF_HTTP_PICTURES, &GIVES_VIDEO},
    {"GET", "/api/v1/datasets/{name}/preview/{path}", TTF_HTTP_READ, previews_frame,
     TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE, &GIVES_JPEG},
    {"GET", "/api/v1/datasets/{name}/events", TTF_HTTP_READ, datasets_events, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_LINES},
    {"GET", "/api/v1/datasets/{name}/notes", TTF_HTTP_READ, datasets_notes, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_LINES},
    {"POST", "/api/v1/datasets/{name}/notes", TTF_HTTP_CHANGE, run_note, TTF_HTTP_JSON,
     TTF_HTTP_ORDERS, &GIVES_JSON},
    {"GET", "/api/v1/status", TTF_HTTP_READ, box_status, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_JSON},
    {"POST", "/api/v1/time", TTF_HTTP_CHANGE, box_time, TTF_HTTP_JSON, TTF_HTTP_AT_ONCE,
     &GIVES_JSON},
    {"GET", "/api/v1/events", TTF_HTTP_READ, events_answer, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_EVENTS},
    {"GET", "/api/v1/box", TTF_HTTP_READ, box_devices, TTF_HTTP_NO_BODY, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"GET", "/api/v1/boards", TTF_HTTP_READ, box_boards, TTF_HTTP_NO_BODY, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"POST", "/api/v1/boards/check", TTF_HTTP_CHANGE, box_board_check, TTF_HTTP_YAML, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"GET", "/api/v1/boards/{name}", TTF_HTTP_READ, box_board, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_YAML},
    {"PUT", "/api/v1/boards/{name}", TTF_HTTP_CHANGE, box_board_put, TTF_HTTP_YAML, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"DELETE", "/api/v1/boards/{name}", TTF_HTTP_CHANGE, box_board_delete, TTF_HTTP_NO_BODY,
     TTF_HTTP_WORK, &GIVES_JSON},
    {"GET", "/api/v1/boards/{name}/plans/{path}", TTF_HTTP_READ, box_board_plan, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_YAML},
    {"GET", "/api/v1/plans", TTF_HTTP_READ, box_plans, TTF_HTTP_NO_BODY, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"POST", "/api/v1/plans/check", TTF_HTTP_CHANGE, box_plan_check, TTF_HTTP_YAML, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"GET", "/api/v1/plans/{name}", TTF_HTTP_READ, box_plan, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_YAML},
    {"PUT", "/api/v1/plans/{name}", TTF_HTTP_CHANGE, box_plan_put, TTF_HTTP_YAML, TTF_HTTP_WORK,
     &GIVES_JSON},
    {"DELETE", "/api/v1/plans/{name}", TTF_HTTP_CHANGE, box_plan_delete, TTF_HTTP_NO_BODY,
     TTF_HTTP_WORK, &GIVES_JSON},
    {"GET", "/api/v1/calibrations", TTF_HTTP_READ, box_calibrations, TTF_HTTP_NO_BODY,
     TTF_HTTP_WORK, &GIVES_JSON},
    {"POST", "/api/v1/calibrations/{name}", TTF_HTTP_CHANGE, box_calibrate, TTF_HTTP_JSON,
     TTF_HTTP_ORDERS, &GIVES_ACCEPTED},
    {"DELETE", "/api/v1/calibrations/{name}", TTF_HTTP_CHANGE, box_calibration_delete,
     TTF_HTTP_NO_BODY, TTF_HTTP_WORK, &GIVES_JSON},
    {"PUT", "/api/v1/calibration", TTF_HTTP_CHANGE, box_calibration_use, TTF_HTTP_JSON,
     TTF_HTTP_ORDERS, &GIVES_JSON},
    {"POST", "/api/v1/run", TTF_HTTP_CHANGE, run_start, TTF_HTTP_JSON, TTF_HTTP_ORDERS,
     &GIVES_ACCEPTED},
    {"POST", "/api/v1/run/stop", TTF_HTTP_CHANGE, run_stop, TTF_HTTP_NO_BODY, TTF_HTTP_STOPS,
     &GIVES_ACCEPTED},
    {"POST", "/api/v1/run/pause", TTF_HTTP_CHANGE, run_pause, TTF_HTTP_JSON_MAYBE, TTF_HTTP_AT_ONCE,
     &GIVES_ACCEPTED},
    {"POST", "/api/v1/run/resume", TTF_HTTP_CHANGE, run_resume, TTF_HTTP_NO_BODY, TTF_HTTP_AT_ONCE,
     &GIVES_ACCEPTED},
    {"POST", "/api/v1/run/change", TTF_HTTP_CHANGE, run_change, TTF_HTTP_JSON, TTF_HTTP_AT_ONCE,
     &GIVES_ACCEPTED},
    {"GET", "/api/v1/run/asked/{name}", TTF_HTTP_READ, run_asked, TTF_HTTP_NO_BODY,
     TTF_HTTP_AT_ONCE, &GIVES_JSON},
    {"GET", "/api/v1/latest", TTF_HTTP_READ, run_latest, TTF_HTTP_NO_BODY, TTF_HTTP_PICTURES,
     &GIVES_JPEG},
    {"GET", "/api/v1/live", TTF_HTTP_TOKEN, run_live, TTF_HTTP_NO_BODY, TTF_HTTP_PICTURES,
     &GIVES_LIVE},
};

const struct ttf_http_route *ttf_http_route(size_t i)
{
    return i < sizeof ROUTES / sizeof *ROUTES ? &ROUTES[i] : NULL;
}

/* Copies n bytes of a segment; false: too long, or none. */
static bool take(const char *from, size_t n, char *ret, size_t max)
{
    if (n == 0 || n > max)
        return false;
    memcpy(ret, from, n);
    ret[n] = '\0';
    return true;
}

static bool matches(const char *pattern, const char *url, struct ttf_http_match *ret)
{
    for (;;) {
        if (strncmp(pattern, "{name}", 6) == 0) {
            size_t n = strcspn(url, "/");

            if (!take(url, n, ret->name, TTF_HTTP_NAME_MAX))
                return false;
            pattern += 6;
            url += n;
        } else if (strncmp(pattern, "{path}", 6) == 0) {
            return take(url, strlen(url), ret->path, TTF_HTTP_REST_MAX);
        }
        if (*pattern != *url)
            return false;
        if (*pattern == '\0')
            return true;
        pattern++;
        url++;
    }
}

int ttf_http_route_find(const char *method, const char *url, struct ttf_http_match *ret)
{
    int r = -ENOENT;

    if (strcmp(method, "HEAD") == 0)
        method = "GET";
    for (size_t i = 0; i < sizeof ROUTES / sizeof *ROUTES; i++) {
        struct ttf_http_match match = {.route = &ROUTES[i]};

        if (!matches(ROUTES[i].pattern, url, &match))
            continue;
        if (strcmp(ROUTES[i].method, method) == 0) {
            *ret = match;
            return 0;
        }
        r = -ENOTSUP;
    }
    return r;
}

const char *ttf_http_route_methods(const char *url, char ret[64])
{
    size_t n = 0;

    ret[0] = '\0';
    for (size_t i = 0; i < sizeof ROUTES / sizeof *ROUTES; i++) {
        struct ttf_http_match match = {0};

        if (!matches(ROUTES[i].pattern, url, &match) || strstr(ret, ROUTES[i].method) || n > 40)
            continue;
        n +=
            (size_t)snprintf(ret + n, 64 - n, "%s%s", n ? ", " : "",
                             strcmp(ROUTES[i].method, "GET") == 0 ? "GET, HEAD" : ROUTES[i].method);
    }
    return ret;
}
