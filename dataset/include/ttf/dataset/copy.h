/* SPDX-License-Identifier: Apache-2.0 */
/*
 * copy.h: what a program needs that copies a dataset while it grows, file by file and line by line, without writing
 * one of its own: names that are safe to use, lines that are whole, the list of hashes of what was copied.
 */
#ifndef TTF_DATASET_COPY_H
#define TTF_DATASET_COPY_H

#include <stdbool.h>
#include <stddef.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

/* A name of a dataset, folder or file: [A-Za-z0-9._-], 1..64, not "." or "..". */
bool ttf_name_ok(const char *name);

/* Names with '/' between, at most 191 bytes: a path that cannot lead out of the dataset. */
bool ttf_path_ok(const char *path);

/* Of the seal: not notes.jsonl, samples.json, report.json, SHA256SUMS, nor names no dataset has. */
bool ttf_is_sealed_file(const char *path);

/* Does the crc at the end of a line hold? line: without its line end. */
bool ttf_line_holds(const char *line, size_t n);

/* Writes the SHA256SUMS of an unsealed dataset anew from its records; removes it if there are no images. */
TTF_MUST_USE int ttf_sums_rebuild(struct ttf_io *io, const char *dataset, struct ttf_err *err);

#endif
