/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quilt_sink.h: where a synthesis's frames go: a dataset, one file of 8-bit RGB
 * frames, or nowhere.
 */
#ifndef CLI_QUILT_SINK_H
#define CLI_QUILT_SINK_H

#include "cli.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/run.h"

enum quilt_sink_kind {
    QUILT_SINK_DATASET = 0,
    QUILT_SINK_RAW,
    QUILT_SINK_NULL
};

int quilt_sink_find(const char *name); /* "dataset", "raw", "null"; -ENOENT */

struct quilt_sink;

struct quilt_sink_spec {
    enum quilt_sink_kind kind;
    struct ttf_reader *parent;        /* of the input, NULL if it is a picture */
    const char *source;               /* the input's path */
    const struct ttf_sequence *input; /* these two must outlive the sink */
    const struct ttf_quilt_config *config;
    uint32_t shrink; /* of the input, before: how many of its pixels one of these is across */
    /* What is done to each frame before it is written, in place; NULL: nothing. Any thread. */
    void (*edit)(void *ctx, const struct ttf_encoding *encoding, uint16_t *codes);
    void *edit_ctx;
};

/* Errors in cli->err. */
TTF_MUST_USE int quilt_sink_create(struct cli *cli, const struct quilt_sink_spec *spec,
                                   struct quilt_sink **ret);

/* What ttf_quilt_run writes to. */
struct ttf_quilt_sink quilt_sink_of(struct quilt_sink *sink);

/* All frames came: report.json and the seal, or the file's end. */
TTF_MUST_USE int quilt_sink_finish(struct quilt_sink *sink, const struct ttf_quilt_report *report,
                                   struct ttf_err *err);

const char *quilt_sink_name(const struct quilt_sink *sink);
const char *quilt_sink_digest(const struct quilt_sink *sink); /* "" until sealed */

/* Frees; what was not finished is taken away. NULL allowed. */
void quilt_sink_destroy(struct quilt_sink *sink);

#endif
