/* SPDX-License-Identifier: Apache-2.0 */
/* box_answers.h: answers about the box (openapi.yaml). Each returns 0, or a negative errno with *err set in it. */
#ifndef HTTP_BOX_ANSWERS_H
#define HTTP_BOX_ANSWERS_H

#include "request.h"

int box_status(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_devices(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_boards(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_board(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_board_plan(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_plans(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_plan(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_board_check(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_board_put(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_board_delete(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_plan_check(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_plan_put(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_plan_delete(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_time(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_calibrations(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_calibrate(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_calibration_delete(struct ttf_http_request *request, struct ttf_http_answer *ret);
int box_calibration_use(struct ttf_http_request *request, struct ttf_http_answer *ret);

/* Ready for the door's functions: 0, or -ENODEV: this server has no box. */
TTF_MUST_USE int box_needed(struct ttf_http_request *request);

/* What a function of the door gave, with its code, as the answer: JSON. */
int box_give(struct ttf_http_answer *answer, int r, char *json);

#endif
