/* SPDX-License-Identifier: Apache-2.0 */
#include "flicker.h"

int64_t ttf_flicker_ppm(int64_t exposure_ns, int64_t period_ns, unsigned permille)
{
    int64_t lit_ns, rest_ns, most_ns, least_ns;
    double mean_ns = (double)exposure_ns * permille / 1000.0;

    if (exposure_ns <= 0 || period_ns <= 0 || permille == 0 || permille >= 1000)
        return 0;
    lit_ns = period_ns * permille / 1000;
    rest_ns = exposure_ns % period_ns;
    /* What is left of whole cycles sees the pulse as far as it fits, or the pause as far as it fits. */
    most_ns = rest_ns < lit_ns ? rest_ns : lit_ns;
    least_ns = rest_ns > period_ns - lit_ns ? rest_ns - (period_ns - lit_ns) : 0;
    return (int64_t)((double)(most_ns - least_ns) / mean_ns * 1e6 + 0.5);
}
