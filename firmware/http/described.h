/* SPDX-License-Identifier: Apache-2.0 */
/* described.h: the SHA-256 that a dataset itself gives for one of its files. */
#ifndef HTTP_DESCRIBED_H
#define HTTP_DESCRIBED_H

#include <stdbool.h>

#include "folder.h"

/* From SHA256SUMS, hex. -ENODATA: it does not list this path. Reads that list, by pieces, at each call: a thread's own time. */
TTF_MUST_USE int described_sha256(const struct folder *folder, const char *dataset,
                                  const char *path, char ret[65]);

/* Is SHA256SUMS a seal (does it list records.jsonl)? */
bool described_sealed(const struct folder *folder, const char *dataset);

#endif
