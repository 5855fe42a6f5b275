/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prepare/autocorrelation.h"
#include "prepare/derived.h"
#include "ttf/synth/prepare.h"

#define FRAMES_MOST 8u
#define LINES_MOST  128u /* of a frame and an axis: more say little more */
#define LEAST_BLOCK 24u
#define BLOCK_STEP  8u
#define LENGTHS     8.0 /* correlation lengths in a block */
#define PERIODS     1.5

struct study {
    struct ttf_sequence *input;
    uint8_t *display; /* 65536 */
    float *picture;   /* height x width */
    float *line;      /* a column */
    struct autocorrelation x, y;
};

static int load(struct study *study, uint32_t t, struct ttf_err *err)
{
    struct ttf_sequence *input = study->input;
    uint16_t *codes = malloc((size_t)input->width * 3 * STRIP_ROWS * sizeof(*codes));
    float *to = study->picture;
    int code = 0;

    if (!codes)
        return ttf_err_set(err, -ENOMEM, "feature size", "no memory for rows of %u pixels",
                           input->width);
    for (uint32_t y = 0; y < input->height && !code; y += STRIP_ROWS) {
        uint32_t rows = strip_rows(input->height, y);
        const uint16_t *at = codes;

        code = ttf_sequence_read_rows(input, t, y, rows, codes, err);
        for (size_t i = 0; i < (size_t)rows * input->width && !code; i++, at += 3)
            *to++ = ttf_luminance((float)study->display[at[0]], (float)study->display[at[1]],
                                  (float)study->display[at[2]]);
    }
    free(codes);
    return code;
}

/* On a whole grid, centred x and y are orthogonal to each other: three sums fit the plane. */
static void take_off_plane(float *picture, uint32_t width, uint32_t height)
{
    double cx = (width - 1) / 2.0, cy = (height - 1) / 2.0, pixels = (double)width * height;
    double sum = 0.0, along_x = 0.0, along_y = 0.0;
    double xx = pixels * ((double)width * width - 1) / 12.0;
    double yy = pixels * ((double)height * height - 1) / 12.0;

    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            double v = (double)picture[(size_t)y * width + x];

            sum += v;
            along_x += v * (x - cx);
            along_y += v * (y - cy);
        }
    }
    along_x = width > 1 ? along_x / xx : 0.0;
    along_y = height > 1 ? along_y / yy : 0.0;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++)
            picture[(size_t)y * width + x] -=
                (float)(sum / pixels + along_x * (x - cx) + along_y * (y - cy));
    }
}

/* Lines spread evenly over the picture. */
static void add_picture(struct study *study)
{
    uint32_t width = study->input->width, height = study->input->height;
    uint32_t rows = height < LINES_MOST ? height : LINES_MOST;
    uint32_t columns = width < LINES_MOST ? width : LINES_MOST;

    for (uint32_t i = 0; i < rows; i++)
        ttf_autocorrelation_add(&study->x,
                                study->picture + (size_t)((uint64_t)i * height / rows) * width);
    for (uint32_t i = 0; i < columns; i++) {
        const float *from = study->picture + (uint64_t)i * width / columns;

        for (uint32_t y = 0; y < height; y++)
            study->line[y] = from[(size_t)y * width];
        ttf_autocorrelation_add(&study->y, study->line);
    }
}

/* The last tenth of the frames, at most 8 of them, evenly, the very last among them. */
static int add_late_frames(struct study *study, struct ttf_err *err)
{
    uint32_t n = study->input->n, late = (n + 9) / 10;
    uint32_t taken = late < FRAMES_MOST ? late : FRAMES_MOST;
    int code = 0;

    for (uint32_t i = 0; i < taken && !code; i++) {
        code = load(study, n - 1 - (uint32_t)((uint64_t)i * late / taken), err);
        if (code)
            break;
        take_off_plane(study->picture, study->input->width, study->input->height);
        add_picture(study);
    }
    return code;
}

static uint32_t block_side(double length_px, double period_px, uint32_t side)
{
    double wanted = fmax(LENGTHS * length_px, PERIODS * period_px);
    uint32_t most = side / 3 / BLOCK_STEP * BLOCK_STEP;
    uint32_t block;

    if (most < LEAST_BLOCK)
        return side < LEAST_BLOCK ? side : LEAST_BLOCK;
    if (wanted >= most)
        return most;
    block = (uint32_t)(wanted / BLOCK_STEP + 0.5) * BLOCK_STEP;
    return block < LEAST_BLOCK ? LEAST_BLOCK : block;
}

static void conclude(struct study *study, struct ttf_feature_size *ret)
{
    struct ttf_feature_size size = {0};

    ttf_autocorrelation_find(&study->x, &size.correlation_x_px, &size.period_x_px);
    ttf_autocorrelation_find(&study->y, &size.correlation_y_px, &size.period_y_px);
    size.block_width = block_side(size.correlation_x_px, size.period_x_px, study->input->width);
    size.block_height = block_side(size.correlation_y_px, size.period_y_px, study->input->height);
    *ret = size;
}

int ttf_feature_size_find(struct ttf_sequence *input, struct ttf_feature_size *ret,
                          struct ttf_err *err)
{
    struct study study = {.input = input};
    int code = 0;

    study.display = malloc(65536);
    study.picture = calloc((size_t)input->width * input->height, sizeof(float));
    study.line = calloc(input->height, sizeof(float));
    if (!study.display || !study.picture || !study.line ||
        ttf_autocorrelation_create(input->width, &study.x) < 0 ||
        ttf_autocorrelation_create(input->height, &study.y) < 0)
        code = ttf_err_set(err, -ENOMEM, "feature size", "no memory for a picture of %u x %u",
                           input->width, input->height);
    if (!code) {
        ttf_display8_table(&input->encoding, study.display);
        code = add_late_frames(&study, err);
    }
    if (!code)
        conclude(&study, ret);
    ttf_autocorrelation_free(&study.x);
    ttf_autocorrelation_free(&study.y);
    free(study.display);
    free(study.picture);
    free(study.line);
    return code;
}
