/* SPDX-License-Identifier: Apache-2.0 */
#include "rehearsal.h"

#include <math.h>
#include <string.h>

#define CODE_MAX 65535u

void ttf_rehearsal_init(struct ttf_rehearsal *rehearsal)
{
    memset(rehearsal, 0, sizeof(*rehearsal));
    rehearsal->headroom_stops = INFINITY;
    rehearsal->sharpness = NAN;
    rehearsal->first_level = NAN;
    rehearsal->last_level = NAN;
}

/*
 * The byte of the code that n / 1000 samples at the most lie above: its high one, or, high being
 * that one (-1: not known yet), its low one. *above: samples above, counted on.
 */
static unsigned quantile_byte(const struct ttf_raw_sum *raw, size_t n, int high, size_t limit,
                              size_t *above)
{
    size_t histogram[256] = {0};
    unsigned byte = 255;

    for (size_t i = 0; i < n; i++) {
        uint32_t mean = raw->sum[i] / raw->n;

        if (mean > CODE_MAX)
            mean = CODE_MAX;
        if (high < 0)
            histogram[mean >> 8]++;
        else if (mean >> 8 == (uint32_t)high)
            histogram[mean & 255]++;
    }
    while (byte > 0 && *above + histogram[byte] <= limit)
        *above += histogram[byte--];
    return byte;
}

double ttf_raw_headroom_stops(const struct ttf_raw_sum *raw)
{
    size_t n = (size_t)raw->format.width * raw->format.height * raw->samples;
    size_t above = 0;
    unsigned high;
    unsigned low;
    uint16_t black;
    uint16_t white;
    double room;
    double level;

    ttf_raw_sum_levels(&raw->format, &black, &white);
    room = (double)white - black;
    if (raw->n == 0)
        return NAN;
    high = quantile_byte(raw, n, -1, n / 1000, &above);
    low = quantile_byte(raw, n, (int)high, n / 1000, &above);
    level = (double)(high << 8 | low) - black;
    return level < 1 ? log2(room) : level >= room ? 0 : log2(room / level);
}

static double mean_above_black(const struct ttf_raw_sum *raw)
{
    size_t n = (size_t)raw->format.width * raw->format.height * raw->samples;
    uint64_t sum = 0;
    uint16_t black;
    uint16_t white;

    ttf_raw_sum_levels(&raw->format, &black, &white);
    for (size_t i = 0; i < n; i++)
        sum += raw->sum[i];
    return (double)sum / ((double)n * raw->n) - black;
}

void ttf_rehearsal_image(struct ttf_rehearsal *rehearsal, unsigned shot,
                         const struct ttf_raw_sum *raw, const struct ttf_image *image)
{
    double stops = ttf_raw_headroom_stops(raw);

    if (stops < rehearsal->headroom_stops)
        rehearsal->headroom_stops = stops;
    if (!isnan(image->sharpness))
        rehearsal->sharpness = image->sharpness;
    if (shot == 0 && image->bracket <= 0) {
        double level =
            isnan(image->reference_level) ? mean_above_black(raw) : image->reference_level;

        if (isnan(rehearsal->first_level))
            rehearsal->first_level = level;
        rehearsal->last_level = level;
    }
}

void ttf_rehearsal_slot(struct ttf_rehearsal *rehearsal, const struct ttf_slot_record *record,
                        int64_t busy_ns, int64_t commit_ns)
{
    int64_t bytes = 0;

    for (unsigned i = 0; i < record->n_images; i++) {
        for (unsigned f = 0; f < record->images[i].n_files; f++)
            bytes += record->images[i].files[f].bytes;
    }
    if (bytes > rehearsal->slot_bytes)
        rehearsal->slot_bytes = bytes;
    if (busy_ns > rehearsal->busy_ns)
        rehearsal->busy_ns = busy_ns;
    if (commit_ns > rehearsal->commit_ns)
        rehearsal->commit_ns = commit_ns;
}
