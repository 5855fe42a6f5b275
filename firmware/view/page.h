/* SPDX-License-Identifier: Apache-2.0 */
/* page.h: the pieces of the file around the pictures. */
#ifndef VIEW_PAGE_H
#define VIEW_PAGE_H

#include "file.h"
#include "panel.h"

/* Markup, style and what is known of the textures. -ENOMEM */
TTF_MUST_USE int page_head(struct view_file *file, const struct view_panel *panels, unsigned n,
                           struct ttf_err *err);
void page_picture(struct view_file *file, unsigned panel, const uint8_t *data, size_t bytes);
/* Scripts, which run once all pictures are there. */
void page_tail(struct view_file *file);

#endif
