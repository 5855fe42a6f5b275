/* SPDX-License-Identifier: Apache-2.0 */
#include "frame_check.h"

#include "exposure.h"

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
