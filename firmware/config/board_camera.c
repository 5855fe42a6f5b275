/* SPDX-License-Identifier: Apache-2.0 */
/* board_camera.c: `cameras:` of a board; which keys one has is its back-end's. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"

/* As it is read: numbers wider than their place, checked by their range. */
struct camera {
    struct ttf_camera_mode mode;
    struct ttf_v4l2_config v4l2;
    struct ttf_libcamera_config libcamera;
    uint32_t buffers, settle, delay, black, white;
    int flicker, stream, stamp;
};

#define C(member) offsetof(struct camera, member)

/* The kernel's four letters of a pixel format; ends of blanks ("GREY", "Y10 ") may be left out. */
static int read_fourcc(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);
    size_t n = text ? strlen(text) : 0;

    if (!text)
        return -EINVAL;
    if (n < 3 || n > 4)
        return cfg_error(node, err, field->meant, "'%.20s' is no pixel format", text);
    memcpy(at, "    ", 5);
    memcpy(at, text, n);
    return 0;
}

/* controls: {sharpness: 0}: names that only the driver knows. */
static int read_controls(const struct cfg_field *field, struct yaml_node *node, void *at,
                         struct ttf_err *err)
{
    struct ttf_v4l2_config *config = &((struct camera *)at)->v4l2;
    const struct cfg_field value = {.meant = field->meant, .lo = INT32_MIN, .hi = INT32_MAX};

    if (node->kind != YAML_MAP || node->n > TTF_V4L2_CONTROLS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d controls is meant",
                         TTF_V4L2_CONTROLS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next) {
        struct ttf_v4l2_control *control = &config->controls[config->n_controls];
        int64_t number = 0;
        int r;

        c->used = true;
        if (!*c->key || strlen(c->key) >= sizeof control->name)
            return cfg_error_at_key(c, err, field->meant, "1 to 31 letters are a control's name");
        r = cfg_i64(&value, c, &number, err);
        if (r < 0)
            return r;
        memcpy(control->name, c->key, strlen(c->key) + 1);
        control->value = (int32_t)number;
        config->n_controls++;
    }
    return 0;
}

static const struct cfg_name FLICKER[] = {{"none", TTF_V4L2_FLICKER_OFF},
                                          {"50Hz", TTF_V4L2_FLICKER_50HZ},
                                          {"60Hz", TTF_V4L2_FLICKER_60HZ},
                                          {NULL, 0}};

#define MODE_FIELDS                                                                           \
    {"backend", NULL, 0, 0, 0, NULL, 0, 0},                                                   \
        {"width", cfg_u32_px, C(mode.width), 16, 65535, "width of the mode asked for", 0, 0}, \
    {                                                                                         \
        "height", cfg_u32_px, C(mode.height), 16, 65535, "height of the mode asked for", 0, 0 \
    }

static const struct cfg_field SIM[] = {MODE_FIELDS, {0}};

static const struct cfg_field V4L2[] = {
    MODE_FIELDS,
    {"device", cfg_text64, C(v4l2.device), 0, 0, "as /dev/video0 or a link below /dev/v4l/by-id", 0,
     0},
    {"bus", cfg_text64, C(v4l2.bus), 0, 0, "where it is plugged in, as usb-0000:01:00.0-1.2", 0, 0},
    {"name", cfg_text64, C(v4l2.name), 0, 0, "what its driver calls it, as 'HD Pro Webcam C920'", 0,
     0},
    {"format", read_fourcc, C(v4l2.pixel_format), 0, 0, "the kernel's four letters, as RG10, YUYV",
     0, 0},
    {"frame_period", cfg_i64_time, C(v4l2.frame_period_ns), 1e5, 6e10, "of its stream, as 40ms", 0,
     0},
    {"buffers", cfg_u32, C(buffers), 2, 8, "frames held at once", 0, 0},
    {"settle_frames", cfg_u32, C(settle), 1, 30, "frames until a changed setting shows", 0, 0},
    {"steer", cfg_bool, C(v4l2.steer), 0, 0, "true: its frames may be moved to meet a slot", 0, 0},
    {"readout", cfg_i64_time, C(v4l2.readout_ns), 0, 6e10, "from its first row to its last", 0, 0},
    {"black_level", cfg_u32, C(black), 0, 65534, "the code of no light", 0, 0},
    {"white_level", cfg_u32, C(white), 1, 65535, "the code of saturation", 0, 0},
    {"gain_unity", cfg_u32, C(v4l2.gain_unity), 1, 1e9, "the code of gain 1", 0, 0},
    {"balance_unity", cfg_u32, C(v4l2.balance_unity), 1, 1e9, "the code of balance 1", 0, 0},
    {"focus_per_dioptre", cfg_u32, C(v4l2.focus_per_dioptre), 1, 1e6, "codes to a dioptre", 0, 0},
    {"white_balance_kelvin", cfg_u32, C(v4l2.white_balance_kelvin), 1000, 20000,
     "its own white balance, as 5000", 0, 0},
    {"flicker", cfg_enum, C(flicker), 0, 0, "its own anti-flicker: none, 50Hz, 60Hz", FLICKER, 0},
    {"controls", read_controls, 0, 0, 0, "a map of the driver's names and values", 0, 0},
    {0}};

