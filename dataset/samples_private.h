/* SPDX-License-Identifier: Apache-2.0 */
/* samples_private.h: what reading and writing samples.json share. */
#ifndef TTF_DATASET_SAMPLES_PRIVATE_H
#define TTF_DATASET_SAMPLES_PRIVATE_H

#include <jansson.h>
#include <stddef.h>

#include "ttf/dataset/samples.h"

#define TTF_SAMPLES_BYTES_MAX ((size_t)1 << 20)

/*
 * The text, parsed and found to be as FORMAT.md has it. ret_root may be NULL; else it is to be released by json_decref, and "samples" in it are
 * those of *ret, in their order. -EINVAL naming what is wrong; -ENOMEM.
 */
TTF_MUST_USE int ttf_samples_parse(const char *text, size_t n, struct ttf_sample_region **ret,
                                   unsigned *ret_n, json_t **ret_root, struct ttf_err *err);

#endif
