/* SPDX-License-Identifier: Apache-2.0 */
#include "develop_space.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

unsigned develop_strips(const struct ttf_develop *develop)
{
    return (develop->config.region.height + STRIP_ROWS - 1) / STRIP_ROWS;
}

/* Without a flat the colours are the camera's own, which no profile of ours names. */
static enum ttf_icc profile_of(const struct ttf_calibration *calibration)
{
    return calibration && calibration->has_flat ? TTF_ICC_LINEAR : TTF_ICC_NONE;
}

static int init_tiff(struct develop_space *space, const struct ttf_develop *develop,
                     struct ttf_err *err)
{
    const struct ttf_region *region = &develop->config.region;
    const struct ttf_tiff_spec spec = {.width = region->width,
                                       .height = region->height,
                                       .samples = 3,
                                       .format = TTF_SAMPLE_U16,
                                       .icc = profile_of(develop->config.calibration),
                                       .times = {.start_utc_ns = TTF_NS_UNKNOWN},
                                       .software = "ttfbox"};
    uint32_t rows = CHUNK_STRIPS * STRIP_ROWS;

    if (rows > region->height)
        rows = region->height;
    space->last_row = calloc((size_t)region->width * 3, sizeof(*space->last_row));
    if (!space->last_row ||
        ttf_pixbuf_alloc(&space->chunk, region->width, rows, 3, TTF_SAMPLE_U16) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for development");
    return ttf_tiff_writer_create(&spec, &space->writer, err);
}

int develop_space_init(struct develop_space *space, const struct ttf_develop *develop,
                       unsigned threads, bool tiff, struct ttf_err *err)
{
    unsigned strips = develop_strips(develop);
    int r = 0;

    memset(space, 0, sizeof(*space));
    if (strips < CHUNK_STRIPS)
        strips = CHUNK_STRIPS;
    space->threads = threads;
    space->scratch_each = develop_scratch(develop);
    space->scratch = calloc(threads * space->scratch_each, sizeof(*space->scratch));
    space->saturated = calloc(strips, sizeof(*space->saturated));
    space->sums = calloc(strips, sizeof(*space->sums));
    if (!space->scratch || !space->saturated || !space->sums)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for development");
    if (r == 0 && tiff)
        r = init_tiff(space, develop, err);
    if (r < 0)
        develop_space_free(space);
    return r;
}

void develop_space_free(struct develop_space *space)
{
    free(space->scratch);
    free(space->saturated);
    free(space->sums);
    free(space->last_row);
    ttf_pixbuf_free(&space->chunk);
    ttf_tiff_writer_abandon(space->writer);
    memset(space, 0, sizeof(*space));
}

int develop_space_for(struct ttf_develop *develop, const struct ttf_pool *pool, bool tiff,
                      struct develop_space *own, struct develop_space **ret, struct ttf_err *err)
{
    unsigned threads = ttf_pool_threads(pool);

    if (threads <= develop->space.threads && (!tiff || develop->space.writer)) {
        *ret = &develop->space;
        return 0;
    }
    *ret = own;
    return develop_space_init(own, develop, threads, tiff, err);
}

int ttf_develop_reserve(struct ttf_develop *develop, const struct ttf_pool *pool, bool tiff,
                        struct ttf_err *err)
{
    struct develop_space space;
    int r = develop_space_init(&space, develop, ttf_pool_threads(pool), tiff, err);

    if (r < 0)
        return r;
    develop_space_free(&develop->space);
    develop->space = space;
    return 0;
}
