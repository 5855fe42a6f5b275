/* SPDX-License-Identifier: Apache-2.0 */
/* preview_watch.h: whether ttfbox-preview has made another preview of the dataset that the box is about: listeners are told. */
#ifndef DAEMON_PREVIEW_WATCH_H
#define DAEMON_PREVIEW_WATCH_H

#include "parts.h"

struct preview_watch {
    char dataset[65];
    struct ttf_io_stat seen; /* of its state's file; inode 0: there was none */
    int64_t images;          /* in the preview that was told of last, or was there before */
};

/* One look: a file's stat, and where that changed the file. Of one that is there at the first look nothing is told. */
void preview_watch_look(struct preview_watch *watch, struct daemon *d);

#endif
