/* SPDX-License-Identifier: Apache-2.0 */
/* thumbs.h: a slot as a small JPEG: the dataset's own preview of it, else made from its image and remembered. */
#ifndef HTTP_THUMBS_H
#define HTTP_THUMBS_H

#include "request.h"

struct thumbs;

struct thumbs *thumbs_create(void); /* NULL: no memory */
void thumbs_destroy(struct thumbs *thumbs);

/* GET /api/v1/datasets/{name}/thumbs/{path}, path being a slot's index. Slow. */
int thumbs_answer(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
