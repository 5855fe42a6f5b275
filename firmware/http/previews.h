/* SPDX-License-Identifier: Apache-2.0 */
/* previews.h: the synthesized preview of a dataset, as ttfbox-preview leaves it beside the datasets (firmware/preview/). */
#ifndef HTTP_PREVIEWS_H
#define HTTP_PREVIEWS_H

#include <jansson.h>

#include "folder.h"
#include "request.h"

/*
 * Opens the state of the dataset's preview, and parses it into *ret_state (NULL: not wanted). A descriptor; -ENOENT: there is none, or it is
 * that of another dataset that had this name; -EINVAL, ...: it cannot be read.
 */
TTF_MUST_USE int previews_open(const struct folder *folder, const char *dataset,
                               struct stat *ret_stat, json_t **ret_state);

/* GET /api/v1/datasets/{name}/preview: its state, as JSON. */
int previews_state(struct ttf_http_request *request, struct ttf_http_answer *ret);

/* GET /api/v1/datasets/{name}/preview/{path}: a frame that the state names. */
int previews_frame(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
