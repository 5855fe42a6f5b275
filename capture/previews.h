/* SPDX-License-Identifier: Apache-2.0 */
/* previews.h: preview/ of a dataset is derived and may be deleted at any time: the first to go when room runs out. */
#ifndef TTF_CAPTURE_PRIVATE_PREVIEWS_H
#define TTF_CAPTURE_PRIVATE_PREVIEWS_H

#include "ttf/base/attr.h"
#include "ttf/dataset/io.h"

/*
 * Removes files of preview/ and of the folders in it, in the order of their slots, until `free_bytes` are free or
 * none is left; folders stay. How many were removed, 0 where there were none or none can be. Allocates nothing.
 */
unsigned ttf_previews_remove(struct ttf_io *io, const char *dataset, int64_t free_bytes);

#endif
