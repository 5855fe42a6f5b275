/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rig_camera [libcamera|uvc] conformance FOURCC | case NAME | inject NAME | soak SLOTS | info FOURCC: in the rig's guest, on vivid, or
 * on what libcamera finds (vimc), which has no cases and looks for the best format, or on the webcam of rig_uvc, of
 * which `settings EXPOSURE_US:GAIN_MILLI,...` tells what was granted and what is seen of it.
 */
#include "rig_camera.h"

#include <errno.h>
#include <linux/videodev2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "conformance.h"
#include "ttf/base/time.h"
#include "ttf/hal/libcamera.h"

static int open_fd = -1;
static const char *format = "";
static bool by_libcamera; /* how all cameras of this process are reached */
static bool by_uvc;

static int remember(void *ctx, const char *path)
{
    int fd = v4l2_sys_kernel.open(ctx, path);

    if (open_fd < 0) /* others are looked at meanwhile, to know if there are more of its name */
        open_fd = fd;
    return fd;
}

static int list(void *ctx, unsigned i, char ret_path[64])
{
    return v4l2_sys_kernel.list(ctx, i, ret_path);
}

static void shut(void *ctx, int fd)
{
    v4l2_sys_kernel.close(ctx, fd);
    if (fd == open_fd)
        open_fd = -1;
}

static void serial(void *ctx, int fd, char ret[64])
{
    v4l2_sys_kernel.serial(ctx, fd, ret);
}

static int control(void *ctx, int fd, unsigned long request, void *arg)
{
    return v4l2_sys_kernel.ioctl(ctx, fd, request, arg);
}

static int map(void *ctx, int fd, size_t length, int64_t offset, void **ret)
{
    return v4l2_sys_kernel.map(ctx, fd, length, offset, ret);
}

static void unmap(void *ctx, void *at, size_t length)
{
    v4l2_sys_kernel.unmap(ctx, at, length);
}

static int wait_for(void *ctx, int fd, struct ttf_clock *clock, int64_t deadline_ns)
{
    return v4l2_sys_kernel.wait(ctx, fd, clock, deadline_ns);
}

const struct v4l2_sys rig_sys = {.list = list,
                                 .open = remember,
                                 .close = shut,
                                 .ioctl = control,
                                 .map = map,
                                 .unmap = unmap,
                                 .serial = serial,
                                 .wait = wait_for};

int rig_set(uint32_t id, int value)
{
    struct v4l2_control c = {.id = id, .value = value};

    return v4l2_sys_kernel.ioctl(NULL, open_fd, VIDIOC_S_CTRL, &c);
}

int rig_camera(const char *pixel_format, struct ttf_clock *clock, struct ttf_camera **ret,
               struct ttf_err *err)
{
    struct ttf_v4l2_config config = {
        .width = 320, .height = 180, .frame_period_ns = 40 * TTF_NS_PER_MS};

    if (by_libcamera) {
        const struct ttf_libcamera_config vimc = {.width = 640, .height = 480};

        return ttf_libcamera_camera_create(&vimc, clock, ret, err);
    }
    if (by_uvc) {
        rig_uvc_config(&config);
        pixel_format = "YUYV";
    }
    (void)snprintf(config.pixel_format, sizeof(config.pixel_format), "%s", pixel_format);
    return v4l2_camera_create_on(&rig_sys, NULL, &config, clock, ret, err);
}

static void destroy(struct ttf_box *box)
{
    ttf_camera_destroy(box->cameras[0].camera);
    ttf_clock_destroy(box->clock);
}

static int make(struct ttf_box *ret)
{
    struct ttf_err err = {0};
    char text[512];
    int r;

    *ret = (struct ttf_box){.clock = ttf_clock_real_create(), .n_cameras = 1, .destroy = destroy};
    if (!ret->clock)
        return -errno;
    r = rig_camera(format, ret->clock, &ret->cameras[0].camera, &err);
    if (r < 0) {
        (void)fprintf(stderr, "%s\n", ttf_err_text(&err, text, sizeof(text)));
        ttf_box_destroy(ret);
    }
    return r;
}

static void say_libcamera(const struct ttf_camera *camera, const struct ttf_frame_format *f)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(camera);
    struct ttf_libcamera_info i;

    ttf_libcamera_camera_info(camera, &i);
    printf("libcamera %s: '%s' (%s) %s %ux%u stride %zu has %#x mapped %#x period %lld us%s, "
           "exposure up to "
           "%lld ns\n",
           i.version, i.model, i.id, i.pixel_format, f->width, f->height, f->stride, i.has,
           i.mapped, (long long)(caps->frame_period_ns / 1000),
           caps->steerable ? ", steerable" : "", (long long)caps->exposure_max_ns);
}

/* What it is, as granted. */
static int info(void)
{
    struct ttf_camera_mode native = {0};
    struct ttf_frame_format f;
    struct ttf_v4l2_info i;
    struct ttf_err err = {0};
    struct ttf_box box;
    char text[512];
    int r = make(&box);

    if (r < 0)
        return 1;
    r = ttf_camera_configure(box.cameras[0].camera, &native, &f, &err);
    if (r < 0) {
        printf("refused: %s\n", ttf_err_text(&err, text, sizeof(text)));
    } else if (by_libcamera) {
        say_libcamera(box.cameras[0].camera, &f);
    } else {
        ttf_v4l2_camera_info(box.cameras[0].camera, &i);
        printf("%s '%s' %s %s %ux%u stride %zu bits %u has %#x mapped %#x automatics off %u "
               "exposure up to %lld ns\n",
               i.device, i.name, i.bus, i.pixel_format, f.width, f.height, f.stride, f.bits, i.has,
               i.mapped, i.automatics_off,
               (long long)ttf_camera_caps(box.cameras[0].camera)->exposure_max_ns);
    }
    ttf_box_destroy(&box);
    return r < 0;
}

int main(int argc, char **argv)
{
    const struct conformance_factory vivid = {"vivid", make};

    if (argc == 4 && strcmp(argv[1], "libcamera") == 0) {
        by_libcamera = true;
        argc--;
        argv++;
    }
    if (argc == 4 && strcmp(argv[1], "uvc") == 0) {
        by_uvc = true;
        argc--;
        argv++;
    }
    if (argc != 3)
        return 2;
    format = argv[2];
    if (strcmp(argv[1], "conformance") == 0)
        return conformance_camera(&vivid);
    if (strcmp(argv[1], "info") == 0)
        return info();
    if (strcmp(argv[1], "case") == 0)
        return rig_case(argv[2]);
    if (strcmp(argv[1], "inject") == 0)
        return rig_inject(argv[2]);
    if (strcmp(argv[1], "soak") == 0)
        return rig_soak((unsigned)strtoul(argv[2], NULL, 10));
    if (strcmp(argv[1], "settings") == 0)
        return rig_settings(argv[2]);
    return 2;
}
