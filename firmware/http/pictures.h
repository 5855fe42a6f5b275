/* SPDX-License-Identifier: Apache-2.0 */
/* pictures.h: pictures of datasets for a screen; the last one made is remembered, as many may ask for it. Any thread. */
#ifndef HTTP_PICTURES_H
#define HTTP_PICTURES_H

#include "request.h"

struct pictures;

struct pictures *pictures_create(void);           /* NULL: no memory */
void pictures_destroy(struct pictures *pictures); /* NULL allowed */

/* The newest picture of a dataset, as an answer. -ENOENT: there is none yet. */
int pictures_newest(struct ttf_http_request *request, const char *dataset,
                    struct ttf_http_answer *ret);

#endif
