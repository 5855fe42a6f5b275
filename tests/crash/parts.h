/* SPDX-License-Identifier: Apache-2.0 */
/* parts.h: work shared out to processes, each of which finds something that is added up. */
#ifndef TTF_TESTS_CRASH_PARTS_H
#define TTF_TESTS_CRASH_PARTS_H

#include <stdbool.h>
#include <stddef.h>

#define PARTS_MAX 64

/* As many as this machine has cores, at the most PARTS_MAX. */
unsigned parts_of_cores(void);

struct parts {
    unsigned n;   /* 1..PARTS_MAX */
    size_t bytes; /* of what each finds */
    void *ctx;
    void (*work)(void *ctx, unsigned part, void *ret); /* in a process of its own */
    void (*add)(void *ctx, const void *found);         /* in this one, in the parts' order */
};

/* False: one of them ended badly, or could not begin. */
bool parts_work(const struct parts *parts);

#endif
