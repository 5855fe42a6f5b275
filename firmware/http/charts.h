/* SPDX-License-Identifier: Apache-2.0 */
/* charts.h: what charts of a dataset are drawn from. */
#ifndef HTTP_CHARTS_H
#define HTTP_CHARTS_H

#include "request.h"

/* GET /api/v1/datasets/{name}/charts. 0, or a negative errno with request->err set. */
int charts_answer(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
