/* SPDX-License-Identifier: Apache-2.0 */
/* manifest_rules.h: what holds for names and for every dataset.json, read or written. */
#ifndef TTF_DATASET_MANIFEST_RULES_H
#define TTF_DATASET_MANIFEST_RULES_H

#include <stdbool.h>

#include "ttf/dataset/copy.h"
#include "ttf/dataset/manifest.h"

/* -EINVAL naming the field. */
TTF_MUST_USE int ttf_manifest_check(const struct ttf_manifest *m, const char *where,
                                    struct ttf_err *err);

#endif