/* DRM's letters of a pixel format, as `cam -I` prints its fourcc, and a P for packed: RG12, RG10P, NV12. */
static int read_drm_format(const struct cfg_field *field, struct yaml_node *node, void *at,
                           struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);
    size_t n = text ? strlen(text) : 0;

    if (!text)
        return -EINVAL;
    if (n < 2 || n > 5)
        return cfg_error(node, err, field->meant, "'%.20s' is no pixel format", text);
    memcpy(at, text, n + 1);
    return 0;
}

static const struct cfg_name STREAM[] = {{"any", TTF_LIBCAMERA_ANY},
                                         {"raw", TTF_LIBCAMERA_RAW},
                                         {"processed", TTF_LIBCAMERA_PROCESSED},
                                         {NULL, 0}};

static const struct cfg_name STAMP[] = {{"exposure", TTF_LIBCAMERA_STAMP_EXPOSURE},
                                        {"readout", TTF_LIBCAMERA_STAMP_READOUT},
                                        {NULL, 0}};

static const struct cfg_field LIBCAMERA[] = {
    MODE_FIELDS,
    {"module", cfg_text128, C(libcamera.module), 0, 0, "the file of ttfbox's module for libcamera",
     0, 0},
    {"id", cfg_text128, C(libcamera.id), 0, 0, "libcamera's name for it, as `cam -l` prints it", 0,
     0},
    {"name", cfg_text64, C(libcamera.name), 0, 0, "its sensor's model, as imx477", 0, 0},
    {"stream", cfg_enum, C(stream), 0, 0, "any, raw or processed", STREAM, 0},
    {"format", read_drm_format, C(libcamera.pixel_format), 0, 0, "as RG12, RG12P, BG24, NV12", 0,
     0},
    {"frame_period", cfg_i64_time, C(libcamera.frame_period_ns), 1e5, 6e10,
     "of its stream, as 100ms", 0, 0},
    {"buffers", cfg_u32, C(buffers), 2, 8, "frames held at once", 0, 0},
    {"settle_frames", cfg_u32, C(settle), 1, 30, "frames that a setting has to stand still", 0, 0},
    {"delay_frames", cfg_u32, C(delay), 1, 8, "frames until a request is obeyed", 0, 0},
    {"readout", cfg_i64_time, C(libcamera.readout_ns), 0, 6e10, "from its first row to its last", 0,
     0},
    {"stamp", cfg_enum, C(stamp), 0, 0, "what its time is of: exposure or readout", STAMP, 0},
    {"black_level", cfg_u32, C(black), 0, 65534, "the code of no light", 0, 0},
    {"white_level", cfg_u32, C(white), 1, 65535, "the code of saturation", 0, 0},
    {0}};

static void take_v4l2(const struct camera *read, struct ttf_v4l2_config *ret)
{
    *ret = read->v4l2;
    ret->width = read->mode.width; /* what a run that asks for the native mode gets */
    ret->height = read->mode.height;
    ret->buffers = read->buffers;
    ret->settle_frames = read->settle;
    ret->black_level = (uint16_t)read->black;
    ret->white_level = (uint16_t)read->white;
    ret->flicker = (enum ttf_v4l2_flicker)read->flicker;
}

static void take_libcamera(const struct camera *read, struct ttf_libcamera_config *ret)
{
    *ret = read->libcamera;
    ret->width = read->mode.width;
    ret->height = read->mode.height;
    ret->buffers = read->buffers;
    ret->settle_frames = read->settle;
    ret->delay_frames = read->delay;
    ret->black_level = (uint16_t)read->black;
    ret->white_level = (uint16_t)read->white;
    ret->stream = (enum ttf_libcamera_stream)read->stream;
    ret->stamp = (enum ttf_libcamera_stamp)read->stamp;
}

static const struct cfg_field *fields_of(const char *backend)
{
    if (strcmp(backend, "v4l2") == 0)
        return V4L2;
    return strcmp(backend, "libcamera") == 0 ? LIBCAMERA : SIM;
}

static int read_camera(struct yaml_node *node, struct ttf_board_camera *ret, struct ttf_err *err)
{
    struct camera read = {0};
    int r = cfg_map(fields_of(ret->backend->name), node, &read, err);

    if (r < 0)
        return r;
    ret->mode = read.mode;
    take_v4l2(&read, &ret->v4l2);
    take_libcamera(&read, &ret->libcamera);
    if (read.white && read.white <= read.black)
        return cfg_error(yaml_child(node, "white_level"), err, "saturation is above no light",
                         "is not above 'black_level'");
    return 0;
}

int board_read_cameras(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    struct ttf_board *board = at;
    unsigned n = 0;

    if (node->kind != YAML_MAP || node->n == 0)
        return cfg_error(node, err, field->meant, "a map of cameras is meant");
    if (node->n > TTF_BOX_CAMERAS_MAX)
        return cfg_error(node, err, field->meant, "more than %d cameras", TTF_BOX_CAMERAS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        struct ttf_board_camera *camera = &board->cameras[n];
        int r;

        c->used = true;
        if (strlen(c->key) >= sizeof camera->name || !*c->key)
            return cfg_error_at_key(c, err, "1 to 31 letters", "no name of a camera");
        memcpy(camera->name, c->key, strlen(c->key) + 1);
        if (c->kind != YAML_MAP)
            return cfg_error(c, err, "write {backend: sim}", "a camera's description is meant");
        r = board_backend(c, TTF_DEVICE_CAMERA, &camera->backend, err);
        if (r == 0)
            r = read_camera(c, camera, err);
        if (r < 0)
            return r;
    }
    board->n_cameras = n;
    board->device[TTF_DEVICE_CAMERA] = board->cameras[0].backend;
    return 0;
}
