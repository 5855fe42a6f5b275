/* SPDX-License-Identifier: Apache-2.0 */
#include "search/learner.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/synth/cancel.h"

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
    const struct ttf_aside *aside;
    atomic_uint own_tiles; /* of the running step that are not done */
    uint8_t *block;        /* both batches' codes */
    uint16_t *scratch;
    /* of one round: learn this, read that */
    const struct batch *learn;
    struct batch *read;
    uint32_t read_from;
    struct result results[TTF_FACTORS_BATCH], besides; /* besides: 1 while there is more */
};

/* Tiles of a step that come before those of its own: the longest first. */
#define LEARN   0u
#define BESIDES 1u
#define TOUCH   2u
#define READ    3u /* and so on, a frame each */
#define NOISE   0u
#define ROTATE  2u /* and so on */

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

/* As long as the other threads have something to do: none waits for what can as well be done later. */
static void do_besides(struct work *work)
{
    struct result *result = &work->besides;

    while (result->code > 0 && !ttf_cancelled(work->cancel) &&
           atomic_load_explicit(&work->own_tiles, memory_order_relaxed) > 0)
        result->code = work->aside->next(work->aside->ctx, &result->err);
}

static void end_tile(struct work *work)
{
    atomic_fetch_sub_explicit(&work->own_tiles, 1, memory_order_relaxed);
}

static void read_frame(struct work *work, unsigned tile, unsigned worker)
{
    struct result *result = &work->results[tile];

    result->code = ttf_cancelled(work->cancel)
                       ? ttf_err_set(&result->err, -ECANCELED, NULL, "cancelled")
                       : ttf_sources_read_codes(work->sources, work->read_from + tile, work->table,
                                                work->scratch + worker * TTF_SOURCES_PIECE,
                                                work->read->codes[tile], &result->err);
}

/* Memory for the batch behind the one that is read now. */
static void touch_next(const struct work *work)
{
    uint32_t from = work->read_from + work->read->n;

    if (work->kept)
        ttf_kept_touch(work->kept, from, from + work->batch_frames, work->aside->now_ns,
                       work->aside->now_ctx);
}

static void read_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct work *work = ctx;

    if (tile == BESIDES) {
        do_besides(work);
        return;
    }
    if (tile >= READ)
        read_frame(work, tile - READ, worker);
    else if (tile == TOUCH)
        touch_next(work);
    else if (work->learn)
        for (unsigned i = 0; i < work->learner->n_factors; i++)
            ttf_factors_learn(&work->learner->factors[i], frames_of(work->learn), work->learn->n);
    end_tile(work);
}

static void rotate_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct work *work = ctx;
    const struct batch *learn = work->learn;
    unsigned tiles = ttf_factors_tiles(&work->learner->factors[0]);

    (void)worker;
    if (tile == BESIDES) {
        do_besides(work);
        return;
    }
    if (tile == NOISE) {
        for (unsigned i = 0; i < learn->n; i++)
            ttf_second_differences_add(&work->learner->noise, learn->codes[i],
                                       work->sources->pixels);
    } else {
        tile -= ROTATE;
        ttf_factors_rotate(&work->learner->factors[tile / tiles], frames_of(learn), learn->n,
                           tile % tiles);
    }
    end_tile(work);
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

static int first_error(const struct work *work, unsigned n, struct ttf_err *err)
{
    const struct result *bad = work->besides.code < 0 ? &work->besides : NULL;

    for (unsigned i = 0; i < n && !bad; i++)
        bad = work->results[i].code < 0 ? &work->results[i] : NULL;
    if (bad && err)
        *err = bad->err;
    return bad ? bad->code : 0;
}

static void run_step(struct work *work, unsigned tiles, ttf_tile_fn *tile)
{
    atomic_store_explicit(&work->own_tiles, tiles - 1, memory_order_relaxed);
    ttf_pool_run(work->pool, tiles, tile, work);
}

/* Learns one batch while the next is read; then turns all pixels. */
static int one_round(struct work *work, const struct batch *learn, struct batch *read,
                     uint32_t from, unsigned n, struct ttf_err *err)
{
    struct ttf_learner *learner = work->learner;
    int r;

    work->learn = learn;
    work->read = read;
    work->read_from = from;
    read->n = n;
    place_codes(work, read, from);
    memset(work->results, 0, sizeof(work->results));
    run_step(work, READ + n, read_tile);
    r = first_error(work, n, err);
    if (r < 0 || !learn)
        return r;
    run_step(work, ROTATE + learner->n_factors * ttf_factors_tiles(learner->factors), rotate_tile);
    for (unsigned i = 0; i < learner->n_factors; i++)
        ttf_factors_rotated(&learner->factors[i], learn->n);
    return first_error(work, 0, err);
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
                    uint32_t to, const uint8_t *table, const struct ttf_aside *aside,
                    const volatile int *cancel, struct ttf_pool *pool, struct ttf_err *err)
{
    struct work work = {.learner = learner,
                        .sources = sources,
                        .table = table,
                        .aside = aside,
                        .kept = from == 0 && aside ? aside->kept : NULL,
                        .besides = {.code = aside && aside->next},
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
