/* SPDX-License-Identifier: Apache-2.0 */
#include "box_answers.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "body.h"

#define OPS(request) ((request)->box->ops)

int box_needed(struct ttf_http_request *request)
{
    return request->box ? 0 : ttf_err_set(&request->err, -ENODEV, NULL, "this server has no box");
}

int box_give(struct ttf_http_answer *answer, int r, char *json)
{
    if (r < 0)
        return r;
    answer_json(answer, json, strlen(json));
    return 0;
}

/* A name that may be a file's. */
static int named(struct ttf_http_request *request, const char *name)
{
    int r = box_needed(request);

    if (r < 0)
        return r;
    return folder_is_name(name)
               ? 0
               : ttf_err_set(&request->err, -ENOENT, NULL, "there is nothing of this name here");
}

/* The body, a text, under the name in the path; the door says what is in it. */
static int put_text(struct ttf_http_request *request,
                    int (*put)(struct ttf_http_box *box, const char *name, const char *yaml,
                               size_t bytes, char **ret_json, struct ttf_err *err),
                    struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = put(request->box, request->match->name, request->body, request->body_bytes, &json,
                &request->err);

    return box_give(ret, r, json);
}

/* What is of the name in the path. */
static int take_away(struct ttf_http_request *request,
                     int (*remove)(struct ttf_http_box *box, const char *name, struct ttf_err *err),
                     struct ttf_http_answer *ret)
{
    int r = remove(request->box, request->match->name, &request->err);

    return r < 0 ? r : answer_done(request, ret);
}

/* ---- reading ---- */

static int status_of_none(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *text = malloc(80);

    if (!text)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    (void)snprintf(text, 80, "{\"version\":\"%s\",\"state\":\"none\"}", TTFBOX_VERSION);
    return box_give(ret, 0, text);
}

int box_status(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;

    int r;

    if (!request->box)
        return status_of_none(request, ret);
    r = OPS(request)->status(request->box, &json, &request->err);
    return box_give(ret, r, json);
}

int box_devices(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    r = OPS(request)->devices(request->box, &json, &request->err);
    return box_give(ret, r, json);
}

int box_boards(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    r = OPS(request)->boards(request->box, &json, &request->err);
    return box_give(ret, r, json);
}

static int give_board(struct ttf_http_request *request, const char *plan,
                      struct ttf_http_answer *ret)
{
    char *yaml = NULL;
    int r = named(request, request->match->name);

    if (r == 0 && plan)
        r = named(request, plan);
    if (r < 0)
        return r;
    r = OPS(request)->board(request->box, request->match->name, plan, &yaml, &request->err);
    return box_give(ret, r, yaml);
}

int box_board(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return give_board(request, NULL, ret);
}

int box_board_plan(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return give_board(request, request->match->path, ret);
}

int box_board_check(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    r = OPS(request)->board_check(request->box, request->body, request->body_bytes, &json,
                                  &request->err);
    return box_give(ret, r, json);
}

int box_board_put(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = named(request, request->match->name);

    return r < 0 ? r : put_text(request, OPS(request)->board_put, ret);
}

int box_board_delete(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = named(request, request->match->name);

    return r < 0 ? r : take_away(request, OPS(request)->board_delete, ret);
}

/* ---- plans ---- */

int box_plans(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    r = OPS(request)->plans(request->box, &json, &request->err);
    return box_give(ret, r, json);
}

int box_plan(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char *yaml = NULL;
    int r = named(request, name);

    if (r < 0)
        return r;
    r = OPS(request)->plan(request->box, name, &yaml, &request->err);
    return box_give(ret, r, yaml);
}

int box_plan_check(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    r = OPS(request)->plan_check(request->box, request->body, request->body_bytes, &json,
                                 &request->err);
    return box_give(ret, r, json);
}

int box_plan_put(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = named(request, request->match->name);

    return r < 0 ? r : put_text(request, OPS(request)->plan_put, ret);
}

int box_plan_delete(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = named(request, request->match->name);

    return r < 0 ? r : take_away(request, OPS(request)->plan_delete, ret);
}

int box_time(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int64_t utc_ns = 0;
    char *json = NULL;
    int r = box_needed(request);

    if (r == 0)
        r = body_time(request->body, request->body_bytes, &utc_ns, &request->err);
    if (r < 0)
        return r;
    r = OPS(request)->time(request->box, utc_ns, &json, &request->err);
    return box_give(ret, r, json);
}

/* ---- calibrations ---- */

int box_calibrations(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    r = OPS(request)->calibrations(request->box, &json, &request->err);
    return box_give(ret, r, json);
}

int box_calibrate(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    struct ttf_http_calibrate what;
    char *json = NULL;
    int r = named(request, request->match->name);

    if (r == 0)
        r = body_calibrate(request->body, request->body_bytes, &what, &request->err);
    if (r < 0)
        return r;
    memcpy(what.name, request->match->name, sizeof what.name);
    r = OPS(request)->calibrate(request->box, &what, &json, &request->err);
    return box_give(ret, r, json);
}

int box_calibration_use(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char name[65];
    int r = box_needed(request);

    if (r == 0)
        r = body_name(request->body, request->body_bytes, name, &request->err);
    if (r == 0)
        r = OPS(request)->calibration_use(request->box, name, &request->err);
    return r < 0 ? r : answer_done(request, ret);
}

int box_calibration_delete(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = named(request, request->match->name);

    return r < 0 ? r : take_away(request, OPS(request)->calibration_delete, ret);
}
