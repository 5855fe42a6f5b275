/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/develop.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "develop_space.h"

/* Bits that codes were shifted by beyond the calibration's (a DNG of an average), or -1. */
static int levels_shift(const struct ttf_calibration *calibration, uint16_t black, uint16_t white)
{
    for (int shift = 0; shift < 16; shift++) {
        if ((uint32_t)calibration->black_level << shift == black &&
            (uint32_t)calibration->white_level << shift == white)
            return shift;
    }
    return -1;
}

static int check_calibration(const struct ttf_develop *develop, struct ttf_err *err)
{
    const struct ttf_calibration *calibration = develop->config.calibration;
    const struct ttf_frame_format *format = &develop->config.format;

    if (!calibration || (!calibration->has_dark && !calibration->has_flat))
        return 0;
    if (develop->samples != 1)
        return ttf_err_set(
            err, -EINVAL, NULL,
            "the calibration is for raw frames, and these are finished RGB pictures");
    if (calibration->width != format->width || calibration->height != format->height ||
        calibration->cfa != format->cfa)
        return ttf_err_set(err, -EINVAL, NULL,
                           "the calibration %s is for frames of %u x %u, and these are of %u x %u "
                           "or of another mosaic",
                           calibration->id, calibration->width, calibration->height, format->width,
                           format->height);
    if (levels_shift(calibration, develop->black, develop->white) < 0)
        return ttf_err_set(err, -EINVAL, NULL,
                           "the calibration %s is for levels %u to %u, and these frames have %u to "
                           "%u: another camera or mode",
                           calibration->id, calibration->black_level, calibration->white_level,
                           develop->black, develop->white);
    return 0;
}

static int check_config(struct ttf_develop *develop, struct ttf_err *err)
{
    struct ttf_region *region = &develop->config.region;
    const struct ttf_frame_format *format = &develop->config.format;
    const struct ttf_encoding *encoding = &develop->config.encoding;

    if (region->width == 0)
        *region = (struct ttf_region){0, 0, format->width, format->height};
    if (region->height == 0 || region->x >= format->width || region->y >= format->height ||
        region->width > format->width - region->x || region->height > format->height - region->y)
        return ttf_err_set(err, -EINVAL, "region",
                           "the region %u x %u at %u, %u does not lie in the frame of %u x %u",
                           region->width, region->height, region->x, region->y, format->width,
                           format->height);
    if (!(encoding->scale > 0.0 && encoding->scale <= 1e9) ||
        !(encoding->pedestal >= 0.0 && encoding->pedestal < 65536.0))
        return ttf_err_set(err, -EINVAL, "encoding", "no encoding has pedestal %g and scale %g",
                           encoding->pedestal, encoding->scale);
    if (format->cfa != TTF_CFA_NONE && (format->width < 4 || format->height < 4))
        return ttf_err_set(err, -EINVAL, NULL, "a mosaic of %u x %u is too small to develop",
                           format->width, format->height);
    return check_calibration(develop, err);
}

static void take_matrix(struct ttf_develop *develop)
{
    const struct ttf_calibration *calibration = develop->config.calibration;

    for (int i = 0; calibration && i < 9; i++) {
        develop->matrix[i] = (float)calibration->colour_matrix[i];
        if (calibration->colour_matrix[i] != (i % 4 == 0 ? 1.0 : 0.0))
            develop->has_matrix = true;
    }
}

int ttf_develop_create(const struct ttf_develop_config *config, struct ttf_develop **ret,
                       struct ttf_err *err)
{
    struct ttf_develop *develop;
    int r, samples = calibration_samples(&config->format);

    if (samples < 0)
        return ttf_err_set(err, samples, NULL,
                           "frames of %u x %u and this packing cannot be developed",
                           config->format.width, config->format.height);
    develop = calloc(1, sizeof(*develop));
    if (!develop)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for development");
    develop->config = *config;
    develop->samples = (unsigned)samples;
    ttf_raw_sum_levels(&config->format, &develop->black, &develop->white);
    r = check_config(develop, err);
    if (r < 0) {
        free(develop);
        return r;
    }
    take_matrix(develop);
    *ret = develop;
    return 0;
}

void ttf_develop_destroy(struct ttf_develop *develop)
{
    if (!develop)
        return;
    develop_space_free(&develop->space);
    free(develop);
}

