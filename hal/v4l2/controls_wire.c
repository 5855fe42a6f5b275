/* SPDX-License-Identifier: Apache-2.0 */
#include "controls_wire.h"

#include <ctype.h>
#include <errno.h>
#include <string.h>

int v4l2_control_query(const struct v4l2_controls *c, uint32_t id, struct v4l2_query_ext_ctrl *ret)
{
    int r;

    memset(ret, 0, sizeof(*ret));
    ret->id = id;
    r = c->sys->ioctl(c->ctx, c->fd, VIDIOC_QUERY_EXT_CTRL, ret);
    if (r == 0 && ((ret->flags & V4L2_CTRL_FLAG_DISABLED) || ret->elems > 1))
        r = -EINVAL;
    return r;
}

/* Extended controls carry 64 bits only where the control's type says so. */
static bool is_wide(const struct v4l2_controls *c, uint32_t id)
{
    struct v4l2_query_ext_ctrl q;

    return v4l2_control_query(c, id, &q) == 0 && q.type == V4L2_CTRL_TYPE_INTEGER64;
}

static int transfer(const struct v4l2_controls *c, unsigned long request,
                    struct v4l2_ext_control *control)
{
    struct v4l2_ext_controls all = {
        .which = V4L2_CTRL_WHICH_CUR_VAL, .count = 1, .controls = control};

    return c->sys->ioctl(c->ctx, c->fd, request, &all);
}

int v4l2_control_set(const struct v4l2_controls *c, uint32_t id, int64_t value)
{
    struct v4l2_ext_control control = {.id = id};

    if (is_wide(c, id))
        control.value64 = value;
    else
        control.value = (int32_t)value;
    return transfer(c, VIDIOC_S_EXT_CTRLS, &control);
}

int v4l2_control_get(const struct v4l2_controls *c, uint32_t id, int64_t *ret)
{
    struct v4l2_ext_control control = {.id = id};
    int r = transfer(c, VIDIOC_G_EXT_CTRLS, &control);

    if (r == 0)
        *ret = is_wide(c, id) ? control.value64 : control.value;
    return r;
}

const char *v4l2_control_reason(int r)
{
    /* uvcvideo's words for what a camera says; which of the first two depends on its age. */
    if (r == -EILSEQ || r == -EACCES)
        return "not in the state that the camera is in, or never";
    if (r == -EREMOTE)
        return "the camera's power does not allow it";
    return strerrordesc_np(-r);
}

int v4l2_control_fix(const struct v4l2_controls *c, const char *name, uint32_t id, int64_t value,
                     struct ttf_err *err)
{
    int64_t got = value;
    int r = v4l2_control_set(c, id, value);

    if (r == 0)
        r = v4l2_control_get(c, id, &got);
    if (r < 0)
        return ttf_err_set(err, r, name, "the camera does not take %lld here: %s", (long long)value,
                           v4l2_control_reason(r));
    if (got != value)
        return ttf_err_set(err, -EINVAL, name, "the camera takes %lld here, not %lld",
                           (long long)got, (long long)value);
    return 0;
}

/* "Sharpness" is "sharpness", "Exposure Time, Absolute" "exposure_time_absolute": as v4l2-ctl has it. */
static bool same_name(const char *driver, const char *wanted)
{
    for (;;) {
        bool gap = false;

        while (*driver && !isalnum((unsigned char)*driver)) {
            gap = true;
            driver++;
        }
        if (gap && *driver && *wanted++ != '_')
            return false;
        if (!*driver || !*wanted)
            return *driver == *wanted;
        if (tolower((unsigned char)*driver++) != *wanted++)
            return false;
    }
}

int v4l2_control_fix_named(const struct v4l2_controls *c, const struct ttf_v4l2_control *control,
                           struct ttf_err *err)
{
    struct v4l2_query_ext_ctrl q = {.id = V4L2_CTRL_FLAG_NEXT_CTRL};

    while (c->sys->ioctl(c->ctx, c->fd, VIDIOC_QUERY_EXT_CTRL, &q) == 0) {
        if (q.type != V4L2_CTRL_TYPE_CTRL_CLASS && same_name(q.name, control->name))
            return v4l2_control_fix(c, control->name, q.id, control->value, err);
        q.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    }
    ttf_err_set(err, -EINVAL, control->name, "the camera has no such control");
    ttf_err_hint(err, "`v4l2-ctl -l` lists those it has");
    return -EINVAL;
}
