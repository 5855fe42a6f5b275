/* SPDX-License-Identifier: Apache-2.0 */
/* progress.c: a bar on a terminal, nothing elsewhere. */
#include <inttypes.h>
#include <stdio.h>
#include <unistd.h>

#include "cli.h"

#define WIDTH 28

void cli_progress_begin(struct cli_progress *p, const struct cli *cli, const char *label)
{
    *p = (struct cli_progress){
        .shown = !cli->opt.quiet && isatty(STDERR_FILENO), .label = label, .percent = -1};
}

void cli_progress_at(struct cli_progress *p, int64_t done, int64_t total, const char *text)
{
    char bar[WIDTH + 1];
    int percent = total > 0 ? (int)(done * 100 / total) : -1;

    if (!p->shown || (p->drawn && percent == p->percent && !text && total > 0))
        return;
    p->percent = percent;
    if (total > 0) {
        for (int i = 0; i < WIDTH; i++)
            bar[i] = i * 100 < percent * WIDTH ? '#' : '.';
        bar[WIDTH] = '\0';
        (void)fprintf(stderr, "\r\033[K%s [%s] %3d%% %" PRId64 "/%" PRId64 " %.60s", p->label, bar,
                      percent, done, total, text ? text : "");
    } else {
        (void)fprintf(stderr, "\r\033[K%s %" PRId64 " %.60s", p->label, done, text ? text : "");
    }
    (void)fflush(stderr);
    p->drawn = true;
}

void cli_progress_end(struct cli_progress *p)
{
    if (p->drawn)
        (void)fputs("\r\033[K", stderr);
    p->drawn = false;
}
