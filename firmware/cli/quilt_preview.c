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
#define TIMED_NS    30.0 /* the same again, where pixels have times of their own: of two frames */
#define FULL_NS     1.0  /* one position of one frame, in a search over all frames */
#define SAMPLE_NS   20.0 /* one input pixel of one frame on its way through preparation */

/* The program itself and what reading a file takes. */
#define BASE_BYTES ((size_t)14 << 20)
#define WINDOW_BYTES \
    ((size_t)64 << 20) /* source frames held where pixels have times of their own */

#define SHRINK_MAX     64u
#define FRAMES_MIN     8u         /* fewer show no evolution */
#define FRAMES_OUT_MAX (1u << 20) /* a rate map allows no more: what passes them is refused later */

/* The pace of an output depends on its size, its size on the pace: so often it is asked anew. */
#define ROUNDS 8

struct estimate {
    const struct cli_options *options;
    const struct quilt_preview_ask *ask;
    float fastest;
    int64_t read_ns;
};

static uint64_t pixels_of(const struct estimate *e, uint32_t shrink)
{
    uint64_t sum = 0;

    for (unsigned i = 0; i < e->ask->n_inputs; i++) {
        const struct ttf_sequence *input = quilt_input_top(&e->ask->inputs[i]);

        sum += (uint64_t)(input->width / shrink) * (input->height / shrink);
    }
    return sum;
}

/* The configuration that a run with this shrink and step would have. */
static struct ttf_quilt_config reduced(const struct estimate *e, uint32_t shrink, uint32_t step)
{
    const struct ttf_sequence *first = quilt_input_top(&e->ask->inputs[0]);
    struct ttf_quilt_config config = *e->ask->config;

    if (config.width == 0) {
        config.width = 2 * first->width;
        config.height = 2 * first->height;
    }
    quilt_config_reduce(&config, shrink, step);
    return config;
}

static bool is_timed(const struct estimate *e, const struct ttf_quilt_config *c)
{
    return e->ask->timed || c->jitter_frames > 0;
}

