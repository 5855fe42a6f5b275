/* SPDX-License-Identifier: Apache-2.0 */
/* web.h: the page: files of firmware/web, which are part of the program (web.cmake makes the table). */
#ifndef HTTP_WEB_H
#define HTTP_WEB_H

#include <stddef.h>

#include "request.h"

struct web_file {
    const char *path; /* below firmware/web: "index.html" */
    const char *sha256;
    const unsigned char *bytes;
    size_t n;
};

extern const struct web_file WEB_FILES[];
extern const size_t WEB_FILES_N;

/* Routes: index.html, and any other. */
int web_index(struct ttf_http_request *request, struct ttf_http_answer *ret);
int web_file_of_page(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
