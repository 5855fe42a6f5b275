/* SPDX-License-Identifier: Apache-2.0 */
/* commands_synth.c: the words of what synthesizes. */
#include "commands_private.h"

#define PREPARE_OPTIONS                                                         \
    {OPT_STABILISE, NULL}, {OPT_DEFLICKER, NULL}, {OPT_DEFLICKER_WINDOW, NULL}, \
        {OPT_FLATTEN, NULL}, {OPT_FLATTEN_SIGMA, NULL},                         \
    {                                                                           \
        OPT_KEEP_GRADIENT, NULL                                                 \
    }

#define BLOCK_OPTIONS                                                                \
    {OPT_BLOCK, NULL}, {OPT_OVERLAP, NULL}, {OPT_FEATHER, NULL}, {OPT_MIRROR, NULL}, \
        {OPT_FLIPS, NULL}, {OPT_ROTATIONS, NULL}, {OPT_AVOID, NULL},                 \
    {                                                                                \
        OPT_SEED, NULL                                                               \
    }

#define MATCH_OPTIONS                                                                    \
    {OPT_TOLERANCE, NULL}, {OPT_METRIC, NULL}, {OPT_RANK, NULL}, {OPT_RANK_ERROR, NULL}, \
        {OPT_SVD, NULL},                                                                 \
    {                                                                                    \
        OPT_FACTORS, NULL                                                                \
    }

static const struct cli_command ROWS[] = {
    {
        .name = "synth quilt",
        .args = "INPUT",
        .summary = "synthesize a larger time-varying texture by quilting",
        .text =
            "INPUT is a dataset or a picture. Blocks are cuboids: the same spatial block for all "
            "frames, cut along one seam that is best over all of them; frames are copied, so every "
            "pixel of the output lives the life of one pixel of the input. The output is a dataset "
            "again, derived from the input, with report.json: coherence, seams, times.\n\n"
            "--rate-map, --light and --curvature let places age at different paces; the output is "
            "then as long as its fastest pixel takes.\n\n"
            "--check reads the result back and compares every pixel's life with its source's.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_synth_quilt,
        .options = {{OPT_GROUP, "Result:"},
                    {OPT_OUTPUT, "the new dataset, or the file of --sink raw"},
                    {OPT_SIZE, NULL},
                    {OPT_SINK, NULL},
                    {OPT_COMPRESS, NULL},
                    {OPT_CHECK, NULL},
                    {OPT_FIGURES, NULL},
                    {OPT_NO_FIGURES, NULL},
                    {OPT_AGREEMENT, NULL},
                    {OPT_PREVIEW, NULL},
                    {OPT_MEMORY, NULL},
                    {OPT_TIME, NULL},
                    {OPT_GROUP, "Input:"},
                    {OPT_FRAMES, "the first N frames only"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_SOURCE, NULL},
                    PREPARE_OPTIONS,
                    {OPT_GROUP, "Blocks:"},
                    BLOCK_OPTIONS,
                    {OPT_PER_FRAME, NULL},
                    {OPT_TILEABLE, NULL},
                    {OPT_SAVE_MAP, NULL},
                    {OPT_MAP, NULL},
                    {OPT_GROUP, "Matching:"},
                    MATCH_OPTIONS,
                    {OPT_GROUP, "Time:"},
                    {OPT_JITTER, NULL},
                    {OPT_JITTER_ROUNDED, NULL},
                    {OPT_JITTER_EVERY, NULL},
                    {OPT_RATE_MAP, NULL},
                    {OPT_LIGHT, NULL},
                    {OPT_NORMALS, NULL},
                    {OPT_HEIGHTS, NULL},
                    {OPT_HEIGHT_SCALE, NULL},
                    {OPT_CURVATURE, NULL},
                    {OPT_RATE_OFFSET, NULL},
                    {OPT_RATE_GAIN, NULL},
                    {OPT_GROUP, "All commands:"},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox synth quilt grass --size 1024x1024 --block 48x96 -o meadow",
                      "elongated blocks for grass"},
                     {"ttfbox synth quilt copper-ttf --size 512x512 --check -o big",
                      "and prove that it was copied"},
                     {"ttfbox synth quilt snow --rate-map logo.png --jitter 3 -o sign",
                      "snow settles later where the picture is dark"},
                     {"ttfbox synth quilt grass --preview --memory 64MiB --time 10s -o look",
                      "a first look"}},
    },
    {
        .name = "synth composite",
        .args = "PHOTO DATASET",
        .summary = "lay a photographed object and its shadow over a growing texture",
        .text =
            "PHOTO shows one object on a plain ground that is a little darker where the object's "
            "shadow falls. A texture of the photograph's size (or --size) is quilted from DATASET; "
            "where the shadow is, it ages more slowly and is darker; the object lies over it. The "
            "output is a dataset, derived from DATASET, with report.json, whose figures are of the "
            "texture before shadow and object.",
        .min_args = 2,
        .max_args = 2,
        .run = cmd_synth_composite,
        .options = {{OPT_GROUP, "Result:"},
                    {OPT_OUTPUT, "the new dataset, or the file of --sink raw"},
                    {OPT_SIZE, "the output's size in pixels (default: the photograph's)"},
                    {OPT_SINK, NULL},
                    {OPT_COMPRESS, NULL},
                    {OPT_FIGURES, NULL},
                    {OPT_NO_FIGURES, NULL},
                    {OPT_PREVIEW, NULL},
                    {OPT_MEMORY, NULL},
                    {OPT_TIME, NULL},
                    {OPT_GROUP, "Object and shadow:"},
                    {OPT_LEAST, NULL},
                    {OPT_THRESHOLD, NULL},
                    {OPT_SOFTEN, NULL},
                    {OPT_GROUP, "Input:"},
                    {OPT_FRAMES, "the first N frames only"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_SOURCE, NULL},
                    PREPARE_OPTIONS,
                    {OPT_GROUP, "Blocks:"},
                    BLOCK_OPTIONS,
                    {OPT_SAVE_MAP, NULL},
                    {OPT_GROUP, "Matching:"},
                    MATCH_OPTIONS,
                    {OPT_GROUP, "Time:"},
                    {OPT_JITTER, NULL},
                    {OPT_JITTER_ROUNDED, NULL},
                    {OPT_JITTER_EVERY, NULL},
                    {OPT_GROUP, "All commands:"},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox synth composite bench.jpg grass --block 32x64 -o bench-lawn",
                      "grass grows more slowly in the bench's shadow"}},
    },
    {
        .name = "synth rank",
        .args = "INPUT",
        .summary = "measure how well a sequence compresses, rank by rank",
        .text =
            "Writes one line for each rank k from 0: k, the error e_k (the root of what rank k "
            "misses over the root of all), and the root mean square of that, over full scale. A "
            "plot is written beside it: curve.svg beside curve.csv.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_synth_rank,
        .options = {{OPT_OUTPUT, "the table, as curve.csv"},
                    {OPT_RANK, "the last rank, 1 to 64 (default: 64)"},
                    {OPT_SVD, NULL},
                    {OPT_METRIC, NULL},
                    {OPT_FRAMES, "the first N frames only"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox synth rank grass -o curve.csv", NULL}},
    },
};

const struct cli_commands cli_commands_synth = {ROWS, TTF_COUNT_OF(ROWS)};
