/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "quilt/placement.h"
#include "search/features.h"
#include "ttf/synth/quilt.h"

#define SIDE_MAX  32768u
#define BLOCK_MIN 4u

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
                                        .metric = TTF_METRIC_DISPLAY};
}

size_t ttf_quilt_matching_bytes(uint32_t width, uint32_t height, uint32_t n)
{
    /* trajectories, features, and 24 bytes of search workspace per position */
    double per_pixel = 3.0 * n + (double)ttf_features_bytes_per_pixel(n) + 24.0;
    double bytes = per_pixel * width * height;

    return bytes < 1e18 ? (size_t)bytes : (size_t)1e18;
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

int ttf_quilt_validate(const struct ttf_quilt_config *config, const struct ttf_sequence *input,
                       struct ttf_err *err)
{
    uint32_t frames = config->per_frame ? 1 : input->n;
    size_t bytes = ttf_quilt_matching_bytes(input->width, input->height, frames);
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
    if ((uint64_t)input->width * input->height > UINT32_MAX / 2)
        return ttf_err_set(err, -EINVAL, NULL, "an input of %u x %u pixels is too large",
                           input->width, input->height);
    if (config->memory_bytes > 0 && bytes > config->memory_bytes) {
        ttf_err_set(err, -EFBIG, NULL,
                    "matching %u frames of %u x %u needs %zu MiB of memory, %zu MiB are allowed",
                    frames, input->width, input->height, (bytes >> 20) + 1,
                    config->memory_bytes >> 20);
        ttf_err_hint(err, "use fewer frames, a smaller crop, or a machine with more memory");
        return -EFBIG;
    }
    return 0;
}
