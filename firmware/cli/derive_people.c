/* SPDX-License-Identifier: Apache-2.0 */
/*
 * derive_people.c: what people said of a dataset, for one whose slots and pixels are the same. The files as they are: whoever reads them passes
 * over what he does not understand, and it is not this program's to take out.
 */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "commands.h"
#include "derive.h"

#define BYTES_MAX ((size_t)64 << 20)

/* Nothing if there is none; a link would be somebody else's file. */
static int copy_file(struct cli *cli, const char *from, const char *to, struct ttf_err *err)
{
    struct stat st;
    char *text = NULL;
    size_t bytes = 0;
    int r;

    if (lstat(from, &st) < 0)
        return errno == ENOENT ? 0 : ttf_err_set(err, -errno, from, "cannot be looked at");
    if (!S_ISREG(st.st_mode))
        return ttf_err_set(err, -EINVAL, from, "is no plain file");
    r = ttf_io_slurp(cli->io, from, BYTES_MAX, &text, &bytes, err);
    if (r == 0)
        r = ttf_io_write_file(cli->io, to, text, bytes, err);
    free(text);
    return r;
}

void derive_people(struct cli *cli, const char *from, const char *to)
{
    static const char *const NAMES[] = {"notes.jsonl", "samples.json"};

    for (unsigned i = 0; i < TTF_COUNT_OF(NAMES); i++) {
        char source[PATH_MAX], copy[PATH_MAX], text[900];
        struct ttf_err err = {0};

        (void)snprintf(source, sizeof source, "%s/%s", from, NAMES[i]);
        (void)snprintf(copy, sizeof copy, "%s/%s", to, NAMES[i]);
        if (copy_file(cli, source, copy, &err) < 0)
            cli_warn("ttfbox %s: warning: %s is not taken over: %s", cli->command->name, NAMES[i],
                     ttf_err_text(&err, text, sizeof text));
    }
}
