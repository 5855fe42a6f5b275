/* SPDX-License-Identifier: Apache-2.0 */
/* preview_video.h: the frames of a synthesized preview as one file that players open. */
#ifndef HTTP_PREVIEW_VIDEO_H
#define HTTP_PREVIEW_VIDEO_H

#include "request.h"

/* GET /api/v1/datasets/{name}/preview.avi: motion JPEG, by Range. 0, or a negative errno with request->err set. */
int preview_video(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
