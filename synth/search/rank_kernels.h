/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rank_kernels.h: the inner loops of matching in k-space, behind a table: a scalar
 * reference and faster versions. All come to the same: sums are of integers, and the
 * one loop of floats adds each number's terms in the same order everywhere.
 */
#ifndef TTF_SYNTH_SEARCH_RANK_KERNELS_H
#define TTF_SYNTH_SEARCH_RANK_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#define TTF_COEF_MAX   4090        /* of a coefficient's absolute value, quantised */
#define TTF_COEF_LANES 16          /* coefficients of a pixel are padded to a multiple of these */
#define TTF_CELL_MAX   1023        /* of a cell's values */
#define TTF_CELL_DIMS  16          /* values of a cell */
#define TTF_CELLS_MAX  512         /* of an overlap */
#define TTF_ROW_PLACES 16          /* neighbours that are compared at once */
#define TTF_BOUND_MAX  0x7fffffffu /* sums are clipped to this */

/* What a cell of the overlap is to look like, and where it lies from the block's corner, in cells of the view. */
struct ttf_cell_target {
    int16_t value[TTF_CELL_DIMS];
    uint32_t offset;
};

struct ttf_rank_kernels {
    const char *name;
    /* Sum of squared differences; n a multiple of TTF_COEF_LANES, values within TTF_COEF_MAX. */
    uint64_t (*ssd_i16)(const int16_t *a, const int16_t *b, size_t n);
    /*
     * Of four places at once, into ret: sum over n vectors of TTF_COEF_LANES numbers of squared differences, vector i
     * of a place lying offsets[i] vectors from it on. Done when all four are beyond `limit`, with any larger numbers.
     */
    void (*ssd_at4)(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b, size_t n,
                    uint64_t limit, uint64_t ret[4]);
    /* The same at four pairs of neighbours: of a[k] into ret[2 k], of the place one vector further on into ret[2 k + 1]. */
    void (*ssd_at_pairs)(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b,
                         size_t n, uint64_t limit, uint64_t ret[8]);
    /*
     * The same at sixteen neighbours, a[16 k] on into ret[k], of values within TTF_CELL_MAX. Meant for offsets that go on by two, as those of cells of two pixels do: what lies at
     * a place is then read once for all of the vectors that meet it.
     */
    void (*ssd_at_row)(const int16_t *a, const uint32_t *offsets, const int16_t *b, size_t n,
                       uint64_t limit, uint64_t ret[TTF_ROW_PLACES]);
    /*
     * Of n neighbouring positions: sum over cells of squared differences, clipped at TTF_BOUND_MAX. cells: the view's values
     * from the first position's corner on. Of a position beyond `limit`, any number beyond it.
     * At most TTF_CELLS_MAX targets, values within TTF_CELL_MAX.
     */
    void (*bound_cells)(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, size_t n, uint32_t limit, uint32_t *bounds);
    /*
     * out[p][r] = sum over i, ascending, of in[p][i] * w[i][r] for 4 pixels p. room: a
     * multiple of 8. in: 4 rows of in_stride floats; out: 4 rows of room floats.
     */
    void (*rotate4)(const float *w, size_t dims, size_t room, const float *in, size_t in_stride,
                    float *out);
};

/* The four places of two pairs, for kernels that have no vector as wide as a pair. */
static inline void ttf_places_of_pairs(const int16_t *const pairs[2], const int16_t *ret[4])
{
    for (int k = 0; k < 4; k++)
        ret[k] = pairs[k / 2] + (k % 2) * TTF_COEF_LANES;
}

typedef void ttf_rank_pairs_fn(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b,
                               size_t n, uint64_t limit, uint64_t ret[8]);

/* A row by pairs, for kernels that do not go through it as a whole. */
static inline void ttf_row_by_pairs(ttf_rank_pairs_fn *ssd_at_pairs, const int16_t *a,
                                    const uint32_t *offsets, const int16_t *b, size_t n,
                                    uint64_t limit, uint64_t ret[TTF_ROW_PLACES])
{
    for (size_t half = 0; half < 2; half++) {
        const int16_t *pairs[4];

        for (size_t k = 0; k < 4; k++)
            pairs[k] = a + (8 * half + 2 * k) * TTF_COEF_LANES;
        ssd_at_pairs(pairs, offsets, b, n, limit, ret + 8 * half);
    }
}

/* The reference. */
const struct ttf_rank_kernels *ttf_rank_kernels_scalar(void);

/* The fastest that this processor runs. */
const struct ttf_rank_kernels *ttf_rank_kernels_best(void);

/* NULL where they are not built or the processor lacks them. */
const struct ttf_rank_kernels *ttf_rank_kernels_avx2(void);
const struct ttf_rank_kernels *ttf_rank_kernels_avx512(void);

#endif
