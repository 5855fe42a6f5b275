/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "quilt/placement.h"
#include "quilt/time_jitter.h"
#include "search/features.h"
#include "search/matching.h"
#include "search/rank_kernels.h"
#include "search/sources.h"
#include "search/views.h"
#include "ttf/synth/quilt.h"

#define SIDE_MAX  32768u
#define BLOCK_MIN 4u

/* Times are 32-bit numbers of 1 / TTF_TIME_ONE frames. */
#define TIMED_FRAMES_MAX (UINT32_MAX / TTF_TIME_ONE + 1)

static const char *const metric_names[TTF_METRIC_COUNT] = {"display", "linear"};

const char *ttf_metric_name(enum ttf_metric metric)
{
    return (unsigned)metric < TTF_METRIC_COUNT ? metric_names[metric] : "?";
}

int ttf_metric_find(const char *name)
{
    for (int i = 0; name && i < TTF_METRIC_COUNT; i++) {
        if (strcmp(name, metric_names[i]) == 0)
            return i;
    }
    return -ENOENT;
}

void ttf_quilt_defaults(struct ttf_quilt_config *config)
{
    *config = (struct ttf_quilt_config){.width = 512,
                                        .height = 512,
                                        .block_width = 64,
                                        .block_height = 64,
                                        .tolerance = 0.1,
                                        .seed = 1,
                                        .keep_bytes = (size_t)96 << 20,
                                        .rank = 15,
                                        .jitter_every = 16,
                                        .measure = true,
                                        .metric = TTF_METRIC_DISPLAY};
}

unsigned ttf_quilt_turns(const struct ttf_quilt_config *config)
{
    unsigned turns = 1u << 0;

    if (config->mirror)
        turns |= 1u << 1;
    if (config->flips)
        turns |= 1u << 1 | 1u << 2;
    if (config->rotations) /* by 90, 180 and 270 degrees */
        turns |= 1u << 3 | 1u << 5 | 1u << 6;
    /* a mirror and a turn make all the others */
    if ((config->mirror || config->flips) && config->rotations)
        turns = (1u << TTF_TURN_COUNT) - 1;
    return turns;
}

/* Of the search over all frames: trajectories, features, and 24 bytes of search workspace per position. */
static double full_bytes_per_pixel(uint32_t n)
{
    return 3.0 * n + (double)ttf_features_bytes_per_pixel(n) + 24.0;
}

size_t ttf_quilt_matching_bytes(const struct ttf_quilt_config *config, uint32_t pixels, uint32_t n)
{
    unsigned rank = config->rank_error > 0.0 ? TTF_QUILT_RANK_MAX : config->rank;
    unsigned turns = (unsigned)__builtin_popcount(ttf_quilt_turns(config));
    double per_pixel, bytes;

    if (rank == TTF_QUILT_RANK_FULL) {
        per_pixel = full_bytes_per_pixel(n);
    } else {
        /* coefficients of each view (but the first, which are the matching's), its cells and positions */
        unsigned numbers = rank * (config->per_channel ? 3 : 1);
        unsigned stride = (numbers + TTF_COEF_LANES - 1) / TTF_COEF_LANES * TTF_COEF_LANES;

        per_pixel = (double)ttf_matching_bytes(1, rank, config->per_channel) +
                    (turns - 1) * 2.0 * stride +
                    turns * (2.0 * TTF_CELL_DIMS * TTF_CELL_LEVELS + sizeof(uint32_t)) +
                    (config->known.bytes || config->keep_factors
                         ? 2.0 * (double)ttf_matching_bytes(1, rank, config->per_channel)
                         : 0.0) +
                    (config->agreement_queries > 0 ? full_bytes_per_pixel(n) : 0.0);
    }
    bytes = per_pixel * pixels;
    return bytes < 1e18 ? (size_t)bytes : (size_t)1e18;
}

int ttf_quilt_output_frames(const struct ttf_quilt_config *config, uint32_t n, uint32_t *ret,
                            struct ttf_err *err)
{
    if (config->rate)
        return ttf_rate_map_frames(config->rate, n, ret, err);
    *ret = n;
    return 0;
}

