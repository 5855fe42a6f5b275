/* SPDX-License-Identifier: Apache-2.0 */
#include "group.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "path_name.h"

#define MEMBER_MAX 1000000

/* One farther than it. "first" and "second" are one run, which may have been the group's first. */
static void next_member(const struct ttf_manifest *of, char ret[32])
{
    long n = strtol(of->group_member, NULL, 10);

    snprintf(ret, 32, "%ld", n >= 2 && n < MEMBER_MAX ? n + 1 : 2);
}

static int load(struct ttf_io *io, const char *path, const struct ttf_plan *plan,
                struct ttf_manifest *ret, struct ttf_err *err)
{
    char beside[4096 + 80];
    size_t name;
    const size_t at = ttf_path_name(path, &name);
    int r;

    if (strlen(plan->group) == name && strncmp(path + at, plan->group, name) == 0) {
        ttf_err_set(err, -EINVAL, "group", "this is the run's own dataset");
        return -EINVAL;
    }
    snprintf(beside, sizeof(beside), "%.*s%s", (int)at, path, plan->group);
    r = ttf_manifest_load(io, beside, ret, err);
    if (r == -ENOENT && plan->second_storage[0]) {
        snprintf(beside, sizeof(beside), "%s/%s", plan->second_storage, plan->group);
        r = ttf_manifest_load(io, beside, ret, err);
    }
    if (r != -ENOENT)
        return r;
    ttf_err_set(err, -EINVAL, "group", "there is no dataset '%s' beside %s", plan->group, path);
    ttf_err_hint(err, "group names a dataset in the same folder, whose group the run is to be of");
    return -EINVAL;
}

int ttf_group_of_plan(struct ttf_io *io, const char *path, const struct ttf_plan *plan,
                      bool simulated, struct ttf_group *ret, struct ttf_err *err)
{
    struct ttf_manifest of;
    int r;

    memset(ret, 0, sizeof(*ret));
    if (plan->group[0] == '\0')
        return 0;
    r = load(io, path, plan, &of, err);
    if (r < 0)
        return r;
    if (of.rehearsal)
        return ttf_err_set(err, -EINVAL, "group", "'%s' is a rehearsal, which is of no group",
                           plan->group);
    if (of.simulated != simulated)
        return ttf_err_set(err, -EINVAL, "group",
                           "a simulated and a real capture cannot be of one group");
    snprintf(ret->uuid, sizeof(ret->uuid), "%s", ttf_manifest_group(&of));
    next_member(&of, ret->member);
    return 0;
}
