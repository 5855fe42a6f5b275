/* SPDX-License-Identifier: Apache-2.0 */
#include "view.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/capture/guided_calibration.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/image_file.h"

/* Of lamps: light to see by, within some per cent of a run's, which waits the minutes of their warm_up. */
#define SETTLE_NS   (200 * TTF_NS_PER_MS)
#define OPEN_NS     (10 * TTF_NS_PER_S) /* that devices are kept for the next picture */
#define FIRST_NS    (20 * TTF_NS_PER_MS)
#define LONGEST_NS  (2 * TTF_NS_PER_S)  /* an exposure */
#define PATIENCE_NS (5 * TTF_NS_PER_S)  /* for a frame, whatever the camera does */
#define ALL_NS      (10 * TTF_NS_PER_S) /* no further try after this */
#define TRIES       3
#define WANTED      0.18 /* of full scale, on the average */
#define NEAR        2.0  /* times too much or too little that will do */
#define SIDE        1600
#define QUALITY     85

int view_open(struct daemon *d, struct ttf_err *err)
{
    int r;

    if (d->view.n_cameras > 0)
        return 0;
    r = box_create(&d->view_board, d->io, &d->host, &d->view, err);
    if (r == 0)
        r = box_configure(&d->view_board, &d->view, err);
    if (r < 0) {
        ttf_box_destroy(&d->view);
        return r;
    }
    shadow_take(d->shadow, &d->view);
    return 0;
}

void view_close(struct daemon *d, bool now)
{
    if (d->view.n_cameras > 0 && (now || ttf_clock_now_ns(d->clock) - d->viewed_ns > OPEN_NS))
        ttf_box_destroy(&d->view);
}

/* ---- a frame ---- */

static struct ttf_camera *find_camera(const struct ttf_box *box, const char *name)
{
    for (unsigned i = 0; i < box->n_cameras; i++)
        if (strcmp(box->cameras[i].name, name) == 0)
            return box->cameras[i].camera;
    return NULL;
}

static int shot_of(struct daemon *d, const struct ttf_http_view *view, struct ttf_plan_shot *ret,
                   struct ttf_err *err)
{
    struct ttf_plan *plan = malloc(sizeof *plan);

    if (!plan)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    ttf_plan_defaults(plan);
    *ret = plan->shots[0];
    free(plan);
    (void)snprintf(ret->camera, sizeof ret->camera, "%s",
                   *view->camera ? view->camera : d->view.cameras[0].name);
    if (!find_camera(&d->view, ret->camera))
        return ttf_err_set(err, -EINVAL, "camera", "the box has no camera '%s'", ret->camera);
    for (unsigned i = 0; i < view->n_lamps; i++) {
        if (!d->view.lamps || ttf_lamps_find(d->view.lamps, view->lamps[i].name) < 0)
            return ttf_err_set(err, -EINVAL, "lamps", "the box has no lamp '%s'",
                               view->lamps[i].name);
        memcpy(ret->levels[i].lamp, view->lamps[i].name, sizeof ret->levels[i].lamp);
        ret->levels[i].permille = view->lamps[i].level_permille;
    }
    ret->n_levels = view->n_lamps;
    if (view->gain_milli > 0)
        ret->exposure.gain_milli = (uint32_t)view->gain_milli;
    if (view->exposure_ns > LONGEST_NS)
        return ttf_err_set(err, -EINVAL, "exposure_ns", "2 s at the most are meant");
    ret->exposure.exposure_ns = view->exposure_ns > 0 ? view->exposure_ns : FIRST_NS;
    return 0;
}

/* The mean of a frame above black, of full scale. */
static double level_of(const struct ttf_raw_sum *raw)
{
    size_t n = (size_t)raw->format.width * raw->format.height * raw->samples;
    uint16_t black, white;
    double sum = 0;

    ttf_raw_sum_levels(&raw->format, &black, &white);
    for (size_t i = 0; i < n; i++)
        sum += raw->sum[i];
    return (sum / (double)n / raw->n - black) / (white - black);
}

static int64_t within(int64_t ns, const struct ttf_camera_caps *caps)
{
    int64_t most = caps->exposure_max_ns < LONGEST_NS ? caps->exposure_max_ns : LONGEST_NS;

    if (ns < caps->exposure_min_ns)
        return caps->exposure_min_ns;
    return ns > most ? most : ns;
}

/* As asked, or else with an exposure that comes near what suits. */
static int take(struct daemon *d, const struct ttf_http_view *view, struct ttf_raw_sum *ret,
                struct ttf_err *err)
{
    struct ttf_plan_shot shot = {0};
    struct ttf_guided_config config = {.box = &d->view,
                                       .shot = &shot,
                                       .settle_ns = SETTLE_NS,
                                       .frames = 1,
                                       .stop = &d->view_stop,
                                       .patience_ns = PATIENCE_NS};
    int64_t until_ns = ttf_clock_now_ns(d->clock) + ALL_NS;
    const struct ttf_camera_caps *caps;
    int r = shot_of(d, view, &shot, err);

