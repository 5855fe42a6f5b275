/* SPDX-License-Identifier: Apache-2.0 */
/* settle.c: whether a frame shows the settings wanted: request, read back, request the same again (README.md). */
#include "device.h"
#include "ttf/base/time.h"

/* A driver that told nothing steady for so many times settle_frames does not come to rest. */
#define NEVER_TIMES 8

/* What was asked when this was told; NULL: it never was. */
static const struct ttf_exposure *led_to(const struct lc_settle *s, const struct ttf_exposure *told)
{
    for (unsigned i = 0; i < s->n_pairs; i++)
        if (ttf_exposure_equal(&s->pair[i].told, told))
            return &s->pair[i].asked;
    return NULL;
}

static void remember(struct lc_settle *s, const struct ttf_exposure *told)
{
    if (led_to(s, told))
        return;
    s->pair[s->next_pair] = (struct lc_pair){.told = *told, .asked = s->asked};
    s->next_pair = (s->next_pair + 1) % LC_PAIRS;
    if (s->n_pairs < LC_PAIRS)
        s->n_pairs++;
}

static void begin(struct lc_camera *camera)
{
    struct lc_settle *s = &camera->settle;

    s->settling = true;
    s->frames = s->alike = 0;
    s->told_any = false;
    lc_stream_carry(camera, &s->asked);
}

void lc_settle_want(struct lc_camera *camera, const struct ttf_exposure *wanted)
{
    struct lc_settle *s = &camera->settle;
    struct ttf_exposure settable = lc_controls_settable(&camera->can, wanted);
    const struct ttf_exposure *before;

    if (s->set && ttf_exposure_equal(&settable, &s->wanted))
        return;
    before = led_to(s, &settable);
    if (before && s->set && !s->settling && ttf_exposure_equal(before, &s->asked)) {
        s->wanted = settable; /* what the frames show already */
        return;
    }
    s->set = true;
    s->wanted = settable;
    s->asked = before ? *before : settable;
    s->nudged = before != NULL;
    begin(camera);
}

void lc_settle_again(struct lc_camera *camera)
{
    camera->settle.nudged = true; /* what was found out holds */
    begin(camera);
}

/* Less by so little that the driver must have cut it down to its own steps. */
static bool cut(double told, double asked)
{
    return told < asked && told > asked * 0.99;
}

/* One digit more of what was cut, so that a value once told is told again. */
static bool nudge(struct lc_camera *camera)
{
    struct lc_settle *s = &camera->settle;
    struct ttf_exposure more = s->asked;
    int64_t asked_us = (s->asked.exposure_ns + TTF_NS_PER_US / 2) / TTF_NS_PER_US;

    if (s->nudged)
        return false;
    if (cut((double)s->told.exposure_ns, (double)(asked_us * TTF_NS_PER_US)))
        more.exposure_ns = (asked_us + 1) * TTF_NS_PER_US;
    if (cut(s->told.gain_milli, s->asked.gain_milli))
        more.gain_milli++;
    if (ttf_exposure_equal(&more, &s->asked))
        return false;
    s->asked = more;
    s->nudged = true;
    begin(camera);
    return true;
}

enum lc_shown lc_settle_shown(struct lc_camera *camera, const struct lc_arrival *arrival,
                              const struct ttf_exposure *told)
{
    struct lc_settle *s = &camera->settle;
    unsigned enough = camera->config.settle_frames;

    if (arrival->generation < camera->stream.generation)
        return LC_SHOWN_NO;
    if (!s->settling)
        return LC_SHOWN_YES;
    s->frames++;
    /* What stands still before it can have been obeyed is what was before. */
    if (s->frames > camera->config.delay_frames)
        s->alike = s->told_any && ttf_exposure_equal(told, &s->told) ? s->alike + 1 : 1;
    s->told = *told;
    s->told_any = true;
    if (!ttf_exposure_equal(told, &s->wanted)) {
        if (s->frames > NEVER_TIMES * (enough + camera->config.delay_frames))
            return LC_SHOWN_NEVER;
        if (s->alike < enough || nudge(camera))
            return LC_SHOWN_NO;
    }
    remember(s, told);
    s->settling = false;
    return LC_SHOWN_YES;
}
