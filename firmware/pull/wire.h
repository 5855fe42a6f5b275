/* SPDX-License-Identifier: Apache-2.0 */
/* wire.h: one request after another to a box. One thread. */
#ifndef PULL_WIRE_H
#define PULL_WIRE_H

#include <errno.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/pull/pull.h"

struct wire;

/* Where bytes of an answer go. Each: 0, or a negative errno that ends the request and is returned by it. */
struct wire_sink {
    int (*begin)(
        void *ctx,
        int64_t first); /* the answer begins at this byte of the entity; also called for none */
    int (*take)(void *ctx, const void *data, size_t n);
    void *ctx;
};

/* To config's box, with its token; config is borrowed as long as it lives. -EINVAL: box. */
TTF_MUST_USE int pull_wire_create(const struct ttf_pull_config *config, struct wire **ret,
                                  struct ttf_err *err);

/* Another connection to the same box, for another thread; counts its bytes together with the first, which outlives it. */
TTF_MUST_USE int pull_wire_twin(const struct wire *of, struct wire **ret);

void pull_wire_destroy(struct wire *wire); /* NULL allowed */

/*
 * GET of a path below /api/v1. first > 0 or last >= 0: that part of it, both inclusive, if the entity is still if_tag (NULL:
 * whichever it is); the answer may be the whole all the same (begin is told). 0: it is there. -ERANGE: nothing begins at
 * first. -ENOENT, -EACCES and -EIO by what the box says, in its words; -EAGAIN: it is short of handles, archives or the like. -ECANCELED: told to stop. -ETIMEDOUT, -ECONNREFUSED, -ECONNRESET:
 * the wire; what config->ended says in place of these. -EBADMSG: the answer has no length, and may be a part of itself.
 */
TTF_MUST_USE int pull_wire_get(struct wire *wire, const char *path, int64_t first, int64_t last,
                               const char *if_tag, const struct wire_sink *sink,
                               struct ttf_err *err);

/* The answer in memory, zero-terminated, by malloc. -EFBIG beyond max; -EPROTO: a part was asked for, and the whole came. */
TTF_MUST_USE int pull_wire_get_text(struct wire *wire, const char *path, int64_t first,
                                    int64_t last, size_t max, char **ret_text, size_t *ret_bytes,
                                    struct ttf_err *err);

/* POST: json NULL: without a body. The answer (a 200; other 2xx are errors) as above, at most 64 KiB. -EEXIST and -EPERM by what the box says (409, 403), else as above. */
TTF_MUST_USE int pull_wire_post_text(struct wire *wire, const char *path, const char *json,
                                     char **ret_text, size_t *ret_bytes, struct ttf_err *err);

/* Bytes of answers so far, of its twins too. */
int64_t pull_wire_bytes(const struct wire *wire);

/* Is it an error of the wire, or of a box that is busy, which another try may not have? */
static inline bool pull_wire_may_pass(int error)
{
    return error == -ETIMEDOUT || error == -ECONNREFUSED || error == -ECONNRESET ||
           error == -EHOSTUNREACH || error == -EAGAIN;
}

#endif
