/* SPDX-License-Identifier: Apache-2.0 */
/*
 * second_storage.h: where a run goes on when its dataset's storage has failed for good: in a dataset of the
 * same name in the plan's second storage, of the same group (README.md, "When the storage fails"). The
 * group's uuid is the first dataset's own, or that of the group it was begun in, so that either finds the other.
 */
#ifndef TTF_CAPTURE_PRIVATE_SECOND_STORAGE_H
#define TTF_CAPTURE_PRIVATE_SECOND_STORAGE_H

#include "ttf/capture/plan.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/writer.h"

#define TTF_MEMBER_FIRST  "first"
#define TTF_MEMBER_SECOND "second"

/* Path of the dataset that goes on there; empty if the plan has no second storage. -ENAMETOOLONG. */
TTF_MUST_USE int ttf_second_path(const struct ttf_plan *plan, const char *first, char *ret,
                                 size_t size, struct ttf_err *err);

/*
 * Has the run moved on? 1: it goes on in the second dataset; 0: in the first (a second one may have been made
 * and never begun). -EEXIST: what lies there is not of this run. -ENODEV, -EINVAL: it moved on, or may have, and the
 * second storage is not there (second_left.h). Other codes: what lies there cannot be read.
 */
TTF_MUST_USE int ttf_second_find(struct ttf_io *io, const char *first, const char *second,
                                 struct ttf_err *err);

/* What the second dataset says of itself, from the first's. */
TTF_MUST_USE int ttf_second_manifest(const struct ttf_manifest *first, struct ttf_manifest *ret,
                                     struct ttf_err *err);

/* A plan as it is stored. */
struct ttf_plan_text {
    const char *json;
    const char *yaml; /* as given; NULL: not known */
};

/*
 * Makes it with this plan, or opens one that was made and never begun; its plan may be another one by now: then this
 * one is added. given: the plan that whoever runs it has in his hand, where it is another one; else NULL. It comes
 * before the one in force, so that it is known there as what the run has moved on from. The number that the plan in
 * force has there; negative errno.
 */
TTF_MUST_USE int ttf_second_open(struct ttf_io *io, const char *path,
                                 const struct ttf_manifest *manifest,
                                 const struct ttf_plan_text *given,
                                 const struct ttf_plan_text *in_force, struct ttf_writer **ret,
                                 struct ttf_err *err);

/* A dataset that can be read and not written, as a writer would know it. Its manifest as well. */
TTF_MUST_USE int ttf_second_state_of(struct ttf_io *io, const char *first,
                                     struct ttf_writer_state *ret,
                                     struct ttf_manifest *ret_manifest, struct ttf_err *err);

#endif
