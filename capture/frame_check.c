/* SPDX-License-Identifier: Apache-2.0 */
#include "frame_check.h"

#include "exposure.h"

bool ttf_frame_format_equal(const struct ttf_frame_format *a, const struct ttf_frame_format *b)
{
    return a->width == b->width && a->height == b->height && a->packing == b->packing &&
           a->cfa == b->cfa && a->bits == b->bits && a->black_level == b->black_level &&
           a->white_level == b->white_level;
}

const char *ttf_frame_refused(const struct ttf_frame *frame, const struct ttf_frame_format *format,
                              const struct ttf_exposure *granted)
{
    if (frame->flags & TTF_FRAME_ERROR)
        return TTF_REFUSED_CORRUPT;
    if (!ttf_frame_format_equal(&frame->format, format))
        return TTF_REFUSED_FORMAT;
    if ((frame->flags & TTF_FRAME_SHORT) || !frame->data ||
        frame->bytes < ttf_frame_rows(&frame->format) * frame->format.stride)
        return TTF_REFUSED_SHORT;
    if (!ttf_exposure_equal(&frame->settings, granted))
        return TTF_REFUSED_SETTINGS;
    return NULL;
}
