/* SPDX-License-Identifier: Apache-2.0 */
/* imported.h: imports that must succeed, and looking at what they made. */
#ifndef IMPORTED_H
#define IMPORTED_H

#include "trade_test.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"

/* Fails the test with the error's words. */
struct ttf_import_result import_ok(struct ttf_io *io, const struct ttf_import_config *config);

/* An opened dataset with its primary sequence. */
struct opened {
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;
};

struct opened open_dataset(const char *path);
void close_dataset(struct opened *opened);

/* height x width x 3 codes of frame t, to be freed. */
uint16_t *read_frame(struct ttf_sequence *s, uint32_t t);

#endif
