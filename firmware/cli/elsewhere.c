/* SPDX-License-Identifier: Apache-2.0 */
#include "elsewhere.h"

#include <stdio.h>
#include <string.h>

#include "ttf/capture/session.h"
#include "ttf/config/plan_file.h"

/* The plan in force as it was given; NULL: it was not kept, or cannot be read. */
static struct ttf_plan_file *plan_of(struct ttf_reader *reader)
{
    struct ttf_plan_file *file = NULL;
    struct ttf_segment last;
    char path[4096 + 32];

    if (ttf_reader_segment(reader, ttf_reader_summary(reader)->n_segments - 1, &last) < 0 ||
        last.plan < 0)
        return NULL;
    (void)snprintf(path, sizeof path, "%s/plans/%d.yaml", ttf_reader_path(reader), last.plan);
    return ttf_plan_file_load(path, &file, NULL) < 0 ? NULL : file;
}

void cli_say_elsewhere(struct cli *cli, struct ttf_reader *reader)
{
    const char *path = ttf_reader_path(reader);
    struct ttf_plan_file *file;
    struct ttf_err err = {0};
    char there[4096];

    if (strcmp(ttf_reader_manifest(reader)->group_member, "first") != 0)
        return;
    file = plan_of(reader);
    if (!file)
        return;
    if (ttf_session_find(cli->io, path, ttf_plan_file_plan(file), there, sizeof there, &err) < 0) {
        cli_say(cli, "goes on           perhaps: %s", err.what);
    } else if (strcmp(there, path) != 0) {
        cli_say(cli, "goes on in        %s", there);
        ttf_json_kstring(&cli->out, "goes_on_in", there);
    }
    ttf_plan_file_free(file);
}
