/* SPDX-License-Identifier: Apache-2.0 */
#include "health.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

int health_answer(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *text = malloc(80);
    int n;

    if (!text)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    n = snprintf(text, 80, "{\"ok\":true,\"version\":\"%s\"}", TTFBOX_VERSION);
    answer_json(ret, text, (size_t)n);
    return 0;
}
