/* SPDX-License-Identifier: Apache-2.0 */
/* sequence_frames.h: which files make up a stream's sequence, and when. Private to sequences. */
#ifndef TTF_DATASET_SEQUENCE_FRAMES_H
#define TTF_DATASET_SEQUENCE_FRAMES_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"

/* n entries each; owned. */
struct sequence_frames {
    uint32_t n, room;
    char **path; /* of the process */
    int64_t *index;
    int64_t *time_ns;  /* from the first frame's */
    int64_t *excluded; /* slots left out as notes say */
    uint32_t n_excluded, excluded_room;
};

/* Walks all slot lines. -ENODATA if the stream has no such developed image. On failure nothing is kept. */
TTF_MUST_USE int sequence_frames_collect(struct ttf_reader *reader, const struct ttf_stream *stream,
                                         const struct ttf_sequence_choice *choice,
                                         struct sequence_frames *ret, struct ttf_err *err);
void sequence_frames_free(struct sequence_frames *frames);

#endif