static int validate_sizes(const struct ttf_quilt_config *config, struct ttf_err *err)
{
    if (config->width < 1 || config->width > SIDE_MAX || config->height < 1 ||
        config->height > SIDE_MAX)
        return ttf_err_set(err, -EINVAL, "size", "%u x %u is not within 1 x 1 and %u x %u pixels",
                           config->width, config->height, SIDE_MAX, SIDE_MAX);
    if (config->block_width < BLOCK_MIN || config->block_height < BLOCK_MIN)
        return ttf_err_set(err, -EINVAL, "block", "%u x %u is smaller than %u x %u pixels",
                           config->block_width, config->block_height, BLOCK_MIN, BLOCK_MIN);
    return 0;
}

static int validate_blocks(const struct ttf_quilt_config *config, const struct ttf_sequence *input,
                           struct ttf_err *err)
{
    uint32_t overlap_x, overlap_y;

    if (config->block_width > input->width || config->block_height > input->height) {
        ttf_err_set(err, -EINVAL, "block", "a block of %u x %u does not fit the input of %u x %u",
                    config->block_width, config->block_height, input->width, input->height);
        ttf_err_hint(err, "choose a block of at most the input's size, better a third of it");
        return -EINVAL;
    }
    overlap_x = ttf_placement_overlap(config->overlap_x, config->block_width);
    overlap_y = ttf_placement_overlap(config->overlap_y, config->block_height);
    if (overlap_x > config->block_width / 2 || overlap_y > config->block_height / 2)
        return ttf_err_set(err, -EINVAL, "overlap",
                           "%u x %u pixels is more than half a block of %u x %u", overlap_x,
                           overlap_y, config->block_width, config->block_height);
    if (config->feather_px > overlap_x || config->feather_px > overlap_y)
        return ttf_err_set(err, -EINVAL, "feather", "%u pixels is more than the overlap of %u x %u",
                           config->feather_px, overlap_x, overlap_y);
    return 0;
}

static int validate_rank(const struct ttf_quilt_config *config, struct ttf_err *err)
{
    bool full = config->rank == TTF_QUILT_RANK_FULL && !(config->rank_error > 0.0);

    if (config->rank > TTF_QUILT_RANK_MAX)
        return ttf_err_set(err, -EINVAL, "rank", "%u is more than %u", config->rank,
                           TTF_QUILT_RANK_MAX);
    if (!isfinite(config->rank_error) || config->rank_error < 0.0 || config->rank_error > 1.0)
        return ttf_err_set(err, -EINVAL, "rank_error", "%g is not within 0 and 1",
                           config->rank_error);
    if (full && (config->n_more > 0 || ttf_quilt_turns(config) != 1 || config->tileable ||
                 config->avoid_px > 0 || config->known.bytes)) {
        ttf_err_set(err, -EINVAL, "rank",
                    "the search over all frames takes one input as it is and does nothing more");
        ttf_err_hint(err, "give a rank for further sources, turned blocks, tileable output, "
                          "avoided repetition or known factors");
        return -EINVAL;
    }
    return 0;
}

/* What agreement.h cannot do, before anything is searched for. */
static int validate_agreement(const struct ttf_quilt_config *config, struct ttf_err *err)
{
    bool full = config->rank == TTF_QUILT_RANK_FULL && !(config->rank_error > 0.0);

    if (config->agreement_queries > 0 &&
        (full || config->n_more > 0 || ttf_quilt_turns(config) != 1 || config->tileable ||
         config->per_frame))
        return ttf_err_set(err, -EINVAL, "agreement",
                           "only a search with a rank for one map of one input, unturned and not "
                           "tileable, is compared with that over all frames");
    return 0;
}

static int validate_rates(const struct ttf_quilt_config *config, struct ttf_err *err)
{
    const struct ttf_rate_map *rate = config->rate;

    if (rate->width != config->width || rate->height != config->height)
        return ttf_err_set(err, -EINVAL, "rate map",
                           "it is of %u x %u pixels, the output of %u x %u", rate->width,
                           rate->height, config->width, config->height);
    for (size_t i = 0; i < (size_t)rate->width * rate->height; i++) {
        if (!isfinite(rate->m[i]) || rate->m[i] < 0.0f)
            return ttf_err_set(err, -EINVAL, "rate map", "%g at pixel %zu, %zu is no rate",
                               (double)rate->m[i], i % rate->width, i / rate->width);
    }
    return 0;
}

