/* SPDX-License-Identifier: Apache-2.0 */
/*
 * listed.h: what described.h answers, without reading SHA256SUMS each time: where each path's line lies, remembered of
 * the datasets that were asked for last, and read on as the list grows. What is answered is read from the list itself.
 * Any thread.
 */
#ifndef HTTP_LISTED_H
#define HTTP_LISTED_H

#include "folder.h"
#include "ttf/base/attr.h"

struct listed;

struct listed *listed_create(void); /* NULL: no memory */
void listed_destroy(struct listed *listed);

/* As described_sha256. */
TTF_MUST_USE int listed_sha256(struct listed *listed, const struct folder *folder,
                               const char *dataset, const char *path, char ret[65]);

/* As described_sealed. */
bool listed_sealed(struct listed *listed, const struct folder *folder, const char *dataset);

#endif
