/* SPDX-License-Identifier: Apache-2.0 */
/*
 * group.h: datasets that belong together: a run that begins in the group of another one, because its plan needs streams
 * that that one does not have (README.md, "Groups"). dataset.json is written once, so the first of a group may not say
 * that it is of one: the group's uuid is its own then.
 */
#ifndef TTF_CAPTURE_PRIVATE_GROUP_H
#define TTF_CAPTURE_PRIVATE_GROUP_H

#include "ttf/capture/plan.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"

struct ttf_group {
    char uuid[37];   /* empty: none */
    char member[32]; /* "2" after the first, then "3", ...; not unique: FORMAT.md, group.member */
};

/*
 * The group that the plan of a run into `path` names: of the dataset of that name beside it, or, if there is none, in the plan's second storage.
 * Empty if the plan names none. -EINVAL, field "group": it is not there, is no capture to join, or is the run's own.
 */
TTF_MUST_USE int ttf_group_of_plan(struct ttf_io *io, const char *path, const struct ttf_plan *plan,
                                   bool simulated, struct ttf_group *ret, struct ttf_err *err);

#endif
