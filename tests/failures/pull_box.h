/* SPDX-License-Identifier: Apache-2.0 */
/* pull_box.h: a box in this process whose dataset "d" is pulled onto a disk in memory, and what must hold of what came. */
#ifndef TTF_TESTS_PULL_BOX_H
#define TTF_TESTS_PULL_BOX_H

#include "small_run.h"
#include "ttf/hal/clock.h"
#include "ttf/http/server.h"
#include "ttf/pull/pull.h"

struct pull_box {
    struct model_disk disk; /* the dataset in memory, to compare with */
    struct ttf_clock *clock;
    struct ttf_http_server *server;
};

/* In the working folder. The small run's dataset; or one of so many slots of a file each, sealed. */
void pull_box_begin(struct pull_box *box, int slots);
void pull_box_end(struct pull_box *box);

int pull_box_pull(struct pull_box *box, struct model_disk *disk, struct ttf_pull_result *ret,
                  struct ttf_err *err);

/* Whatever of the dataset is here is whole. If not: what is wrong. */
bool pull_box_is_whole(struct model_disk *disk, char ret[SMALL_TEXT]);

/* All of it is here. */
bool pull_box_is_same(const struct pull_box *box, const struct model_disk *disk,
                      char ret[SMALL_TEXT]);

#endif
