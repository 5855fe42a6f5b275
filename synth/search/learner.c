/* SPDX-License-Identifier: Apache-2.0 */
#include "search/learner.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Two batches of 8-bit frames together take at most about this much. */
#define BATCHES_BYTES ((size_t)48 << 20)

struct batch {
    unsigned n;
    uint8_t *codes[TTF_FACTORS_BATCH];
};

struct result {
    int code;
    struct ttf_err err;
};

struct work {
    struct ttf_learner *learner;
    const struct ttf_sources *sources;
    const uint8_t *table;
    const volatile int *cancel;
    struct ttf_pool *pool;
    unsigned batch_frames;
    struct batch batches[2];
    struct ttf_kept *kept; /* where the codes of the first frames go; NULL: none */
    uint8_t *block;        /* both batches' codes */
    uint16_t *scratch;
    /* of one round: learn this, read that */
    const struct batch *learn;
    struct batch *read;
    uint32_t read_from;
    struct result results[TTF_FACTORS_BATCH];
};

int ttf_learner_create(size_t pixels, unsigned room, bool per_channel, struct ttf_learner *ret)
{
    struct ttf_learner learner = {.n_factors = per_channel ? 3 : 1};

    for (unsigned i = 0; i < learner.n_factors; i++) {
        int r = ttf_factors_create(pixels, room, per_channel ? (int)i : -1, &learner.factors[i]);

        if (r < 0) {
            ttf_learner_free(&learner);
            return r;
        }
    }
    *ret = learner;
    return 0;
}

void ttf_learner_free(struct ttf_learner *learner)
{
    for (unsigned i = 0; i < learner->n_factors; i++)
        ttf_factors_free(&learner->factors[i]);
    memset(learner, 0, sizeof(*learner));
}

static const uint8_t *const *frames_of(const struct batch *batch)
{
    return (const uint8_t *const *)batch->codes;
}

/* The first tile, and so the first to be begun, learns; each other one reads a frame. */
static void round_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct work *work = ctx;
    struct result *result;

    if (tile == 0) {
        for (unsigned i = 0; work->learn && i < work->learner->n_factors; i++)
            ttf_factors_learn(&work->learner->factors[i], frames_of(work->learn), work->learn->n);
        return;
    }
    result = &work->results[tile - 1];
    result->code =
        work->cancel && *work->cancel
            ? ttf_err_set(&result->err, -ECANCELED, NULL, "cancelled")
            : ttf_sources_read_codes(work->sources, work->read_from + tile - 1, work->table,
                                     work->scratch + worker * TTF_SOURCES_PIECE,
                                     work->read->codes[tile - 1], &result->err);
}

/* Where the codes of a batch from frame `from` on go: what is kept is read into its place. */
static void place_codes(const struct work *work, struct batch *batch, uint32_t from)
{
    size_t frame = (size_t)work->sources->pixels * 3;
    uint8_t *own = work->block + (batch == &work->batches[1]) * work->batch_frames * frame;

    for (unsigned i = 0; i < batch->n; i++)
        batch->codes[i] = work->kept && from + i < work->kept->frames
                              ? work->kept->codes + (from + i) * frame
                              : own + i * frame;
}

/* Learns one batch while the next is read; then turns all pixels. */
static int one_round(struct work *work, const struct batch *learn, struct batch *read,
                     uint32_t from, unsigned n, struct ttf_err *err)
{
    work->learn = learn;
    work->read = read;
    work->read_from = from;
    read->n = n;
    place_codes(work, read, from);
    memset(work->results, 0, sizeof(work->results));
    ttf_pool_run(work->pool, 1 + n, round_tile, work);
    for (unsigned i = 0; i < n; i++) {
        if (work->results[i].code < 0) {
            if (err)
                *err = work->results[i].err;
            return work->results[i].code;
        }
    }
    for (unsigned i = 0; learn && i < work->learner->n_factors; i++)
        ttf_factors_rotate(&work->learner->factors[i], frames_of(learn), learn->n, work->pool);
    for (unsigned i = 0; i < n; i++)
        ttf_second_differences_add(&work->learner->noise, read->codes[i], work->sources->pixels);
    return 0;
}

static int make_room(struct work *work, struct ttf_err *err)
{
    size_t frame = (size_t)work->sources->pixels * 3;
    size_t fit = BATCHES_BYTES / 2 / frame;

    work->batch_frames = fit < 2 ? 2 : fit < TTF_FACTORS_BATCH ? (unsigned)fit : TTF_FACTORS_BATCH;
    work->block = malloc(2 * work->batch_frames * frame);
    work->scratch =
        malloc(ttf_pool_threads(work->pool) * TTF_SOURCES_PIECE * sizeof(*work->scratch));
    if (!work->block || !work->scratch)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for %u frames of %u pixels",
                           2 * work->batch_frames, work->sources->pixels);
    return 0;
}

int ttf_learner_add(struct ttf_learner *learner, const struct ttf_sources *sources, uint32_t from,
                    uint32_t to, const uint8_t *table, struct ttf_kept *kept,
                    const volatile int *cancel, struct ttf_pool *pool, struct ttf_err *err)
{
    struct work work = {.learner = learner,
                        .sources = sources,
                        .table = table,
                        .kept = from == 0 ? kept : NULL,
                        .cancel = cancel,
                        .pool = pool};
    const struct batch *learn = NULL;
    unsigned turn = 0;
    int r = make_room(&work, err);

    for (uint32_t t = from; r == 0 && (t < to || learn); turn ^= 1) {
        unsigned n = to - t < work.batch_frames ? (unsigned)(to - t) : work.batch_frames;

        r = one_round(&work, learn, &work.batches[turn], t, n, err);
        learn = n > 0 ? &work.batches[turn] : NULL;
        t += n;
    }
    for (unsigned i = 0; r == 0 && i < learner->n_factors; i++) {
        r = ttf_factors_finish(&learner->factors[i], pool);
        if (r < 0)
            ttf_err_set(err, r, NULL, "no memory for the factors of %u pixels", sources->pixels);
    }
    free(work.block);
    free(work.scratch);
    return r;
}
