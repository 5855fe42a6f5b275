/* SPDX-License-Identifier: Apache-2.0 */
#include "image_files.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image_flags.h"
#include "plan_figures.h"

/* More saturated samples than this are no longer a few highlights. */
#define SATURATED_SHARE 0.001

struct produce {
    struct ttf_darkroom *room;
    const struct ttf_print *print;
    struct ttf_tiff_times times;
    struct ttf_image_figures figures;
};

static int produce_developed(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    struct produce *p = ctx;

    return ttf_develop_tiff(p->room->develop, p->print->raw, p->room->pool, &p->times, io, file,
                            &p->figures, err);
}

static int produce_raw(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    struct produce *p = ctx;
    struct ttf_dng_info info = p->room->dng;

    info.times = p->times;
    return ttf_dng_write_in(p->print->raw, &info, p->room->strip, io, file, err);
}

static int reserve(struct ttf_darkroom *room, const struct ttf_frame_format *format,
                   struct ttf_err *err)
{
    if (room->keep != TTF_KEEP_DEVELOPED) {
        room->strip = malloc(ttf_dng_scratch_bytes(format));
        if (!room->strip)
            return ttf_err_set(err, -ENOMEM, NULL, "no memory for raw files");
    }
    return room->keep == TTF_KEEP_RAW ? 0
                                      : ttf_develop_reserve(room->develop, room->pool, true, err);
}

/* dc: as of the whole region. */
static int init_reference(struct ttf_darkroom *room, const struct ttf_develop_config *dc,
                          const struct ttf_region *patch, struct ttf_err *err)
{
    struct ttf_develop_config part = *dc;
    int r;

    part.region = (struct ttf_region){dc->region.x + patch->x, dc->region.y + patch->y,
                                      patch->width, patch->height};
    r = ttf_develop_create(&part, &room->reference, err);
    if (r == 0)
        r = ttf_develop_reserve(room->reference, room->pool, false, err);
    if (r == 0)
        r = ttf_pixbuf_alloc(&room->patch, patch->width, patch->height, 3, TTF_SAMPLE_U16);
    return r;
}

int ttf_darkroom_init(struct ttf_darkroom *room, const struct ttf_darkroom_config *config,
                      struct ttf_err *err)
{
    const struct ttf_region *patch = &config->plan->reference;
    struct ttf_develop_config dc = {
        .format = *config->format,
        .calibration = config->calibration,
        .region = ttf_plan_region(config->plan, config->format),
        .encoding = {.pedestal = TTF_PEDESTAL, .scale = TTF_SCALE},
    };
    int r;

    memset(room, 0, sizeof(*room));
    room->pool = config->pool;
    room->keep = ttf_plan_keep(config->plan, config->format);
    room->zone_offset_s = config->zone_offset_s;
    room->dng.simulated = config->simulated;
    snprintf(room->dng.model, sizeof(room->dng.model), "%s",
             ttf_camera_caps(config->camera)->model);
    snprintf(room->dng.serial, sizeof(room->dng.serial), "%s", config->serial);
    snprintf(room->dng.software, sizeof(room->dng.software), "%s", config->software);
    if (config->calibration)
        snprintf(room->calibration, sizeof(room->calibration), "%s", config->calibration->id);
    r = ttf_develop_create(&dc, &room->develop, err);
    if (r == 0)
        r = reserve(room, config->format, err);
    if (r == 0 && patch->width != 0)
        r = init_reference(room, &dc, patch, err);
    if (r < 0)
        ttf_darkroom_finish(room);
    return r;
}

void ttf_darkroom_finish(struct ttf_darkroom *room)
{
    ttf_develop_destroy(room->develop);
    ttf_develop_destroy(room->reference);
    ttf_pixbuf_free(&room->patch);
    free(room->strip);
    memset(room, 0, sizeof(*room));
}

int ttf_darkroom_print(struct ttf_darkroom *room, struct ttf_writer *writer, const char *role,
                       const struct ttf_print *print, struct ttf_err *err)
{
    struct ttf_image *image = print->image;
    bool raw = strcmp(role, "raw") == 0;
    struct produce p = {
        .room = room,
        .print = print,
        .times = {.start_utc_ns = print->start_utc_ns,
                  .zone_offset_s = room->zone_offset_s,
                  .exposure_ns = print->raw->settings.exposure_ns},
    };
    int r;

    if (image->n_files >= TTF_IMAGE_FILES_MAX)
        return -ENOSPC;
    r = ttf_writer_file(writer, role, image->stream, print->index, image->bracket,
                        raw ? "dng" : "tif", raw ? produce_raw : produce_developed, &p,
                        &image->files[image->n_files], err);
    if (r < 0)
        return r;
    image->n_files++;
    if (!raw) {
        image->mean_level = p.figures.mean_level;
        image->sharpness = p.figures.sharpness;
        if (p.figures.saturated > SATURATED_SHARE)
            ttf_image_flag(image, "saturated");
    }
    return 0;
}

void ttf_darkroom_reference(struct ttf_darkroom *room, const struct ttf_print *print)
{
    struct ttf_image_figures figures;

    if (room->reference &&
        ttf_develop_run(room->reference, print->raw, room->pool, &room->patch, &figures, NULL) == 0)
        print->image->reference_level = figures.mean_level;
}
