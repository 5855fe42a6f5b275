/* SPDX-License-Identifier: Apache-2.0 */
#include "sim_target.h"

#include <errno.h>

#include "ttf/hal/sim.h"

#define SIDE 16    /* pixels of the coarse look */
#define EVEN 1.02F /* brightest to darkest */

int sim_target_reflectance(const struct ttf_box *box, double *ret, struct ttf_err *err)
{
    float rgb[SIDE * SIDE * 3];
    float lo = 1e9F, hi = 0;
    double sum = 0;
    int r = ttf_sim_truth(box, ttf_clock_now_ns(box->clock), SIDE, SIDE, rgb, err);

    if (r < 0)
        return r;
    for (unsigned i = 0; i < TTF_COUNT_OF(rgb); i++) {
        lo = rgb[i] < lo ? rgb[i] : lo;
        hi = rgb[i] > hi ? rgb[i] : hi;
        sum += rgb[i];
    }
    if (hi > EVEN * lo) {
        ttf_err_set(err, -EINVAL, NULL, "the simulated camera looks at no even target");
        ttf_err_hint(err, "a white scene is one: set: {sim.scene.name: white} in the box's "
                          "configuration");
        return -EINVAL;
    }
    *ret = sum / (3.0 * SIDE * SIDE);
    return 0;
}
