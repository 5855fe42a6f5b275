/* SPDX-License-Identifier: Apache-2.0 */
/*
 * body.h: what bodies in JSON say. Names that nobody asked for are refused, as a slip of the pen would else pass for
 * something done. -EINVAL says which field is wrong; -ENOMEM.
 */
#ifndef HTTP_BODY_H
#define HTTP_BODY_H

#include <stddef.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/notes.h"
#include "ttf/http/box.h"

/* {"token"}. */
TTF_MUST_USE int body_token(const char *text, size_t bytes, char *ret, size_t size,
                            struct ttf_err *err);

/* {"plan","dataset"}, either of them may be missing: then "". */
TTF_MUST_USE int body_start(const char *text, size_t bytes, char ret_plan[65], char ret_dataset[65],
                            struct ttf_err *err);

/* {"reason"} of a pause, or no text at all. */
TTF_MUST_USE int body_pause(const char *text, size_t bytes, struct ttf_http_ask *ret,
                            struct ttf_err *err);

/* Exactly one of {"count"}, {"until_utc_ns"}, {"interval_ns"}. */
TTF_MUST_USE int body_change(const char *text, size_t bytes, struct ttf_http_ask *ret,
                             struct ttf_err *err);

/* {"part","plan","exposure_ns","gain_milli","frames","reflectance","pitch_mm","corners"} of a step of a calibration; its name is
 * not of the body. */
TTF_MUST_USE int body_calibrate(const char *text, size_t bytes, struct ttf_http_calibrate *ret,
                                struct ttf_err *err);

/* {"name"}, which may be "". */
TTF_MUST_USE int body_name(const char *text, size_t bytes, char ret[65], struct ttf_err *err);

/* {"utc_ns"}. */
TTF_MUST_USE int body_time(const char *text, size_t bytes, int64_t *ret_utc_ns,
                           struct ttf_err *err);

/* {"text","author","slots","tags"}; checked as ttf_note_check does. Its time is not known. */
TTF_MUST_USE int body_note(const char *text, size_t bytes, struct ttf_note *ret,
                           struct ttf_err *err);

/* Query of a live view; NULL: not said. */
struct body_view {
    const char *camera, *exposure_ns, *gain_milli, *lamps, *region;
};
TTF_MUST_USE int body_view(const struct body_view *said, struct ttf_http_view *ret,
                           struct ttf_err *err);

#endif