static size_t bytes_of(const struct estimate *e, uint32_t shrink, uint32_t step)
{
    const struct ttf_sequence *first = quilt_input_top(&e->ask->inputs[0]);
    struct ttf_quilt_config c = reduced(e, shrink, step);
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
    if (is_timed(e, &c)) {
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

/* Frames that n of the input become at the pace of the fastest pixel. */
static uint32_t frames_out(const struct estimate *e, uint32_t n)
{
    float fastest = e->fastest;
    const struct ttf_rate_map one = {1, 1, &fastest};
    uint32_t frames;

    return ttf_rate_map_frames(&one, n, &frames, NULL) < 0 ? FRAMES_OUT_MAX : frames;
}

static double time_of(const struct estimate *e, uint32_t shrink, uint32_t step)
{
    const struct ttf_sequence *first = quilt_input_top(&e->ask->inputs[0]);
    const struct cli_options *o = e->options;
    struct ttf_quilt_config c = reduced(e, shrink, step);
    double in = (double)pixels_of(e, shrink), out = (double)c.width * c.height;
    uint32_t frames = (first->n - 1) / step + 1;
    double n = frames, passes = 2 + o->stabilise + o->deflicker;
    double blocks = (double)blocks_of(c.width, c.block_width) * blocks_of(c.height, c.block_height);
    double turns = __builtin_popcount(ttf_quilt_turns(&c));
    double numbers = c.rank_error > 0 ? TTF_QUILT_RANK_MAX : c.rank ? c.rank : 3 * n;
    double ns = (double)e->read_ns * (passes * n + (o->flatten ? 16 : 0));

    ns += blocks * in * turns * POSITION_NS * (c.per_frame ? n : 1);
    ns += n * in * numbers * LEARN_NS;
    ns += frames_out(e, frames) * out * (COMPOSE_NS + (is_timed(e, &c) ? TIMED_NS : 0));
    ns += n * in * SAMPLE_NS * (passes - 1);
    if (c.agreement_queries > 0) {
        double queries = c.agreement_queries < blocks ? c.agreement_queries : blocks;

        ns += 2 * n * ((double)e->read_ns + in * SAMPLE_NS) + n * in * numbers * LEARN_NS;
        ns += queries * n * in * FULL_NS;
    }
    return ns;
}

static bool is_possible(const struct estimate *e, uint32_t shrink)
{
    const struct ttf_quilt_config c = reduced(e, shrink, 1);

    if (shrink == 1) /* what does not fit by itself has words of its own */
        return true;
    for (unsigned i = 0; i < e->ask->n_inputs; i++) {
        const struct ttf_sequence *input = quilt_input_top(&e->ask->inputs[i]);

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

static struct quilt_preview estimated(const struct estimate *e, uint32_t shrink, uint32_t step)
{
    return (struct quilt_preview){shrink, step, bytes_of(e, shrink, step),
                                  (int64_t)time_of(e, shrink, step), e->read_ns};
}

/* What was chosen once, and factors are kept of: if it still stays within memory and time. */
static bool is_kept(struct cli *cli, const struct estimate *e, struct quilt_preview *ret)
{
    const struct quilt_preview_ask *ask = e->ask;

    if (ask->keep_shrink == 0 || ask->keep_step == 0 || ask->keep_shrink > SHRINK_MAX ||
        ask->keep_step > quilt_input_top(&ask->inputs[0])->n || !is_possible(e, ask->keep_shrink))
        return false;
    *ret = estimated(e, ask->keep_shrink, ask->keep_step);
    return ret->bytes <= ask->config->memory_bytes && ret->total_ns <= cli->opt.time_ns;
}

static int choose(struct cli *cli, const struct estimate *e, struct quilt_preview *ret)
{
    uint32_t n = quilt_input_top(&e->ask->inputs[0])->n, least = n < FRAMES_MIN ? n : FRAMES_MIN;
    struct quilt_preview best = {0};

    if (is_kept(cli, e, ret))
        return 0;
    for (uint32_t shrink = 1; shrink <= SHRINK_MAX && is_possible(e, shrink); shrink++) {
        for (uint32_t step = 1; (n - 1) / step + 1 >= least && step <= n; step++) {
            struct quilt_preview one = estimated(e, shrink, step);

            if (one.bytes <= e->ask->config->memory_bytes &&
                is_better(&one, &best, cli->opt.time_ns))
                best = one;
        }
    }
    if (best.step == 0) {
        ttf_err_set(&cli->err, -EFBIG, "--memory", "no preview of this input fits into %zu MiB",
                    e->ask->config->memory_bytes >> 20);
        return ttf_err_hint(&cli->err, "give more, or smaller blocks or a smaller --size"), -EFBIG;
    }
    *ret = best;
    return 0;
}

/* The pace of an output's fastest pixel at this shrink. */
static int find_fastest(const struct estimate *e, uint32_t shrink, float *ret)
{
    struct ttf_quilt_config c = reduced(e, shrink, 1);

    return e->ask->fastest(e->ask->ctx, c.width, c.height, ret);
}

/*
 * A smaller map's fastest pixel is an average, and its output longer: until what is chosen was told so.
 * The first round is told 1: a map of the whole output's size might not fit the memory.
 */
static int choose_paced(struct cli *cli, struct estimate *e, struct quilt_preview *ret)
{
    struct quilt_preview chosen = {0};
    float fastest = 1;
    int r = 0;

    for (int i = 0; i < ROUNDS && r == 0; i++) {
        e->fastest = fastest;
        r = choose(cli, e, &chosen);
        if (r == 0)
            r = find_fastest(e, chosen.shrink, &fastest);
        if (i > 0 && fastest >= e->fastest)
            break;
    }
    if (r < 0)
        return r;
    e->fastest = fastest;
    chosen.total_ns = (int64_t)time_of(e, chosen.shrink, chosen.step);
    *ret = chosen;
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

int quilt_preview_choose(struct cli *cli, struct ttf_clock *clock,
                         const struct quilt_preview_ask *ask, struct quilt_preview *ret)
{
    struct estimate e = {&cli->opt, ask, 1, 0};
    int64_t start_ns = cli_now_ns(clock);
    int r = 0;

    for (unsigned i = 0; i < ask->n_inputs && r == 0; i++)
        r = read_three(cli, quilt_input_top(&ask->inputs[i]));
    e.read_ns = (cli_now_ns(clock) - start_ns) / 3;
    if (r < 0)
        return r;
    return ask->fastest ? choose_paced(cli, &e, ret) : choose(cli, &e, ret);
}
