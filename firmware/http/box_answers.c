/* SPDX-License-Identifier: Apache-2.0 */
#include "box_answers.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

int box_none(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    (void)ret;
    return ttf_err_set(&request->err, -ENODEV, NULL, "this server has no box");
}

int box_status(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *text = malloc(80);
    int n;

    if (!text)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    n = snprintf(text, 80, "{\"version\":\"%s\",\"state\":\"none\"}", TTFBOX_VERSION);
    answer_json(ret, text, (size_t)n);
    return 0;
}
