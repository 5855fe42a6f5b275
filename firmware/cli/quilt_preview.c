/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_preview.c: see quilt_preview.h. */
#include "quilt_preview.h"

#include <errno.h>
#include <stdlib.h>

#include "quilt_options.h"

/*
 * What work costs one thread of a small machine, in nanoseconds: stated, not measured, and on the safe
 * side. The search's is for positions that a first look excludes, as nearly all are.
 */
#define POSITION_NS 40.0 /* one position of one block */
#define LEARN_NS    2.5  /* one number of one pixel of one frame, in the compression */
#define COMPOSE_NS  30.0 /* one output pixel of one frame: copied, measured, written */
#define SAMPLE_NS   20.0 /* one input pixel of one frame on its way through preparation */

/* The program itself and what reading a file takes. */
#define BASE_BYTES ((size_t)14 << 20)
#define WINDOW_BYTES \
    ((size_t)64 << 20) /* source frames held where pixels have times of their own */

#define SHRINK_MAX 64u
#define FRAMES_MIN 8u /* fewer show no evolution */

struct estimate {
    const struct cli_options *options;
    const struct quilt_input *inputs;
    unsigned n_inputs;
    const struct ttf_quilt_config *config;
    bool timed;
    int64_t read_ns;
};

static uint64_t pixels_of(const struct estimate *e, uint32_t shrink)
{
    uint64_t sum = 0;

    for (unsigned i = 0; i < e->n_inputs; i++) {
        const struct ttf_sequence *input = quilt_input_top(&e->inputs[i]);

        sum += (uint64_t)(input->width / shrink) * (input->height / shrink);
    }
    return sum;
}

/* The configuration that a run with this shrink would have. */
static struct ttf_quilt_config shrunk(const struct estimate *e, uint32_t shrink)
{
    const struct ttf_sequence *first = quilt_input_top(&e->inputs[0]);
    struct ttf_quilt_config config = *e->config;

    if (config.width == 0) {
        config.width = 2 * first->width;
        config.height = 2 * first->height;
    }
    quilt_config_shrink(&config, shrink);
    return config;
}

static size_t bytes_of(const struct estimate *e, uint32_t shrink, uint32_t step)
{
    const struct ttf_sequence *first = quilt_input_top(&e->inputs[0]);
    struct ttf_quilt_config c = shrunk(e, shrink);
    uint64_t in = pixels_of(e, shrink), whole = pixels_of(e, 1);
    uint64_t out = (uint64_t)c.width * c.height;
    uint32_t n = (first->n - 1) / step + 1;
    uint64_t bytes = BASE_BYTES + ttf_quilt_matching_bytes(&c, (uint32_t)in, n);

    bytes += 3 * 6 * (in + out); /* three frames in work */
    bytes += 16 * 3 * in;        /* a batch that is factored */
    bytes += 2 * 6 * whole;      /* frames as they are read */
    bytes += 12 * out;           /* the map, and what its making takes */
    bytes += c.measure ? 40 * out + 12 * in : 0;
    bytes += e->options->flatten ? 24 * in : 0;
    bytes += e->options->keep_gradient ? 12 * out : 0;
    bytes += e->options->stabilise ? 48 * in : 0;
    if (e->timed || c.jitter_frames) {
        uint64_t frames = 6 * in * (n + 1);

        bytes += (frames < WINDOW_BYTES ? frames : WINDOW_BYTES) + 10 * out;
    }
    return (size_t)bytes;
}

static uint32_t blocks_of(uint32_t size, uint32_t block)
{
    uint32_t side = block < 4 ? 4 : block; /* smaller ones are refused later */
    uint32_t step = side - (side / 6 > 2 ? side / 6 : 2);

    return size / step + 1;
}

