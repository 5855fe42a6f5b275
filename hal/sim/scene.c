/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene_kind.h"
#include "ttf/hal/sim.h"

/* The first is the default of those who let the user choose. */
static const struct scene_kind *const kinds[] = {&scene_grass,  &scene_copper, &scene_paint,
                                                 &scene_banana, &scene_snow,   &scene_chart,
                                                 &scene_dots,   &scene_white};

/* Sizes kept: the camera's and that of whoever asks for the truth. */
#define KEPT 2

struct procedural {
    const struct scene_kind *kind;
    void *features;
    int64_t span_ns;
    struct scene_canvas kept[KEPT]; /* the most recently used first; w == 0: empty */
};

const char *ttf_scene_name(unsigned i)
{
    return i < TTF_COUNT_OF(kinds) ? kinds[i]->name : NULL;
}

static void canvas_finish(struct scene_canvas *c)
{
    for (unsigned i = 0; i < SCENE_PLANES_MAX; i++)
        free(c->plane[i]);
    memset(c, 0, sizeof(*c));
}

static int canvas_init(const struct procedural *p, uint32_t w, uint32_t h, struct scene_canvas *c)
{
    memset(c, 0, sizeof(*c));
    for (unsigned i = 0; i < p->kind->planes + p->kind->scratch; i++) {
        c->plane[i] = malloc((size_t)w * h * sizeof(float));
        if (!c->plane[i]) {
            canvas_finish(c);
            return -ENOMEM;
        }
    }
    c->w = w;
    c->h = h;
    c->sx = (float)w;
    c->sy = (float)h / SCENE_ASPECT;
    if (p->kind->prepare)
        p->kind->prepare(p->features, c);
    return 0;
}

/* Brings the canvas of this size to the front. */
static int canvas_get(struct procedural *p, uint32_t w, uint32_t h)
{
    struct scene_canvas got;
    unsigned i = 0;
    int r;

    while (i < KEPT && (p->kept[i].w != w || p->kept[i].h != h))
        i++;
    if (i < KEPT) {
        got = p->kept[i];
    } else {
        r = canvas_init(p, w, h, &got);
        if (r < 0)
            return r;
        i = KEPT - 1;
        canvas_finish(&p->kept[i]);
    }
    memmove(&p->kept[1], &p->kept[0], i * sizeof(p->kept[0]));
    p->kept[0] = got;
    return 0;
}

static int procedural_prepare(void *scene, uint32_t w, uint32_t h, struct ttf_err *err)
{
    struct procedural *p = scene;
    int r;

    if (w == 0 || h == 0)
        return ttf_err_set(err, -EINVAL, p->kind->name, "a picture without pixels was asked for");
    r = canvas_get(p, w, h);
    return r < 0 ? ttf_err_set(err, r, p->kind->name, "no memory for a scene of %u x %u", w, h) : 0;
}

static int procedural_render(void *scene, int64_t t_ns, uint32_t w, uint32_t h, float *rgb,
                             struct ttf_err *err)
{
    struct procedural *p = scene;
    double phase = (double)t_ns / (double)p->span_ns;
    int r = procedural_prepare(scene, w, h, err);

    if (r < 0)
        return r;
    phase = phase < 0.0 ? 0.0 : phase > 1.0 ? 1.0 : phase;
    p->kind->render(p->features, &p->kept[0], (float)phase, rgb);
    /* No diffuser gives back more than it gets, whatever a highlight came to. */
    for (size_t i = 0; i < (size_t)w * h * 3; i++)
        rgb[i] = rgb[i] < 0.0f ? 0.0f : rgb[i] > 1.0f ? 1.0f : rgb[i];
    return 0;
}

static void procedural_destroy(void *scene)
{
    struct procedural *p = scene;

    if (!p)
        return;
    for (unsigned i = 0; i < KEPT; i++)
        canvas_finish(&p->kept[i]);
    p->kind->destroy(p->features);
    free(p);
}

static const struct ttf_scene_ops procedural_ops = {
    .name = "procedural",
    .render = procedural_render,
    .destroy = procedural_destroy,
    .prepare = procedural_prepare,
};

static const struct scene_kind *find_kind(const char *name)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(kinds); i++) {
        if (strcmp(kinds[i]->name, name) == 0)
            return kinds[i];
    }
    return NULL;
}

static int unknown_name(const char *name, struct ttf_err *err)
{
    char names[128] = "";
    size_t n = 0;

    for (unsigned i = 0; i < TTF_COUNT_OF(kinds) && n < sizeof(names); i++)
        n += (size_t)snprintf(names + n, sizeof(names) - n, "%s%s", i ? ", " : "", kinds[i]->name);
    ttf_err_set(err, -ENOENT, NULL, "there is no scene '%s'", name);
    ttf_err_hint(err, "the scenes are %s", names);
    return -ENOENT;
}

int ttf_scene_procedural(const char *name, uint64_t seed, int64_t span_ns, struct ttf_scene *ret,
                         struct ttf_err *err)
{
    const struct scene_kind *kind = find_kind(name);
    struct procedural *p;

    if (!kind)
        return unknown_name(name, err);
    if (span_ns <= 0)
        return ttf_err_set(err, -EINVAL, name, "a scene's span must be longer than nothing");
    p = calloc(1, sizeof(*p));
    if (!p)
        return ttf_err_set(err, -ENOMEM, name, "no memory for the scene");
    p->kind = kind;
    p->span_ns = span_ns;
    p->features = kind->create(seed);
    if (!p->features) {
        free(p);
        return ttf_err_set(err, -ENOMEM, name, "no memory for the scene");
    }
    ret->ops = &procedural_ops;
    ret->priv = p;
    return 0;
}