uint32_t ttf_develop_width(const struct ttf_develop *develop)
{
    return develop->config.region.width;
}

uint32_t ttf_develop_height(const struct ttf_develop *develop)
{
    return develop->config.region.height;
}

static int begin_run(struct develop_run *run, const struct ttf_develop *develop,
                     const struct ttf_raw_sum *raw, struct ttf_err *err)
{
    const struct ttf_calibration *calibration = develop->config.calibration;
    const struct ttf_frame_format *format = &develop->config.format;
    int shift = 0;

    if (raw->n == 0 || raw->samples != develop->samples || raw->format.width != format->width ||
        raw->format.height != format->height || raw->format.cfa != format->cfa ||
        raw->format.packing != format->packing || raw->format.black_level != format->black_level ||
        raw->format.white_level != format->white_level) {
        ttf_err_set(err, -EINVAL, NULL,
                    raw->n == 0 ? "there is no frame to develop"
                                : "the frame is not of the format that was configured");
        return -EINVAL;
    }
    if (calibration && (calibration->has_dark || calibration->has_flat))
        shift = levels_shift(calibration, develop->black, develop->white);
    run->develop = develop;
    run->raw = raw;
    run->mean = (float)(1.0 / ((double)raw->n * (double)(1u << shift)));
    run->black = (float)(develop->black >> shift);
    if (calibration && calibration->has_flat)
        run->level =
            (float)(calibration_exposure_ratio(&calibration->flat_settings, &raw->settings) /
                    calibration->flat_level);
    else
        run->level = (float)(1.0 / (double)((develop->white - develop->black) >> shift));
    return 0;
}

/* Strips first..first+n-1 of a run, into rows whose first is row `dst_y` of the region. */
struct strips_job {
    const struct develop_run *run;
    uint32_t first;
    float *scratch; /* one piece per worker */
    size_t scratch_each;
    const struct ttf_pixbuf *dst;
    uint32_t dst_y;
    uint64_t *saturated; /* per strip of the job */
};

static uint32_t strip_rows(const struct ttf_develop *develop, uint32_t strip)
{
    uint32_t left = develop->config.region.height - strip * STRIP_ROWS;

    return left < STRIP_ROWS ? left : STRIP_ROWS;
}

static void strip_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct strips_job *job = ctx;
    uint32_t strip = job->first + tile, y = strip * STRIP_ROWS;

    job->saturated[tile] =
        develop_strip(job->run, y, strip_rows(job->run->develop, strip),
                      job->scratch + worker * job->scratch_each,
                      ttf_pixbuf_row(job->dst, y - job->dst_y), job->dst->stride);
}

/* The figures of a strip's rows, once all rows of the job are there. below_last: the job's row after its last, or NULL. */
struct figures_job {
    const struct strips_job *strips;
    uint32_t rows; /* of the job's dst that are valid */
    struct develop_sums *sums;
};

static void figures_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct figures_job *job = ctx;
    const struct ttf_pixbuf *dst = job->strips->dst;
    uint32_t y0 = tile * STRIP_ROWS, y1 = y0 + STRIP_ROWS;

    if (y1 > job->rows)
        y1 = job->rows;
    for (uint32_t y = y0; y < y1; y++)
        develop_sums_row(&job->sums[tile], ttf_pixbuf_row(dst, y),
                         y + 1 < job->rows ? ttf_pixbuf_row(dst, y + 1) : NULL, dst->width);
}

/* Develops n strips from `first` on and adds their figures. dst_y: the region's row that dst begins with. */
static void run_strips(struct strips_job *job, unsigned n, struct ttf_pool *pool,
                       struct develop_sums *sums, struct develop_sums *scratch_sums)
{
    const struct ttf_develop *develop = job->run->develop;
    struct figures_job figures = {.strips = job, .sums = scratch_sums};

    memset(scratch_sums, 0, n * sizeof(*scratch_sums));
    for (unsigned i = 0; i < n; i++)
        figures.rows += strip_rows(develop, job->first + i);
    ttf_pool_run(pool, n, strip_tile, job);
    ttf_pool_run(pool, n, figures_tile, &figures);
    for (unsigned i = 0; i < n; i++) {
        scratch_sums[i].saturated = job->saturated[i];
        scratch_sums[i].raw = (uint64_t)strip_rows(develop, job->first + i) *
                              develop->config.region.width * develop->samples;
        develop_sums_add(sums, &scratch_sums[i]);
    }
}

