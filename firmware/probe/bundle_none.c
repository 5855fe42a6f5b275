/* SPDX-License-Identifier: Apache-2.0 */
/* bundle_none.c: a program without libarchive: ttfbox, which hands that option over, and a build that has none. */
#include <errno.h>

#include "probe.h"

int probe_bundle(const struct probe_machine *machine, const char *path, const char *board_path,
                 const char *report, struct ttf_err *err)
{
    ttf_err_set(err, -ENOTSUP, "--bundle", "this program was built without libarchive");
    ttf_err_hint(err, "attach the output of --json instead");
    return -ENOTSUP;
}
