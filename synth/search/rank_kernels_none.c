/* SPDX-License-Identifier: Apache-2.0 */
/* In the place of the x86-64 kernels on other processors. */
#include "search/factor_kernels.h"
#include "search/rank_kernels.h"

#include <stddef.h>

const struct ttf_rank_kernels *ttf_rank_kernels_avx2(void)
{
    return NULL;
}

const struct ttf_rank_kernels *ttf_rank_kernels_avx512(void)
{
    return NULL;
}

const struct ttf_factor_kernels *ttf_factor_kernels_avx2(void)
{
    return NULL;
}
