/* SPDX-License-Identifier: Apache-2.0 */
#include "calibrate_chart.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "ttf/hal/sim.h"

#define TRUTH_CELL  8 /* pixels of a patch in the look at a simulated chart; its middle ones count */
#define TRUTH_COUNT 16.0 /* of those */

int calibrate_chart_corners(struct cli *cli, const struct ttf_box *box, struct ttf_chart_view *ret)
{
    const char *text = cli->opt.corners;

    if (!text && box->simulated)
        return ttf_sim_corners(box, ret->corners);
    if (!text) {
        ttf_err_set(&cli->err, -EINVAL, "--corners",
                    "nobody says where the chart lies in the frame");
        ttf_err_hint(&cli->err, "as --corners X,Y,X,Y,X,Y,X,Y: the page's live view picks them");
        return -EINVAL;
    }
    for (int i = 0; i < 8; i++) {
        char *end;

        ret->corners[i / 2][i % 2] = strtod(text, &end);
        if (end == text || *end != (i < 7 ? ',' : '\0'))
            return ttf_err_set(&cli->err, -EINVAL, "--corners",
                               "'%s' is not eight numbers with commas between", cli->opt.corners);
        text = end + 1;
    }
    return 0;
}

/* Of a simulated chart every colour is known: means over the middles of its patches. */
static int simulated_values(struct cli *cli, const struct ttf_box *box, struct ttf_chart *ret)
{
    enum {
        WIDE = TTF_CHART_COLUMNS * TRUTH_CELL,
        HIGH = TTF_CHART_ROWS * TRUTH_CELL
    };
    float *rgb = calloc((size_t)WIDE * HIGH * 3, sizeof *rgb);
    int r = -ENOMEM;

    if (rgb)
        r = ttf_sim_truth(box, ttf_clock_now_ns(box->clock), WIDE, HIGH, rgb, &cli->err);
    for (unsigned i = 0; r == 0 && i < TTF_CHART_PATCHES; i++) {
        const unsigned x0 = i % TTF_CHART_COLUMNS * TRUTH_CELL + TRUTH_CELL / 4;
        const unsigned y0 = i / TTF_CHART_COLUMNS * TRUTH_CELL + TRUTH_CELL / 4;
        double mean[3] = {0};

        for (unsigned k = 0; k < TRUTH_CELL / 2 * (TRUTH_CELL / 2); k++) {
            const unsigned x = x0 + k % (TRUTH_CELL / 2), y = y0 + k / (TRUTH_CELL / 2);

            for (int c = 0; c < 3; c++)
                mean[c] += (double)rgb[(y * WIDE + x) * 3 + (unsigned)c] / TRUTH_COUNT;
        }
        ttf_linear_to_lab(mean, ret->lab[i]);
    }
    free(rgb);
    return r;
}

int calibrate_chart_values(struct cli *cli, const struct ttf_box *box, struct ttf_chart *ret)
{
    if (cli->opt.values)
        return ttf_chart_load(cli->io, cli->opt.values, ret, &cli->err);
    if (box->simulated)
        return simulated_values(cli, box, ret);
    ttf_chart_classic(ret);
    return 0;
}
