/* SPDX-License-Identifier: Apache-2.0 */
#include "run_answers.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "body.h"
#include "box_answers.h"
#include "pictures.h"

/* ---- a run ---- */

int run_start(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char plan[65], dataset[65], *json = NULL;
    int r = box_needed(request);

    if (r == 0)
        r = body_start(request->body, request->body_bytes, plan, dataset, &request->err);
    if (r < 0)
        return r;
    r = request->box->ops->start(request->box, plan, dataset, &json, &request->err);
    return box_give(ret, r, json);
}

static int ask(struct ttf_http_request *request, const struct ttf_http_ask *what,
               struct ttf_http_answer *ret)
{
    char *json = NULL;
    int r = request->box->ops->ask(request->box, what, &json, &request->err);

    return box_give(ret, r, json);
}

int run_stop(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = box_needed(request);

    return r < 0 ? r : ask(request, &(struct ttf_http_ask){.kind = TTF_HTTP_ASK_STOP}, ret);
}

int run_pause(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    struct ttf_http_ask what;
    int r = box_needed(request);

    if (r == 0)
        r = body_pause(request->body, request->body_bytes, &what, &request->err);
    return r < 0 ? r : ask(request, &what, ret);
}

int run_resume(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    int r = box_needed(request);

    return r < 0 ? r : ask(request, &(struct ttf_http_ask){.kind = TTF_HTTP_ASK_RESUME}, ret);
}

int run_change(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    struct ttf_http_ask what;
    int r = box_needed(request);

    if (r == 0)
        r = body_change(request->body, request->body_bytes, &what, &request->err);
    return r < 0 ? r : ask(request, &what, ret);
}

int run_asked(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char *json = NULL;
    int r = box_needed(request);

    if (r < 0)
        return r;
    if (strspn(name, "0123456789") != strlen(name) || strlen(name) > 18)
        return ttf_err_set(&request->err, -ENOENT, NULL, "nothing of this number was asked");
    r = request->box->ops->asked(request->box, strtoll(name, NULL, 10), &json, &request->err);
    return box_give(ret, r, json);
}

int run_note(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    struct ttf_note note;
    char path[4096];
    int r = box_needed(request);

    if (r == 0 && folder_dataset(request->folder, name, path, sizeof path) < 0)
        r = ttf_err_set(&request->err, -ENOENT, NULL, "there is no dataset of this name");
    if (r == 0)
        r = body_note(request->body, request->body_bytes, &note, &request->err);
    if (r == 0)
        r = request->box->ops->note(request->box, name, &note, &request->err);
    return r < 0 ? r : answer_done(request, ret);
}

/* ---- pictures ---- */

int run_latest(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char dataset[65];
    int r = box_needed(request);

    if (r == 0)
        r = request->box->ops->newest(request->box, dataset, &request->err);
    return r < 0 ? r : pictures_newest(request, dataset, ret);
}

int run_live(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const struct body_view said = {.camera = request_query(request, "camera"),
                                   .exposure_ns = request_query(request, "exposure_ns"),
                                   .gain_milli = request_query(request, "gain_milli"),
                                   .lamps = request_query(request, "lamps"),
                                   .region = request_query(request, "region")};
    struct ttf_http_view view;
    struct ttf_http_shown shown = {0};
    int r = box_needed(request);

    if (r == 0)
        r = body_view(&said, &view, &request->err);
    if (r < 0)
        return r;
    r = request->box->ops->live(request->box, &view, &shown, &request->err);
    if (r == -EBUSY) { /* a run is under way: its camera is left alone */
        memset(&request->err, 0, sizeof request->err);
        answer_header(ret, "X-Ttfbox-Live", "latest");
        return run_latest(request, ret);
    }
    if (r < 0)
        return r;
    answer_json(ret, shown.jpeg, shown.bytes);
    answer_header(ret, "X-Ttfbox-Live", "camera");
    if (shown.exposure_ns > 0) {
        answer_header(ret, "X-Ttfbox-Exposure-Ns", "%" PRId64, shown.exposure_ns);
        answer_header(ret, "X-Ttfbox-Gain-Milli", "%" PRId64, shown.gain_milli);
    }
    return 0;
}
