/* SPDX-License-Identifier: Apache-2.0 */
/* find.c: which camera is meant, and which it is after it was lost. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "device.h"

static bool begins(const char *text, const char *wanted)
{
    return strncmp(text, wanted, strlen(wanted)) == 0;
}

static bool fits(const struct lc_camera *camera, const struct lc_identity *id, bool again)
{
    if (again)
        return strcmp(id->id, camera->id.id) == 0;
    return begins(id->id, camera->config.id) && begins(id->model, camera->config.name);
}

static const char *wanted(const struct lc_camera *camera, bool again)
{
    if (again)
        return camera->id.id;
    return camera->config.id[0] ? camera->config.id : camera->config.name;
}

static int not_found(struct lc_camera *camera, bool again, const char *seen, struct ttf_err *err)
{
    const struct lc_ops *ops = lc_ops(camera);
    const char *name = wanted(camera, again);
    char complaint[160];

    ops->complaint(camera->system.ctx, complaint, sizeof(complaint));
    if (seen[0]) {
        ttf_err_set(err, -ENODEV, NULL, "libcamera finds no camera '%s'", name);
        ttf_err_hint(err, "it finds %s", seen);
    } else {
        ttf_err_set(err, -ENODEV, NULL, "libcamera %s finds no camera%s%s",
                    ops->version(camera->system.ctx), complaint[0] ? ": " : "", complaint);
        ttf_err_hint(err, "a PROBLEM of `ttfbox board probe` says what is in the way");
    }
    return -ENODEV;
}

/* 1: held; 0: none fits. */
static int look(struct lc_camera *camera, bool again, char *seen, size_t size, struct ttf_err *err)
{
    const struct lc_ops *ops = lc_ops(camera);
    struct lc_identity id;
    size_t used = 0;

    for (unsigned i = 0; ops->list(camera->system.ctx, i, &id) > 0; i++) {
        int n, r;

        if (fits(camera, &id, again)) {
            r = ops->hold(camera->system.ctx, id.id, &camera->handle);
            if (r == 0) {
                camera->id = id;
                return 1;
            }
            camera->handle = NULL;
            if (r != -ENODEV) /* which went meanwhile */
                return ttf_err_set(err, r, id.id,
                                   r == -EBUSY ? "another program has the camera"
                                               : "the camera cannot be taken: %s",
                                   strerrordesc_np(-r));
        }
        n = snprintf(seen + used, size - used, "%s'%s' (%s)", used ? ", " : "", id.model, id.id);
        if (n > 0 && (size_t)n < size - used)
            used += (size_t)n;
        else
            seen[used] = '\0'; /* only whole ones */
    }
    return 0;
}

static int begin(struct lc_camera *camera, struct ttf_err *err)
{
    int r = camera->begun ? 0 : lc_ops(camera)->begin(camera->system.ctx);

    if (r < 0)
        return ttf_err_set(err, r, NULL, "libcamera does not start: %s", strerrordesc_np(-r));
    camera->begun = true;
    return 0;
}

void lc_let_go(struct lc_camera *camera)
{
    if (camera->handle) {
        lc_stream_stop(camera);
        lc_ops(camera)->let_go(camera->handle);
    }
    camera->handle = NULL;
    if (camera->begun)
        lc_ops(camera)->end(camera->system.ctx);
    camera->begun = false;
}

int lc_find(struct lc_camera *camera, bool again, struct ttf_err *err)
{
    char seen[220] = "";
    int r;

    /* Looked at anew: what libcamera saw when it began may be long gone. */
    lc_let_go(camera);
    r = begin(camera, err);
    if (r == 0)
        r = look(camera, again, seen, sizeof(seen), err);
    if (r == 0)
        r = not_found(camera, again, seen, err);
    if (r < 0)
        lc_let_go(camera);
    return r < 0 ? r : 0;
}
