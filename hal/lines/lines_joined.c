/* SPDX-License-Identifier: Apache-2.0 */
/* lines_joined.c: a bank made of banks: lamps on a GPIO chip beside lamps on PWM channels. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/hal/lines.h"

struct joined_lines {
    struct ttf_lines base; /* first: downcast by address */
    unsigned n_banks;
    struct ttf_lines *bank[TTF_LINES_MAX];
    struct {
        unsigned bank, i;
    } at[TTF_LINES_MAX];
};

static int joined_set(struct ttf_lines *base, unsigned i, unsigned permille)
{
    struct joined_lines *j = (struct joined_lines *)base;

    return ttf_lines_set(j->bank[j->at[i].bank], j->at[i].i, permille);
}

static int joined_get(struct ttf_lines *base, unsigned i)
{
    struct joined_lines *j = (struct joined_lines *)base;

    return ttf_lines_get(j->bank[j->at[i].bank], j->at[i].i);
}

static bool has_input(const struct ttf_lines *bank)
{
    for (unsigned i = 0; i < bank->n; i++)
        if (bank->spec[i].input)
            return true;
    return false;
}

/* One descriptor can wait for one bank: of more with inputs none is waited for, all are looked at. */
static int joined_fd(const struct ttf_lines *base)
{
    const struct joined_lines *j = (const struct joined_lines *)base;
    unsigned n = 0;
    int fd = -1;

    for (unsigned b = 0; b < j->n_banks; b++)
        if (has_input(j->bank[b])) {
            fd = ttf_lines_fd(j->bank[b]);
            n++;
        }
    return n == 1 ? fd : -1;
}

static int joined_event(struct ttf_lines *base, struct ttf_line_event *ret)
{
    struct joined_lines *j = (struct joined_lines *)base;
    struct ttf_line_event event;
    int r = 0;

    for (unsigned b = 0; b < j->n_banks && r == 0; b++) {
        r = ttf_lines_event(j->bank[b], &event);
        for (unsigned i = 0; r == 1 && i < base->n; i++)
            if (j->at[i].bank == b && j->at[i].i == event.i) {
                *ret = event;
                ret->i = i;
            }
    }
    return r;
}

/* Each is tried, so that what can be dark is; the first that is not there counts. */
static int joined_reopen(struct ttf_lines *base, struct ttf_err *err)
{
    struct joined_lines *j = (struct joined_lines *)base;
    int first = 0;

    for (unsigned b = 0; b < j->n_banks; b++) {
        int r = ttf_lines_reopen(j->bank[b], first == 0 ? err : NULL);

        if (first == 0)
            first = r;
    }
    return first;
}

static void joined_destroy(struct ttf_lines *base)
{
    struct joined_lines *j = (struct joined_lines *)base;

    for (unsigned b = 0; b < j->n_banks; b++)
        ttf_lines_destroy(j->bank[b]);
    free(j);
}

static const struct ttf_lines_ops OPS = {
    .name = "joined",
    .set = joined_set,
    .get = joined_get,
    .fd = joined_fd,
    .event = joined_event,
    .reopen = joined_reopen,
    .destroy = joined_destroy,
};

/* Where the line of that label is. */
static bool place(struct joined_lines *j, unsigned i)
{
    for (unsigned b = 0; b < j->n_banks; b++)
        for (unsigned k = 0; k < j->bank[b]->n; k++)
            if (strcmp(j->bank[b]->spec[k].label, j->base.spec[i].label) == 0) {
                j->at[i].bank = b;
                j->at[i].i = k;
                return true;
            }
    return false;
}

int ttf_lines_joined_create(const struct ttf_line_spec *specs, unsigned n,
                            struct ttf_lines *const *banks, unsigned n_banks,
                            struct ttf_lines **ret, struct ttf_err *err)
{
    struct joined_lines *j;
    int r = ttf_lines_check(specs, n, err);

    if (r == 0 && (n_banks == 0 || n_banks > TTF_LINES_MAX))
        r = ttf_err_set(err, -EINVAL, "lines", "%u banks to join", n_banks);
    if (r < 0)
        return r;
    j = calloc(1, sizeof(*j));
    if (!j)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    j->base.ops = &OPS;
    j->base.n = n;
    j->n_banks = n_banks;
    memcpy(j->base.spec, specs, n * sizeof(*specs));
    for (unsigned i = 0; i < n_banks; i++)
        j->bank[i] = banks[i];
    for (unsigned i = 0; i < n && r == 0; i++)
        if (!place(j, i))
            r = ttf_err_set(err, -EINVAL, specs[i].label, "no bank has this line");
    if (r < 0) {
        free(j);
        return r;
    }
    *ret = &j->base;
    return 0;
}
