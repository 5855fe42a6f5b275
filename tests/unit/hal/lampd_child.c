/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lampd_child.c: a client to be killed: lampd_child SOCKET MS WHAT lights lamp 0, having declared its next sign of
 * life for MS from now, writes a line, and then WHAT: "waits" for a signal (a number: lit to so
 * many permille; "all": lamp 1, too), or "gives" further signs of life every 50 ms.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/base/time.h"
#include "ttf/hal/lampd.h"

int main(int argc, char **argv)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    int64_t life_ns = argc > 2 ? strtoll(argv[2], NULL, 10) * TTF_NS_PER_MS : 0;
    unsigned level = argc > 3 ? (unsigned)strtoul(argv[3], NULL, 10) : 0;
    struct ttf_lamps *lamps;
    struct ttf_err err = {0};

    if (argc != 4 || !clock || ttf_lamps_lampd_create(argv[1], clock, &lamps, &err) < 0 ||
        ttf_lamps_acquire(lamps, ttf_clock_now_ns(clock) + life_ns, &err) < 0 ||
        ttf_lamps_set(lamps, 0, level > 0 ? level : 1000, &err) < 0 ||
        (strcmp(argv[3], "all") == 0 && ttf_lamps_set(lamps, 1, 1000, &err) < 0)) {
        fprintf(stderr, "%s: %s\n", err.where, err.what);
        return 1;
    }
    (void)!write(STDOUT_FILENO, "lit\n", 4);
    while (strcmp(argv[3], "gives") == 0) {
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + 50 * TTF_NS_PER_MS);
        if (ttf_lamps_alive(lamps, ttf_clock_now_ns(clock) + life_ns, &err) < 0)
            return 1;
    }
    for (;;)
        pause();
}
