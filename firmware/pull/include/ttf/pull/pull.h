/* SPDX-License-Identifier: Apache-2.0 */
/* pull.h: datasets of a box, brought here and verified (README.md). Waits for the network; one thread. */
#ifndef TTF_PULL_PULL_H
#define TTF_PULL_PULL_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"

/* How it stands. From the calling thread, often; cheap to pass over. */
struct ttf_pull_progress {
    const char *dataset;
    int64_t slots_done, slots; /* of this dataset; slots: as the box said last */
    int64_t bytes;             /* that came over the wire so far, in all */
    int64_t now_ns;
    const char *text; /* something worth a line; NULL: just numbers */
};

struct ttf_pull_config {
    struct ttf_io *io;
    struct ttf_clock *clock;
    const char *box;          /* "http://ADDRESS:PORT" or "unix:PATH" */
    const char *token;        /* NULL: none is sent */
    const char *dest;         /* the folder; made if it is missing */
    const char *const *names; /* those datasets alone, NULL-ended; NULL: all */
    bool follow;              /* until each is sealed */
    void (*progress)(void *ctx, const struct ttf_pull_progress *progress); /* NULL allowed */
    void *progress_ctx;
    /* Asked when the wire has failed: 0, or an error and its words if the box will never answer there. NULL allowed. */
    int (*ended)(void *ctx, struct ttf_err *err);
    void *ended_ctx;
    const volatile int *stop; /* becomes non-zero: end soon; NULL allowed */
};

struct ttf_pull_result {
    int64_t datasets, sealed; /* brought; of them sealed, with the box's digest */
    int64_t slots;            /* record lines of slots that are here now */
    int64_t files;            /* that came now; others were here already */
    int64_t bytes;            /* over the wire */
    int64_t damaged;          /* files that the box has wrong: left out */
    char first_damaged[256];  /* dataset/path of the first */
    bool stopped;             /* before it was done */
};

/*
 * 0: all that was asked for is here, or it was told to stop. -TTF_EDAMAGED: all but what is damaged on the box is here
 * (*ret is set). -ENOENT: no such dataset; -EEXIST: something else has its place; -EBUSY: another program is writing there; -EINVAL: box; -EACCES: the token is asked for;
 * -ECONNREFUSED, -ETIMEDOUT, -ECONNRESET, -EAGAIN (short of handles and the like), ...: the box does not answer, or no longer; run it again and it goes on; what
 * config->ended says. *ret is set whatever happens.
 */
TTF_MUST_USE int ttf_pull(const struct ttf_pull_config *config, struct ttf_pull_result *ret,
                          struct ttf_err *err);

/* The box's list of datasets as JSON, by malloc. Errors as above. */
TTF_MUST_USE int ttf_pull_list(const struct ttf_pull_config *config, char **ret_text,
                               struct ttf_err *err);

#endif
