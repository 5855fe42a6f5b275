/* SPDX-License-Identifier: Apache-2.0 */
/* tar_read.h: the bytes of an archive from any place on. One thread at a time. */
#ifndef HTTP_TAR_READ_H
#define HTTP_TAR_READ_H

#include <stdint.h>
#include <sys/types.h>

#include "tar_layout.h"

struct tar_reader;

/* Takes the layout over. folder must outlive it. NULL: no memory (the layout is freed). */
struct tar_reader *tar_reader_create(const struct folder *folder, struct tar_layout *layout);
void tar_reader_destroy(struct tar_reader *reader); /* NULL allowed */
const struct tar_layout *tar_reader_layout(const struct tar_reader *reader);

/*
 * Up to n bytes from offset on; fewer, but at least one, where a piece ends. -EIO: a file has become shorter than it was
 * laid out, -errno of reading. 0: behind the end.
 */
TTF_MUST_USE ssize_t tar_read(struct tar_reader *reader, int64_t offset, void *buf, size_t n);

#endif
