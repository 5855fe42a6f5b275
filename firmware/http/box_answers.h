/* SPDX-License-Identifier: Apache-2.0 */
/* box_answers.h: answers about the box (openapi.yaml). Each returns 0, or a negative errno with *err set in it. */
#ifndef HTTP_BOX_ANSWERS_H
#define HTTP_BOX_ANSWERS_H

#include "request.h"

/* -ENODEV: this server has no box. */
int box_none(struct ttf_http_request *request, struct ttf_http_answer *ret);

int box_status(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