    if (r < 0)
        return r;
    caps = ttf_camera_caps(find_camera(&d->view, shot.camera));
    for (int i = 0;; i++) {
        double level;
        int64_t before = shot.exposure.exposure_ns;

        r = ttf_guided_frames(&config, view->n_lamps > 0, ret, err);
        if (r == -ECANCELED)
            return ttf_err_set(err, -EBUSY, NULL, "a run has the devices");
        if (r < 0 || view->exposure_ns > 0 || caps->exposure_max_ns == 0 || i + 1 == TRIES ||
            ttf_clock_now_ns(d->clock) > until_ns)
            return r;
        level = level_of(ret);
        level = level < WANTED / 64 ? WANTED / 64 : level;
        shot.exposure.exposure_ns = within((int64_t)((double)before * WANTED / level), caps);
        if ((level < WANTED * NEAR && level > WANTED / NEAR) || shot.exposure.exposure_ns == before)
            return 0;
        ttf_raw_sum_free(ret);
    }
}

/* ---- as a JPEG ---- */

/* The part that was asked for, if it lies in the picture. */
static int cut(const struct ttf_pixbuf *codes, const struct ttf_http_view *view,
               struct ttf_pixbuf *ret, struct ttf_err *err)
{
    if (view->width == 0) {
        *ret = *codes;
        ret->owned = false;
        return 0;
    }
    return ttf_pixbuf_view(codes, view->x, view->y, view->width, view->height, ret) < 0
               ? ttf_err_set(err, -EINVAL, "region", "does not lie within %u x %u pixels",
                             codes->width, codes->height)
               : 0;
}

static int shrink(const struct ttf_pixbuf *part, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    uint32_t side = part->width > part->height ? part->width : part->height;
    uint32_t width = part->width, height = part->height;
    int r;

    if (side > SIDE) {
        width = (uint32_t)((uint64_t)width * SIDE / side);
        height = (uint32_t)((uint64_t)height * SIDE / side);
    }
    r = ttf_pixbuf_alloc(ret, width ? width : 1, height ? height : 1, 3, TTF_SAMPLE_U16);
    if (r == 0)
        r = ttf_pixbuf_resample(part, ret);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory for a picture") : 0;
}

static int encode(const struct ttf_pixbuf *small, struct workshop_job *job, struct ttf_err *err)
{
    const struct ttf_encoding encoding = {TTF_PEDESTAL, TTF_SCALE};
    struct ttf_pixbuf shown = {0};
    uint8_t *table = malloc(65536);
    int r =
        table ? ttf_pixbuf_alloc(&shown, small->width, small->height, 3, TTF_SAMPLE_U8) : -ENOMEM;

    if (r < 0) {
        free(table);
        return ttf_err_set(err, r, NULL, "no memory for a picture");
    }
    ttf_display8_table(&encoding, table);
    for (uint32_t y = 0; y < small->height; y++) {
        const uint16_t *from = ttf_pixbuf_row(small, y);
        uint8_t *to = ttf_pixbuf_row(&shown, y);

        for (size_t i = 0; i < (size_t)small->width * 3; i++)
            to[i] = table[from[i]];
    }
    r = ttf_jpeg_encode(&shown, QUALITY, &job->shown.jpeg, &job->shown.bytes, err);
    ttf_pixbuf_free(&shown);
    free(table);
    return r;
}

static int develop(const struct ttf_raw_sum *raw, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    const struct ttf_develop_config config = {.format = raw->format,
                                              .encoding = {TTF_PEDESTAL, TTF_SCALE}};
    struct ttf_develop *room = NULL;
    int r = ttf_develop_create(&config, &room, err);

    if (r == 0 && ttf_pixbuf_alloc(ret, ttf_develop_width(room), ttf_develop_height(room), 3,
                                   TTF_SAMPLE_U16) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for a picture");
    if (r == 0)
        r = ttf_develop_run(room, raw, NULL, ret, NULL, err);
    ttf_develop_destroy(room);
    return r;
}

static int picture(struct daemon *d, struct workshop_job *job, struct ttf_err *err)
{
    struct ttf_pixbuf codes = {0}, part = {0}, small = {0};
    struct ttf_raw_sum raw = {0};
    int r = take(d, job->view, &raw, err);

    if (r == 0)
        r = develop(&raw, &codes, err);
    job->shown.exposure_ns = raw.settings.exposure_ns;
    job->shown.gain_milli = raw.settings.gain_milli;
    ttf_raw_sum_free(&raw);
    if (r == 0)
        r = cut(&codes, job->view, &part, err);
    if (r == 0)
        r = shrink(&part, &small, err);
    if (r == 0)
        r = encode(&small, job, err);
    ttf_pixbuf_free(&small);
    ttf_pixbuf_free(&codes);
    return r;
}

int view_work(void *ctx, struct workshop_job *job, struct ttf_err *err)
{
    struct daemon *d = ctx;
    int r = view_open(d, err);

    if (r == 0 && job->view) {
        r = picture(d, job, err);
        /* A device that failed is made anew for the next one. */
        if (r < 0 && r != -EINVAL)
            view_close(d, true);
    }
    d->viewed_ns = ttf_clock_now_ns(d->clock);
    return r;
}
