/* SPDX-License-Identifier: Apache-2.0 */
#include "shadow.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/hal/camera_backend.h"
#include "ttf/hal/lamps_backend.h"

struct shadow {
    pthread_mutex_t lock; /* over all below */
    struct ttf_box box;   /* n_cameras 0: none yet */
    struct ttf_camera cameras[TTF_BOX_CAMERAS_MAX];
    struct ttf_lamps lamps;
};

struct shadow *shadow_create(void)
{
    struct shadow *shadow = calloc(1, sizeof *shadow);

    if (shadow)
        (void)pthread_mutex_init(&shadow->lock, NULL);
    return shadow;
}

void shadow_destroy(struct shadow *shadow)
{
    if (!shadow)
        return;
    (void)pthread_mutex_destroy(&shadow->lock);
    free(shadow);
}

void shadow_take(struct shadow *s, const struct ttf_box *box)
{
    (void)pthread_mutex_lock(&s->lock);
    memset(&s->box, 0, sizeof s->box);
    memcpy(s->box.board, box->board, sizeof s->box.board);
    memcpy(s->box.serial, box->serial, sizeof s->box.serial);
    s->box.simulated = box->simulated;
    for (unsigned i = 0; i < box->n_cameras; i++) {
        /* Facts alone: without a table nothing can be done with it. */
        s->cameras[i] = *box->cameras[i].camera;
        s->cameras[i].ops = NULL;
        s->box.cameras[i] = box->cameras[i];
        s->box.cameras[i].camera = &s->cameras[i];
    }
    s->box.n_cameras = box->n_cameras;
    if (box->lamps) {
        s->lamps = *box->lamps;
        s->lamps.ops = NULL;
        s->box.lamps = &s->lamps;
    }
    (void)pthread_mutex_unlock(&s->lock);
}

int shadow_with(struct shadow *s, shadow_fn *fn, void *ctx, struct ttf_err *err)
{
    int r;

    (void)pthread_mutex_lock(&s->lock);
    r = s->box.n_cameras == 0
            ? ttf_err_set(err, -EAGAIN, NULL, "the box's devices have not answered yet")
            : fn(ctx, &s->box, err);
    (void)pthread_mutex_unlock(&s->lock);
    return r;
}
