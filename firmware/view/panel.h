/* SPDX-License-Identifier: Apache-2.0 */
/* panel.h: one texture of the file: which of its frames, how large, how bright; and each as a picture. */
#ifndef VIEW_PANEL_H
#define VIEW_PANEL_H

#include "picture.h"
#include "ttf/dataset/pool.h"
#include "ttf/view/view.h"

/* Memory of one thread's frame. */
struct view_slot {
    struct ttf_pixbuf codes, sized, shown; /* as stored; smaller; 8-bit sRGB */
    struct view_picture picture;
    struct ttf_err err;
    int code;
};

struct view_panel {
    const struct ttf_view_texture *texture;
    uint32_t *frame; /* numbers of the sequence's frames, ascending */
    uint32_t n;
    uint32_t width, height; /* of the pictures */
    bool exact;
    double black, white; /* values of display codes 0 and 255 */
    uint8_t *display;    /* 65,536 of the sequence's codes as display codes */
    struct ttf_pool *pool;
    struct view_slot *slot; /* one per thread of the pool */
    unsigned n_slots;
};

/* Chooses frames and brightness. The pool is borrowed. To be freed in any case. */
TTF_MUST_USE int view_panel_init(struct view_panel *panel, const struct ttf_view_texture *texture,
                                 const struct ttf_view_config *config, struct ttf_pool *pool,
                                 struct ttf_err *err);

/* Chooses size and kind so that all pictures as text should take at most so many bytes. -EFBIG */
TTF_MUST_USE int view_panel_fit(struct view_panel *panel, const struct ttf_view_config *config,
                                int64_t bytes, struct ttf_err *err);

/* Smaller by this factor. False if it cannot be smaller. */
bool view_panel_shrink(struct view_panel *panel, double factor);

/*
 * Makes pictures first..first+n-1 of the chosen ones, n at most n_slots, in parallel:
 * they are in slot[0..n-1].picture until the next call.
 */
TTF_MUST_USE int view_panel_pictures(struct view_panel *panel, const uint32_t *frames, unsigned n,
                                     struct ttf_err *err);

void view_panel_free(struct view_panel *panel);

#endif
