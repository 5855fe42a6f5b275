/* SPDX-License-Identifier: Apache-2.0 */
/* note.h: a note added to a dataset, or samples named in it, by one who has time. */
#ifndef TTF_CAPTURE_NOTE_H
#define TTF_CAPTURE_NOTE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"
#include "ttf/hal/clock.h"

/* As ttf_note_append, and waits by the clock, two seconds at most, while somebody else adds one. Any thread. */
TTF_MUST_USE int ttf_note_add(struct ttf_clock *clock, struct ttf_io *io, const char *path,
                              const struct ttf_note *note, struct ttf_err *err);

/* As ttf_samples_change, and waits in the same way. Any thread. */
TTF_MUST_USE int ttf_samples_say(struct ttf_clock *clock, struct ttf_io *io, const char *path,
                                 const struct ttf_sample_change *changes, unsigned n,
                                 struct ttf_err *err);

#endif
