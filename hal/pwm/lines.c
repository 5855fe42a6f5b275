/* SPDX-License-Identifier: Apache-2.0 */
/* lines.c: a bank of PWM channels. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "channel.h"
#include "ttf/hal/pwm.h"

struct pwm_lines {
    struct ttf_lines base; /* first: downcast by address */
    char root[128];
    struct pwm_channel channel[TTF_LINES_MAX];
};

static void let_go(struct pwm_lines *p)
{
    for (unsigned i = 0; i < p->base.n; i++)
        pwm_channel_drop(&p->channel[i]);
}

/* All are tried: what can be made dark is, whatever another says. The first error counts. */
static int hold_all(struct pwm_lines *p, struct ttf_err *err)
{
    int first = 0;

    for (unsigned i = 0; i < p->base.n; i++) {
        int r =
            pwm_channel_hold(p->root, &p->base.spec[i], &p->channel[i], first == 0 ? err : NULL);

        if (first == 0)
            first = r;
    }
    if (first < 0)
        let_go(p);
    return first;
}

static int pwm_set(struct ttf_lines *base, unsigned i, unsigned permille)
{
    return pwm_channel_set(&((struct pwm_lines *)base)->channel[i], permille);
}

static int pwm_get(struct ttf_lines *base, unsigned i)
{
    return pwm_channel_get(&((struct pwm_lines *)base)->channel[i]);
}

static int pwm_fd(const struct ttf_lines *base)
{
    (void)base;
    return -1;
}

static int pwm_event(struct ttf_lines *base, struct ttf_line_event *ret)
{
    (void)base;
    (void)ret;
    return 0;
}

static int pwm_reopen(struct ttf_lines *base, struct ttf_err *err)
{
    struct pwm_lines *p = (struct pwm_lines *)base;

    let_go(p);
    return hold_all(p, err);
}

static void pwm_destroy(struct ttf_lines *base)
{
    let_go((struct pwm_lines *)base);
    free(base);
}

static const struct ttf_lines_ops OPS = {
    .name = "pwm",
    .set = pwm_set,
    .get = pwm_get,
    .fd = pwm_fd,
    .event = pwm_event,
    .reopen = pwm_reopen,
    .destroy = pwm_destroy,
};

static int check(const struct ttf_line_spec *spec, struct ttf_err *err)
{
    size_t digits = strspn(spec->line, "0123456789");

    if (digits == 0 || digits > 8 || spec->line[digits] != '\0')
        return ttf_err_set(err, -EINVAL, spec->label, "'%s' is no number of a PWM channel",
                           spec->line);
    if (spec->chip[0] == '\0')
        return ttf_err_set(err, -EINVAL, spec->label, "no PWM chip is named");
    if (spec->period_ns < TTF_PWM_PERIOD_MIN_NS || spec->period_ns > TTF_PWM_PERIOD_MAX_NS)
        return ttf_err_set(err, -EINVAL, spec->label, "a PWM cycle is 1 us to 1 s");
    if (spec->input || spec->active_low)
        return ttf_err_set(err, -EINVAL, spec->label,
                           "a PWM channel is an output, lit while it is high");
    return 0;
}

int ttf_lines_pwm_create(const char *root, const struct ttf_line_spec *specs, unsigned n,
                         struct ttf_lines **ret, struct ttf_err *err)
{
    struct pwm_lines *p;
    int r = ttf_lines_check(specs, n, err);

    for (unsigned i = 0; i < n && r == 0; i++)
        r = check(&specs[i], err);
    if (r == 0 && strlen(root) >= sizeof(p->root))
        r = ttf_err_set(err, -ENAMETOOLONG, root, "is too long a path");
    if (r < 0)
        return r;
    p = calloc(1, sizeof(*p));
    if (!p)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    p->base.ops = &OPS;
    p->base.n = n;
    memcpy(p->base.spec, specs, n * sizeof(*specs));
    memcpy(p->root, root, strlen(root) + 1);
    for (unsigned i = 0; i < n; i++)
        p->channel[i].folder = -1;
    r = hold_all(p, err);
    if (r < 0) {
        free(p);
        return r;
    }
    *ret = &p->base;
    return 0;
}
