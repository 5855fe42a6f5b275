/* SPDX-License-Identifier: Apache-2.0 */
/* made_dataset.h: a dataset put together slot by slot, as a capture or a synthesis would leave it. */
#ifndef MADE_DATASET_H
#define MADE_DATASET_H

#include <stdint.h>

#include "ttf/dataset/colour.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/pixbuf.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/writer.h"

#define MADE_W 20u
#define MADE_H 150u /* more than one strip's rows would hide mistakes in */

/* One more stream of MADE_W x MADE_H; the first is the primary one. */
void add_stream(struct ttf_manifest *manifest, const char *id, uint32_t samples,
                enum ttf_sample format);
struct ttf_writer *create(const char *path, const struct ttf_manifest *manifest);
/* Of its own boot, a slot a minute. */
void add_segment(struct ttf_writer *writer, int number, int64_t first, int64_t utc_ns);

struct shot {
    const char *stream;
    int bracket;
    double relative_exposure;
    struct ttf_pixbuf *pixels; /* NULL: lacking */
};

void add_slot(struct ttf_writer *writer, int64_t index, int segment, int64_t due_ns,
              const struct shot *shots, unsigned n);
/* Of segment 0 and stream "main", one image; uncertainty and mask may be NULL. */
void add_slot_beside(struct ttf_writer *writer, int64_t index, int64_t due_ns,
                     struct ttf_pixbuf *pixels, struct ttf_pixbuf *uncertainty,
                     struct ttf_pixbuf *mask);
struct ttf_reader *open_reader(const char *path);

#endif
