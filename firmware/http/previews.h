/* SPDX-License-Identifier: Apache-2.0 */
/* previews.h: the synthesized preview of a dataset, as ttfbox-preview leaves it beside the datasets (firmware/preview/). */
#ifndef HTTP_PREVIEWS_H
#define HTTP_PREVIEWS_H

#include "request.h"

/* GET /api/v1/datasets/{name}/preview: its state, as JSON. */
int previews_state(struct ttf_http_request *request, struct ttf_http_answer *ret);

/* GET /api/v1/datasets/{name}/preview/{path}: a frame that the state names. */
int previews_frame(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
