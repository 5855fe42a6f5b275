/* SPDX-License-Identifier: Apache-2.0 */
/* derive.h: a new dataset made of an old one: what it says of its parent, and its frames. */
#ifndef CLI_DERIVE_H
#define CLI_DERIVE_H

#include "cli.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/tiff.h"
#include "ttf/dataset/writer.h"

/* What dataset.json says of the command that made it: the words after "ttfbox". Returns buf. */
const char *derive_command(const struct cli *cli, char *buf, size_t size);

/* A manifest of its own uuid, with parent, command, SIMULATED and "rehearsal" taken over. */
TTF_MUST_USE int derive_manifest(struct cli *cli, struct ttf_reader *parent,
                                 struct ttf_manifest *ret);

/* As ttf_writer_create at a path that cli_refuse_existing has passed; what fails halfway is taken away. */
TTF_MUST_USE int derive_create(struct cli *cli, const char *path,
                               const struct ttf_manifest *manifest, const char *plan_yaml,
                               const char *plan_json, struct ttf_writer **ret);
/* Notes and samples of one dataset, for another one of the same slots and pixels; what cannot be taken over is warned of. */
void derive_people(struct cli *cli, const char *from, const char *to);

/* As ttf_writer_seal; what is made of a rehearsal is none either, stays unsealed, and has no digest. */
TTF_MUST_USE int derive_seal(struct ttf_writer *writer, const char *reason, char ret_digest[65],
                             struct ttf_err *err);

/* Bytes of a whole dataset that could not be finished, taken away. */
void derive_discard(struct ttf_io *io, const char *path);

#endif