static double time_of(const struct estimate *e, uint32_t shrink, uint32_t step)
{
    const struct ttf_sequence *first = quilt_input_top(&e->inputs[0]);
    const struct cli_options *o = e->options;
    struct ttf_quilt_config c = shrunk(e, shrink);
    double in = (double)pixels_of(e, shrink), out = (double)c.width * c.height;
    uint32_t frames = (first->n - 1) / step + 1;
    double n = frames, passes = 2 + o->stabilise + o->deflicker;
    double blocks = (double)blocks_of(c.width, c.block_width) * blocks_of(c.height, c.block_height);
    double turns = __builtin_popcount(ttf_quilt_turns(&c));
    double numbers = c.rank_error > 0 ? TTF_QUILT_RANK_MAX : c.rank ? c.rank : 3 * n;
    double ns = (double)e->read_ns * (passes * n + (o->flatten ? 16 : 0));

    ns += blocks * in * turns * POSITION_NS * (c.per_frame ? n : 1);
    ns += n * in * numbers * LEARN_NS;
    ns += n * out * COMPOSE_NS;
    ns += n * in * SAMPLE_NS * (passes - 1);
    return ns;
}

static bool is_possible(const struct estimate *e, uint32_t shrink)
{
    const struct ttf_quilt_config c = shrunk(e, shrink);

    if (shrink == 1) /* what does not fit by itself has words of its own */
        return true;
    for (unsigned i = 0; i < e->n_inputs; i++) {
        const struct ttf_sequence *input = quilt_input_top(&e->inputs[i]);

        if (input->width / shrink < c.block_width || input->height / shrink < c.block_height ||
            input->width / shrink < 16 || input->height / shrink < 16)
            return false;
    }
    return true;
}

/* Is a better than b? Within the time, what keeps more of the input; beyond it, what is faster. */
static bool is_better(const struct quilt_preview *a, const struct quilt_preview *b,
                      int64_t limit_ns)
{
    bool fits = a->total_ns <= limit_ns;

    if (b->step == 0)
        return true;
    if (fits != (b->total_ns <= limit_ns))
        return fits;
    return fits ? (uint64_t)a->shrink * a->shrink * a->step <
                      (uint64_t)b->shrink * b->shrink * b->step
                : a->total_ns < b->total_ns;
}

static int choose(struct cli *cli, const struct estimate *e, struct quilt_preview *ret)
{
    uint32_t n = quilt_input_top(&e->inputs[0])->n, least = n < FRAMES_MIN ? n : FRAMES_MIN;
    struct quilt_preview best = {0};

    for (uint32_t shrink = 1; shrink <= SHRINK_MAX && is_possible(e, shrink); shrink++) {
        for (uint32_t step = 1; (n - 1) / step + 1 >= least && step <= n; step++) {
            struct quilt_preview one = {shrink, step, bytes_of(e, shrink, step),
                                        (int64_t)time_of(e, shrink, step), e->read_ns};

            if (one.bytes <= e->config->memory_bytes && is_better(&one, &best, cli->opt.time_ns))
                best = one;
        }
    }
    if (best.step == 0) {
        ttf_err_set(&cli->err, -EFBIG, "--memory", "no preview of this input fits into %zu MiB",
                    e->config->memory_bytes >> 20);
        return ttf_err_hint(&cli->err, "give more, or smaller blocks or a smaller --size"), -EFBIG;
    }
    *ret = best;
    return 0;
}

/* A frame from the beginning, the middle and the end, whole. */
static int read_three(struct cli *cli, struct ttf_sequence *input)
{
    uint16_t *row = malloc((size_t)input->width * 6);
    int r = 0;

    if (!row)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t t = (uint32_t)((uint64_t)(input->n - 1) * k / 2);

        for (uint32_t y = 0; y < input->height && r == 0; y++)
            r = ttf_sequence_read_rows(input, t, y, 1, row, &cli->err);
    }
    free(row);
    return r;
}

int quilt_preview_choose(struct cli *cli, struct ttf_clock *clock, const struct quilt_input *inputs,
                         unsigned n, const struct ttf_quilt_config *config, bool timed,
                         struct quilt_preview *ret)
{
    struct estimate e = {&cli->opt, inputs, n, config, timed, 0};
    int64_t start_ns = cli_now_ns(clock);
    int r = 0;

    for (unsigned i = 0; i < n && r == 0; i++)
        r = read_three(cli, quilt_input_top(&inputs[i]));
    e.read_ns = (cli_now_ns(clock) - start_ns) / 3;
    return r < 0 ? r : choose(cli, &e, ret);
}
