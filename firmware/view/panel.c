/* SPDX-License-Identifier: Apache-2.0 */
/* panel.c: frames as pictures; see panel.h. */
#include "panel.h"

#include <errno.h>
#include <stdlib.h>

#include "ttf/dataset/colour.h"

#define FRAMES_DEFAULT 240
#define LOOKS          16    /* frames that brightness is taken from */
#define BRIGHTER       10000 /* one pixel of so many may be brighter than white */
#define WHITE_LEAST    0.02  /* in the dark, noise is not stretched over the display */

static int choose_frames(struct view_panel *panel, uint32_t most, struct ttf_err *err)
{
    uint32_t of = panel->texture->sequence->n, n = of < most ? of : most;

    panel->frame = calloc(n, sizeof(*panel->frame));
    if (!panel->frame)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a list of frames");
    for (uint32_t i = 0; i < n && n > 1; i++)
        panel->frame[i] = (uint32_t)(((uint64_t)i * (of - 1) + (n - 1) / 2) / (n - 1));
    panel->n = n;
    return 0;
}

/* How often each code comes in frame t. */
static int count_codes(struct ttf_sequence *s, uint32_t t, uint16_t *row, uint64_t *count,
                       struct ttf_err *err)
{
    int code = 0;

    for (uint32_t y = 0; y < s->height && !code; y++) {
        code = ttf_sequence_read_rows(s, t, y, 1, row, err);
        for (size_t x = 0; !code && x < (size_t)s->width * 3; x++)
            count[row[x]]++;
    }
    return code;
}

/* The code that one sample of BRIGHTER exceeds, over some frames. */
static int brightest(struct view_panel *panel, unsigned *ret, struct ttf_err *err)
{
    struct ttf_sequence *s = panel->texture->sequence;
    uint32_t looks = panel->n < LOOKS ? panel->n : LOOKS;
    uint64_t *count = calloc(65536, sizeof(*count)), above = 0;
    uint64_t total = (uint64_t)looks * s->width * s->height * 3;
    uint16_t *row = malloc((size_t)s->width * 3 * sizeof(*row));
    unsigned top = 65535;
    int code = 0;

    if (!count || !row) {
        code = ttf_err_set(err, -ENOMEM, NULL, "no memory to look at frames");
        goto out;
    }
    for (uint32_t i = 0; i < looks && !code; i++)
        code =
            count_codes(s, panel->frame[looks > 1 ? (uint64_t)i * (panel->n - 1) / (looks - 1) : 0],
                        row, count, err);
    while (top > 0 && (above += count[top]) * BRIGHTER <= total)
        top--;
    *ret = top;
out:
    free(row);
    free(count);
    return code;
}

/* A stream that holds a measurement and no reflectance is shown from its least to its greatest value, as export does. */
static int choose_brightness(struct view_panel *panel, double white, struct ttf_err *err)
{
    const struct ttf_encoding *e = &panel->texture->sequence->encoding;
    double lowest = (0.0 - e->pedestal) / e->scale, highest = (65535.0 - e->pedestal) / e->scale;
    unsigned top = 65535;
    int code;

    panel->white = white;
    if (white > 0)
        return 0;
    if (highest <= 0.25 || highest > 4.0) {
        panel->black = lowest;
        panel->white = highest;
        return 0;
    }
    code = brightest(panel, &top, err);
    if (code)
        return code;
    panel->white = ((double)top - e->pedestal) / e->scale;
    if (!(panel->white > WHITE_LEAST))
        panel->white = WHITE_LEAST;
    return 0;
}

static int make_table(struct view_panel *panel, struct ttf_err *err)
{
    const struct ttf_encoding *e = &panel->texture->sequence->encoding;

    panel->display = malloc(65536);
    if (!panel->display)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a table of colours");
    for (unsigned code = 0; code < 65536; code++) {
        double value = ((double)code - e->pedestal) / e->scale;
        double light = (value - panel->black) / (panel->white - panel->black);

        light = !(light > 0.0) ? 0.0 : light > 1.0 ? 1.0 : light;
        panel->display[code] = (uint8_t)(ttf_srgb_encode((float)light) * 255.0f + 0.5f);
    }
    return 0;
}

int view_panel_init(struct view_panel *panel, const struct ttf_view_texture *texture,
                    const struct ttf_view_config *config, struct ttf_pool *pool,
                    struct ttf_err *err)
{
    int code;

    *panel = (struct view_panel){.texture = texture, .pool = pool};
    panel->n_slots = pool ? ttf_pool_threads(pool) : 1;
    panel->slot = calloc(panel->n_slots, sizeof(*panel->slot));
    if (!panel->slot)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for frames");
    code = choose_frames(panel, config->frames_max ? config->frames_max : FRAMES_DEFAULT, err);
    if (!code)
        code = choose_brightness(panel, config->white, err);
    return code ? code : make_table(panel, err);
}

static int reserve(struct ttf_pixbuf *buf, uint32_t width, uint32_t height, enum ttf_sample format)
{
    if (buf->width == width && buf->height == height)
        return 0;
    ttf_pixbuf_free(buf);
    return ttf_pixbuf_alloc(buf, width, height, 3, format);
}

static int make_picture(const struct view_panel *panel, struct view_slot *slot, uint32_t t)
{
    struct ttf_sequence *s = panel->texture->sequence;
    const uint16_t *from;
    uint8_t *to;
    int code = reserve(&slot->codes, s->width, s->height, TTF_SAMPLE_U16);

    if (!code)
        code = reserve(&slot->sized, panel->width, panel->height, TTF_SAMPLE_U16);
    if (!code)
        code = reserve(&slot->shown, panel->width, panel->height, TTF_SAMPLE_U8);
    if (code)
        return ttf_err_set(&slot->err, code, NULL, "no memory for a frame of %u x %u", s->width,
                           s->height);
    code = ttf_sequence_read_rows(s, t, 0, s->height, slot->codes.data, &slot->err);
    /* Codes are proportional to light; the pedestal goes later: clipped noise would not average out. */
    if (!code)
        code = ttf_pixbuf_resample(&slot->codes, &slot->sized);
    if (code)
        return code;
    from = slot->sized.data;
    to = slot->shown.data;
    for (size_t i = 0; i < (size_t)panel->width * panel->height * 3; i++)
        to[i] = panel->display[from[i]];
    return view_picture_encode(&slot->picture, &slot->shown, panel->exact, &slot->err);
}

struct batch {
    struct view_panel *panel;
    const uint32_t *frames;
};

static void batch_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct batch *batch = ctx;
    struct view_slot *slot = &batch->panel->slot[tile];

    (void)worker;
    slot->code = make_picture(batch->panel, slot, batch->frames[tile]);
}

int view_panel_pictures(struct view_panel *panel, const uint32_t *frames, unsigned n,
                        struct ttf_err *err)
{
    struct batch batch = {panel, frames};

    ttf_pool_run(panel->pool, n, batch_tile, &batch);
    for (unsigned i = 0; i < n; i++) {
        if (panel->slot[i].code) {
            if (err)
                *err = panel->slot[i].err;
            return panel->slot[i].code;
        }
    }
    return 0;
}

void view_panel_free(struct view_panel *panel)
{
    for (unsigned i = 0; panel->slot && i < panel->n_slots; i++) {
        ttf_pixbuf_free(&panel->slot[i].codes);
        ttf_pixbuf_free(&panel->slot[i].sized);
        ttf_pixbuf_free(&panel->slot[i].shown);
        view_picture_free(&panel->slot[i].picture);
    }
    free(panel->slot);
    free(panel->frame);
    free(panel->display);
    *panel = (struct view_panel){0};
}
