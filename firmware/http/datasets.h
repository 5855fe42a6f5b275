/* SPDX-License-Identifier: Apache-2.0 */
/* datasets.h: answers about datasets (openapi.yaml). Each returns 0, or a negative errno with *err set in it. */
#ifndef HTTP_DATASETS_H
#define HTTP_DATASETS_H

#include "request.h"

int datasets_list(struct ttf_http_request *request, struct ttf_http_answer *ret);
int datasets_one(struct ttf_http_request *request, struct ttf_http_answer *ret);
int datasets_records(struct ttf_http_request *request, struct ttf_http_answer *ret);
int datasets_file(struct ttf_http_request *request, struct ttf_http_answer *ret);
int datasets_notes(struct ttf_http_request *request, struct ttf_http_answer *ret);
int datasets_events(struct ttf_http_request *request, struct ttf_http_answer *ret);
int datasets_tar(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
