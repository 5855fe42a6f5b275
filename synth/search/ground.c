/* SPDX-License-Identifier: Apache-2.0 */
#include "search/ground.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct rows {
    struct ttf_ground *ground;
    const struct ttf_trajectories *trajectories;
    const struct ttf_kernels *kernels;
};

/* Sums along one row; those above are added afterwards. */
static void sum_row(void *ctx, unsigned y, unsigned worker)
{
    const struct rows *rows = ctx;
    const struct ttf_trajectories *trajectories = rows->trajectories;
    uint64_t *sums = rows->ground->sums + (size_t)(y + 1) * rows->ground->stride;

    (void)worker;
    sums[0] = 0;
    for (size_t x = 0; x < trajectories->width; x++) {
        const uint8_t *p = ttf_trajectory(trajectories, (size_t)y * trajectories->width + x);

        sums[x + 1] = sums[x] + rows->kernels->ssd_u8(p, rows->ground->code, trajectories->dims);
    }
}

int ttf_ground_prepare(struct ttf_ground *ground, const struct ttf_trajectories *trajectories,
                       const uint8_t *code, const struct ttf_kernels *kernels,
                       struct ttf_pool *pool)
{
    struct rows rows = {ground, trajectories, kernels};
    size_t height = trajectories->height;

    if (ground->code && memcmp(ground->code, code, trajectories->dims) == 0)
        return 0;
    if (!ground->code) {
        ground->stride = (size_t)trajectories->width + 1;
        ground->sums = malloc((height + 1) * ground->stride * sizeof(*ground->sums));
        ground->code = malloc(trajectories->dims);
        if (!ground->sums || !ground->code) {
            ttf_ground_free(ground);
            return -ENOMEM;
        }
    }
    memcpy(ground->code, code, trajectories->dims);
    memset(ground->sums, 0, ground->stride * sizeof(*ground->sums));
    ttf_pool_run(pool, trajectories->height, sum_row, &rows);
    for (size_t i = ground->stride; i < (height + 1) * ground->stride; i++)
        ground->sums[i] += ground->sums[i - ground->stride];
    return 0;
}

void ttf_ground_free(struct ttf_ground *ground)
{
    free(ground->code);
    free(ground->sums);
    memset(ground, 0, sizeof(*ground));
}
