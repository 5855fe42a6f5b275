/* SPDX-License-Identifier: Apache-2.0 */
/*
 * charts.h: what charts of a dataset are drawn from, remembered of the datasets asked for last: a dataset that grows is
 * read on from where it was read to. Any thread.
 */
#ifndef HTTP_CHARTS_H
#define HTTP_CHARTS_H

#include "request.h"

struct charts;

struct charts *charts_create(void); /* NULL: no memory */
void charts_destroy(struct charts *charts);

/* GET /api/v1/datasets/{name}/charts. 0, or a negative errno with request->err set. */
int charts_answer(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
