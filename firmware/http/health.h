/* SPDX-License-Identifier: Apache-2.0 */
/* health.h: is anybody there? */
#ifndef HTTP_HEALTH_H
#define HTTP_HEALTH_H

#include "request.h"

int health_answer(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