static int validate_time(const struct ttf_quilt_config *config, uint32_t frames,
                         struct ttf_err *err)
{
    if (config->jitter_frames > 1u << 20)
        return ttf_err_set(err, -EINVAL, "jitter", "%u frames are more than %u",
                           config->jitter_frames, 1u << 20);
    if (config->jitter_every < 1 || config->jitter_every > 1u << 20)
        return ttf_err_set(err, -EINVAL, "jitter_every", "%u frames are not within 1 and %u",
                           config->jitter_every, 1u << 20);
    if (config->per_frame && (config->jitter_frames > 0 || config->rate || config->n_more > 0))
        return ttf_err_set(err, -EINVAL, "per_frame",
                           "frames quilted alone have no time of their own and one source");
    if (config->per_frame && config->replay)
        return ttf_err_set(err, -EINVAL, "per_frame", "one map is not replayed frame by frame");
    if ((config->rate || config->jitter_frames > 0) && frames > TIMED_FRAMES_MAX)
        return ttf_err_set(err, -EINVAL, config->rate ? "rate map" : "jitter",
                           "times between frames are told of at most %u frames, not of %u",
                           TIMED_FRAMES_MAX, frames);
    if (config->rate)
        return validate_rates(config, err);
    return 0;
}

static int validate_tiles(const struct ttf_quilt_config *config, struct ttf_err *err)
{
    if (!config->tileable ||
        (config->width >= config->block_width && config->height >= config->block_height))
        return 0;
    ttf_err_set(err, -EINVAL, "tileable", "an output of %u x %u is smaller than a block of %u x %u",
                config->width, config->height, config->block_width, config->block_height);
    ttf_err_hint(err, "choose smaller blocks, so that the last ones can meet the first");
    return -EINVAL;
}

static int validate_memory(const struct ttf_quilt_config *config, uint32_t pixels, uint32_t frames,
                           struct ttf_err *err)
{
    size_t bytes = ttf_quilt_matching_bytes(config, pixels, frames);

    if (config->memory_bytes == 0 || config->replay || bytes <= config->memory_bytes)
        return 0;
    ttf_err_set(err, -EFBIG, NULL,
                "matching %u frames of %u pixels needs %zu MiB of memory, %zu MiB are allowed",
                frames, pixels, (bytes >> 20) + 1, config->memory_bytes >> 20);
    if (config->agreement_queries > 0)
        ttf_err_hint(err, "do without the comparison with the search over all frames, use fewer "
                          "frames, or a smaller crop");
    else
        ttf_err_hint(err, config->rank == TTF_QUILT_RANK_FULL
                              ? "give a rank, use fewer frames, or a smaller crop"
                              : "use a smaller crop, a lower rank, or a machine with more memory");
    return -EFBIG;
}

int ttf_quilt_validate(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                       struct ttf_err *err)
{
    struct ttf_sources sources;
    int r = validate_sizes(config, err);

    if (r == 0)
        r = validate_blocks(config, input, err);
    if (r < 0)
        return r;
    if (!isfinite(config->tolerance) || config->tolerance < 0.0 || config->tolerance > 10.0)
        return ttf_err_set(err, -EINVAL, "tolerance", "%g is not within 0 and 10",
                           config->tolerance);
    if ((unsigned)config->metric >= TTF_METRIC_COUNT)
        return ttf_err_set(err, -EINVAL, "metric", "there is no metric %d", (int)config->metric);
    r = validate_rank(config, err);
    if (r == 0)
        r = validate_agreement(config, err);
    if (r == 0)
        r = validate_time(config, input->n, err);
    if (r == 0)
        r = validate_tiles(config, err);
    if (r == 0)
        r = ttf_sources_of(config, input, &sources, err);
    if (r == 0)
        r = validate_memory(config, sources.pixels, config->per_frame ? 1 : input->n, err);
    return r;
}
