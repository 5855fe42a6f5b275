/* SPDX-License-Identifier: Apache-2.0 */
/*
 * plan_file.h: a capture plan from YAML. The language: firmware/config/README.md.
 *
 * Every error names file:line:col and what was meant. What the file cannot know
 * (does the plan fit the box?) is ttf_plan_check's; ttf_plan_file_place turns the
 * field that it names into a line of the file.
 */
#ifndef TTF_CONFIG_PLAN_FILE_H
#define TTF_CONFIG_PLAN_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/capture/plan.h"
#include "ttf/hal/clock.h"

struct ttf_plan_file;

/* Reads and decodes. -ENOENT and other errors of opening; -EINVAL; -ENOMEM. */
TTF_MUST_USE int ttf_plan_file_load(const char *path, struct ttf_plan_file **ret,
                                    struct ttf_err *err);

/* The same from memory; `name` stands in messages. */
TTF_MUST_USE int ttf_plan_file_parse(const char *name, const char *text, size_t bytes,
                                     struct ttf_plan_file **ret, struct ttf_err *err);
void ttf_plan_file_free(struct ttf_plan_file *file); /* NULL allowed */

/* Belong to the file. */
const struct ttf_plan *ttf_plan_file_plan(const struct ttf_plan_file *file);
const char *ttf_plan_file_text(const struct ttf_plan_file *file);

/* Of a plan that names no zone; before it is resolved. An empty one changes nothing. */
void ttf_plan_file_default_zone(struct ttf_plan_file *file, const char *zone);

/*
 * Resolves the plan's zone at that instant (or at its own start) into an offset,
 * once: nothing follows daylight-saving changes later. -EINVAL for a zone that this
 * machine does not know.
 */
TTF_MUST_USE int ttf_plan_file_resolve(struct ttf_plan_file *file, int64_t now_utc_ns,
                                       struct ttf_err *err);

/*
 * -EINVAL, placed, if the plan's start has passed by that clock, for a plan that is to begin:
 * its first slots would be missed at once. A clock that nobody vouches for (trust none)
 * refuses nothing.
 */
TTF_MUST_USE int ttf_plan_file_check_start(const struct ttf_plan_file *file,
                                           const struct ttf_utc *now, struct ttf_err *err);

/*
 * -EBUSY, placed, if the plan has a start and nobody vouches for that clock: a plan that is to begin cannot, until somebody
 * does. As start times mean nothing then, ttf_plan_file_check_start says nothing.
 */
TTF_MUST_USE int ttf_plan_file_check_clock(const struct ttf_plan_file *file,
                                           const struct ttf_utc *now, struct ttf_err *err);

/*
 * err->where names a field of the plan ("shots[1].exposure"): puts the file,
 * line and column there and the field in front of what. Harmless for others.
 */
void ttf_plan_file_place(const struct ttf_plan_file *file, struct ttf_err *err);

/*
 * The offset from UTC of a zone ("UTC", "Europe/Berlin") at an instant, in
 * seconds, from the machine's zone files. -ENOENT, -EINVAL.
 */
TTF_MUST_USE int ttf_zone_offset(const char *zone, int64_t utc_ns, int *ret_offset_s,
                                 struct ttf_err *err);

#endif
