/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_say.h: what a quilting says of its result, to people and as JSON. */
#ifndef CLI_QUILT_SAY_H
#define CLI_QUILT_SAY_H

#include "quilt_job.h"

void quilt_say(struct quilt_job *job);

#endif
