/* SPDX-License-Identifier: Apache-2.0 */
/* manifest_rules.h: what holds for names and for every dataset.json, read or written. */
#ifndef TTF_DATASET_MANIFEST_RULES_H
#define TTF_DATASET_MANIFEST_RULES_H

#include <stdbool.h>

#include "ttf/dataset/manifest.h"

/* A name of a dataset, folder or file: [A-Za-z0-9._-], 1..64, not "." or "..". */
bool ttf_name_ok(const char *name);

/* Names with '/' between: a path that cannot lead out of the dataset. */
bool ttf_path_ok(const char *path);

/* -EINVAL naming the field. */
TTF_MUST_USE int ttf_manifest_check(const struct ttf_manifest *m, const char *where,
                                    struct ttf_err *err);

#endif
