/* SPDX-License-Identifier: Apache-2.0 */
/* run_answers.h: what is asked of a run, and pictures of it (openapi.yaml). Each returns 0, or a negative errno with *err set in it. */
#ifndef HTTP_RUN_ANSWERS_H
#define HTTP_RUN_ANSWERS_H

#include "request.h"

int run_start(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_stop(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_pause(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_resume(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_change(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_asked(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_note(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_latest(struct ttf_http_request *request, struct ttf_http_answer *ret);
int run_live(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