int ttf_develop_run(struct ttf_develop *develop, const struct ttf_raw_sum *raw,
                    struct ttf_pool *pool, struct ttf_pixbuf *dst,
                    struct ttf_image_figures *ret_figures, struct ttf_err *err)
{
    struct develop_sums sums = {0};
    struct develop_space own = {0}, *space;
    struct develop_run run;
    struct strips_job job;
    int r = begin_run(&run, develop, raw, err);

    if (r < 0)
        return r;
    if (dst->width != develop->config.region.width ||
        dst->height != develop->config.region.height || dst->samples != 3 ||
        dst->format != TTF_SAMPLE_U16)
        return ttf_err_set(err, -EINVAL, NULL, "the destination is not of the developed size");
    r = develop_space_for(develop, pool, false, &own, &space, err);
    if (r < 0)
        return r;
    job = (struct strips_job){.run = &run,
                              .scratch = space->scratch,
                              .scratch_each = space->scratch_each,
                              .dst = dst,
                              .saturated = space->saturated};
    run_strips(&job, develop_strips(develop), pool, &sums, space->sums);
    if (ret_figures)
        *ret_figures = develop_figures(&sums, &develop->config.encoding);
    develop_space_free(&own);
    return 0;
}

/* The differences across the seam between two chunks, which neither has seen. */
static void add_seam(struct develop_sums *sums, const uint16_t *above, const uint16_t *below,
                     uint32_t width)
{
    struct develop_sums with = {0}, without = {0};

    develop_sums_row(&with, above, below, width);
    develop_sums_row(&without, above, NULL, width);
    sums->gradient += with.gradient - without.gradient;
    sums->steps += with.steps - without.steps;
}

static int write_chunks(const struct develop_run *run, struct develop_space *space,
                        struct ttf_pool *pool, struct develop_sums *sums, struct ttf_err *err)
{
    const struct ttf_develop *develop = run->develop;
    struct ttf_pixbuf *chunk = &space->chunk;
    unsigned all = develop_strips(develop);
    int r = 0;

    for (unsigned first = 0; r == 0 && first < all; first += CHUNK_STRIPS) {
        unsigned n = all - first < CHUNK_STRIPS ? all - first : CHUNK_STRIPS;
        uint32_t y0 = first * STRIP_ROWS, rows = develop->config.region.height - y0;
        struct strips_job job = {.run = run,
                                 .first = first,
                                 .scratch = space->scratch,
                                 .scratch_each = space->scratch_each,
                                 .dst = chunk,
                                 .dst_y = y0,
                                 .saturated = space->saturated};

        if (rows > CHUNK_STRIPS * STRIP_ROWS)
            rows = CHUNK_STRIPS * STRIP_ROWS;
        run_strips(&job, n, pool, sums, space->sums);
        if (first > 0)
            add_seam(sums, space->last_row, chunk->data, chunk->width);
        memcpy(space->last_row, ttf_pixbuf_row(chunk, rows - 1), (size_t)chunk->width * 6);
        r = ttf_tiff_writer_rows(space->writer, chunk->data, chunk->stride, rows, err);
    }
    return r;
}

int ttf_develop_tiff(struct ttf_develop *develop, const struct ttf_raw_sum *raw,
                     struct ttf_pool *pool, const struct ttf_tiff_times *times, struct ttf_io *io,
                     int file, struct ttf_image_figures *ret_figures, struct ttf_err *err)
{
    static const struct ttf_tiff_times unknown = {.start_utc_ns = TTF_NS_UNKNOWN};
    struct develop_sums sums = {0};
    struct develop_space own = {0}, *space;
    struct develop_run run;
    int r = begin_run(&run, develop, raw, err);

    if (r < 0)
        return r;
    r = develop_space_for(develop, pool, true, &own, &space, err);
    if (r < 0)
        return r;
    r = ttf_tiff_writer_begin(space->writer, times ? times : &unknown, io, file, err);
    if (r == 0) {
        r = write_chunks(&run, space, pool, &sums, err);
        if (r == 0)
            r = ttf_tiff_writer_end(space->writer, err);
        else
            ttf_tiff_writer_drop(space->writer);
    }
    if (r == 0 && ret_figures)
        *ret_figures = develop_figures(&sums, &develop->config.encoding);
    develop_space_free(&own);
    return r;
}
