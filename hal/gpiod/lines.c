/* SPDX-License-Identifier: Apache-2.0 */
/* lines.c: a bank of requested lines, whatever libgpiod's version. */
#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "ttf/hal/gpiod.h"
#include "wire.h"

struct gpiod_lines {
    struct ttf_lines base; /* first: downcast by address */
    struct wire *wire[TTF_LINES_MAX];
    int inputs; /* epoll of the inputs' descriptors; -1: there is no input */
};

int wire_number(const char *line)
{
    size_t n = strlen(line);

    if (n == 0 || n > 4 || strspn(line, "0123456789") != n)
        return -1;
    return (int)strtol(line, NULL, 10);
}

static void let_go(struct gpiod_lines *l)
{
    for (unsigned i = 0; i < l->base.n; i++) {
        wire_release(l->wire[i]);
        l->wire[i] = NULL;
    }
    if (l->inputs >= 0)
        (void)close(l->inputs);
    l->inputs = -1;
}

static int watch(struct gpiod_lines *l, unsigned i)
{
    struct epoll_event event = {.events = EPOLLIN, .data.u32 = i};

    if (l->inputs < 0)
        l->inputs = epoll_create1(EPOLL_CLOEXEC);
    if (l->inputs < 0 || epoll_ctl(l->inputs, EPOLL_CTL_ADD, wire_fd(l->wire[i]), &event) < 0)
        return -errno;
    return 0;
}

/*
 * Outputs first, and all of them, whichever fails: what may burn is dark before anything else can go wrong. The
 * first error counts.
 */
static int request(struct gpiod_lines *l, struct ttf_err *err)
{
    int r = 0;

    for (unsigned i = 0; i < l->base.n; i++) {
        int one = l->base.spec[i].input
                      ? 0
                      : wire_request(&l->base.spec[i], &l->wire[i], r == 0 ? err : NULL);

        if (r == 0)
            r = one;
    }
    for (unsigned i = 0; i < l->base.n && r == 0; i++)
        if (l->base.spec[i].input)
            r = wire_request(&l->base.spec[i], &l->wire[i], err);
    for (unsigned i = 0; i < l->base.n && r == 0; i++)
        if (l->base.spec[i].input && (r = watch(l, i)) < 0)
            ttf_err_set(err, r, l->base.spec[i].label, "its edges cannot be waited for");
    if (r < 0)
        let_go(l);
    return r;
}

static int gpiod_set(struct ttf_lines *base, unsigned i, unsigned permille)
{
    struct gpiod_lines *l = (struct gpiod_lines *)base;

    return l->wire[i] ? wire_set(l->wire[i], permille >= 500) : -ENODEV;
}

static int gpiod_get(struct ttf_lines *base, unsigned i)
{
    struct gpiod_lines *l = (struct gpiod_lines *)base;

    return l->wire[i] ? wire_get(l->wire[i]) : -ENODEV;
}

static int gpiod_fd(const struct ttf_lines *base)
{
    return ((const struct gpiod_lines *)base)->inputs;
}

static int gpiod_event(struct ttf_lines *base, struct ttf_line_event *ret)
{
    struct gpiod_lines *l = (struct gpiod_lines *)base;
    struct epoll_event waiting;
    int n = l->inputs < 0 ? 0 : epoll_wait(l->inputs, &waiting, 1, 0);
    int r;

    if (n <= 0)
        return n < 0 && errno != EINTR ? -errno : 0;
    if (!(waiting.events & EPOLLIN))
        return -ENODEV; /* hung up: the chip is gone */
    *ret = (struct ttf_line_event){.i = waiting.data.u32};
    r = wire_event(l->wire[ret->i], &ret->active);
    return r;
}

static int gpiod_reopen(struct ttf_lines *base, struct ttf_err *err)
{
    struct gpiod_lines *l = (struct gpiod_lines *)base;

    /* Lines on another chip than the one that went may be lit, and would stay so for as long as it is away. */
    for (unsigned i = 0; i < base->n; i++)
        if (!base->spec[i].input)
            (void)gpiod_set(base, i, 0);
    let_go(l);
    return request(l, err);
}

static void gpiod_destroy(struct ttf_lines *base)
{
    let_go((struct gpiod_lines *)base);
    free(base);
}

static const struct ttf_lines_ops OPS = {
    .name = "gpiod",
    .set = gpiod_set,
    .get = gpiod_get,
    .fd = gpiod_fd,
    .event = gpiod_event,
    .reopen = gpiod_reopen,
    .destroy = gpiod_destroy,
};

int ttf_lines_gpiod_create(const struct ttf_line_spec *specs, unsigned n, struct ttf_lines **ret,
                           struct ttf_err *err)
{
    struct gpiod_lines *l;
    int r = ttf_lines_check(specs, n, err);

    if (r < 0)
        return r;
    l = calloc(1, sizeof(*l));
    if (!l)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    l->base.ops = &OPS;
    l->base.n = n;
    l->inputs = -1;
    memcpy(l->base.spec, specs, n * sizeof(*specs));
    r = request(l, err);
    if (r < 0) {
        free(l);
        return r;
    }
    *ret = &l->base;
    return 0;
}

int ttf_lines_gpiod_holder(const struct ttf_line_spec *spec, char ret_holder[64],
                           struct ttf_err *err)
{
    return wire_holder(spec, ret_holder, err);
}

const char *ttf_lines_gpiod_version(void)
{
    return wire_version();
}
