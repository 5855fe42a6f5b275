/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled with -mavx2 on x86-64 (synth/CMakeLists.txt); never entered without a look at the processor. */
#include "search/kernels_vector.h"

const struct ttf_kernels *ttf_kernels_avx2(void)
{
    static const struct ttf_kernels kernels = {
        .name = "avx2",
        .ssd_u8 = ssd_u8,
        .ssd_f32 = ssd_f32,
        .add_cells = add_cells,
    };

    return &kernels;
}
