/* SPDX-License-Identifier: Apache-2.0 */
/*
 * image_flags.h: the words that mark an image: "wrong-settings", "short-average",
 * "late", "saturated", "lamp-tripped", "lamp-level", "lamp-unsettled", "lamp-unknown", "door-open",
 * "raw-lost", "developed-lost", "under-voltage". Together they fit into ttf_image.flags.
 */
#ifndef TTF_CAPTURE_PRIVATE_IMAGE_FLAGS_H
#define TTF_CAPTURE_PRIVATE_IMAGE_FLAGS_H

#include "ttf/dataset/record.h"

/* Adds a word to an image's flags, once. */
void ttf_image_flag(struct ttf_image *image, const char *word);

#endif
