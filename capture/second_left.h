/* SPDX-License-Identifier: Apache-2.0 */
/*
 * second_left.h: a first dataset knows that its run has left it for the second storage: by the detail of the event
 * that says so. A second storage in which nothing of the run lies is then not there: a disk that is not
 * mounted, whose mount point is a folder like any other.
 */
#ifndef TTF_CAPTURE_PRIVATE_SECOND_LEFT_H
#define TTF_CAPTURE_PRIVATE_SECOND_LEFT_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define TTF_SECOND_LEFT_SIZE 80

/* The event's detail. n_segments: of the dataset that is left; slot: the first that is not its own. */
void ttf_second_put_left(int n_segments, int64_t slot, char ret[TTF_SECOND_LEFT_SIZE]);

/*
 * Nothing of the run is begun at `second`: 0 if the one that lies at `first`, or a new one, may be. -ENODEV: it was left for
 * the second storage, and no segment has come to it since. -EINVAL: the second storage's folder is not there, and
 * the first is begun and not ended. -ENOMEM. Reads the first only.
 */
TTF_MUST_USE int ttf_second_expect_not_left(struct ttf_io *io, const char *first,
                                            const char *second, struct ttf_err *err);

#endif
