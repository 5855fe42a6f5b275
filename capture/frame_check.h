/* SPDX-License-Identifier: Apache-2.0 */
/* frame_check.h: whether a camera's buffer is the frame that was asked for. Pure. */
#ifndef TTF_CAPTURE_PRIVATE_FRAME_CHECK_H
#define TTF_CAPTURE_PRIVATE_FRAME_CHECK_H

#include "ttf/base/frame.h"

/* Reasons for refusing a frame, as they stand in records. */
#define TTF_REFUSED_CORRUPT  "corrupt"
#define TTF_REFUSED_SHORT    "short"
#define TTF_REFUSED_FORMAT   "wrong format"
#define TTF_REFUSED_SETTINGS "wrong settings"
#define TTF_REFUSED_MISSING  "missing"

/* Why it is refused, or NULL: it is good. TTF_REFUSED_SETTINGS comes last: the data are whole. */
const char *ttf_frame_refused(const struct ttf_frame *frame, const struct ttf_frame_format *format,
                              const struct ttf_exposure *granted);

#endif
