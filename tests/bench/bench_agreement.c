/* SPDX-License-Identifier: Apache-2.0 */
/*
 * bench_agreement: does matching in k-space choose as matching over all frames would? As JSON.
 *
 *   bench_agreement DATASET [--queries N] [--seed FIRST] [--rank K] [--size WxH] [--block WxH]
 *                   [--queries-from map|anywhere]
 *
 * Plans outputs with seeds FIRST, FIRST + 1, ... (default 1001, which nothing was tuned with) until
 * N overlap queries (default 2000) have been put to both searches. A measurement: it passes or
 * fails nothing.
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/agreement.h"
#include "ttf/synth/quilt.h"

struct bench {
    const char *path;
    unsigned queries;
    bool anywhere;
    struct ttf_quilt_config config;
    struct ttf_pool *pool;
    /* sums, weighted by queries */
    unsigned seeds, asked, jumps;
    double best, cost, jaccard, jump_best, jump_cost, error;
};

static void parse_size(const char *text, uint32_t *ret_width, uint32_t *ret_height)
{
    char *end;

    *ret_width = (uint32_t)strtoul(text, &end, 10);
    *ret_height = *end == 'x' ? (uint32_t)strtoul(end + 1, NULL, 10) : 0;
}

static int parse(struct bench *bench, int argc, char **argv)
{
    if (argc < 2 || argc % 2 != 0)
        return -1;
    bench->path = argv[1];
    for (int i = 2; i < argc; i += 2) {
        const char *value = argv[i + 1];

        if (strcmp(argv[i], "--queries") == 0)
            bench->queries = (unsigned)strtoul(value, NULL, 10);
        else if (strcmp(argv[i], "--queries-from") == 0)
            bench->anywhere = strcmp(value, "anywhere") == 0;
        else if (strcmp(argv[i], "--seed") == 0)
            bench->config.seed = strtoull(value, NULL, 10);
        else if (strcmp(argv[i], "--rank") == 0)
            bench->config.rank = (unsigned)strtoul(value, NULL, 10);
        else if (strcmp(argv[i], "--size") == 0)
            parse_size(value, &bench->config.width, &bench->config.height);
        else if (strcmp(argv[i], "--block") == 0)
            parse_size(value, &bench->config.block_width, &bench->config.block_height);
        else
            return -1;
    }
    return 0;
}

static int one_seed(struct bench *bench, struct ttf_sequence *input, struct ttf_err *err)
{
    struct ttf_agreement own;
    struct ttf_quilt_map map;
    int r = ttf_quilt_plan(&bench->config, input, bench->pool, &map, err);

    if (r < 0)
        return r;
    r = (bench->anywhere ? ttf_quilt_agreement_anywhere : ttf_quilt_agreement)(
        &bench->config, input, &map, 0, bench->pool, &own, err);
    bench->error = map.rank.error;
    ttf_quilt_map_free(&map);
    if (r < 0)
        return r;
    bench->seeds++;
    bench->config.seed++;
    bench->asked += own.queries;
    bench->jumps += own.jumps;
    bench->best += own.best * own.queries;
    bench->jaccard += own.jaccard * own.queries;
    bench->cost += own.jump_extra_cost * own.jumps;
    bench->jump_best += own.jump_best * own.jumps;
    return 0;
}

static int run(struct bench *bench, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    struct ttf_sequence *input = NULL;
    int r = ttf_reader_open(ttf_io_posix(), bench->path, &reader, err);

    if (r == 0)
        r = ttf_sequence_of_dataset(reader, NULL, &input, err);
    while (r == 0 && bench->asked < bench->queries)
        r = one_seed(bench, input, err);
    ttf_sequence_destroy(input);
    ttf_reader_close(reader);
    return r;
}

static void print(const struct bench *bench)
{
    double asked = bench->asked > 0 ? bench->asked : 1, jumps = bench->jumps > 0 ? bench->jumps : 1;
    struct ttf_json json;
    const char *text;
    size_t bytes;

    ttf_json_init(&json, true);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "dataset", bench->path);
    ttf_json_kint(&json, "rank", bench->config.rank);
    ttf_json_kdouble(&json, "error", bench->error);
    ttf_json_kstring(&json, "queries_from", bench->anywhere ? "anywhere" : "map");
    ttf_json_kint(&json, "seeds", bench->seeds);
    ttf_json_kint(&json, "queries", bench->asked);
    ttf_json_kdouble(&json, "best_block", bench->best / asked);
    ttf_json_kdouble(&json, "candidates_jaccard", bench->jaccard / asked);
    ttf_json_kint(&json, "jumps", bench->jumps);
    ttf_json_kdouble(&json, "jumps_best_block", bench->jump_best / jumps);
    ttf_json_kdouble(&json, "jumps_extra_cost", bench->cost / jumps);
    ttf_json_object_end(&json);
    if (ttf_json_finish(&json, &text, &bytes) == 0)
        fputs(text, stdout);
    ttf_json_free(&json);
}

int main(int argc, char **argv)
{
    struct bench bench = {.queries = 2000};
    struct ttf_err err = {0};
    char line[1024];
    int r;

    ttf_quilt_defaults(&bench.config);
    bench.config.seed = 1001;
    if (parse(&bench, argc, argv) < 0) {
        fprintf(stderr, "usage: bench_agreement DATASET [--queries N] [--seed FIRST] [--rank K] "
                        "[--size WxH] [--block WxH]\n");
        return 2;
    }
    bench.pool = ttf_pool_create(0);
    r = run(&bench, &err);
    ttf_pool_destroy(bench.pool);
    if (r < 0) {
        fprintf(stderr, "bench_agreement: %s\n", ttf_err_text(&err, line, sizeof(line)));
        return 1;
    }
    print(&bench);
    return 0;
}
