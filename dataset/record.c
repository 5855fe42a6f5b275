/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/record.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/attr.h"

static const char *const result_names[TTF_RESULT_COUNT] = {
    [TTF_RESULT_CAPTURED] = "captured", [TTF_RESULT_PARTIAL] = "partial",
    [TTF_RESULT_MISSED] = "missed",     [TTF_RESULT_FAILED] = "failed",
    [TTF_RESULT_PAUSED] = "paused",     [TTF_RESULT_POWER] = "power",
};

const char *ttf_result_name(enum ttf_result result)
{
    return (unsigned)result < TTF_RESULT_COUNT ? result_names[result] : "unknown";
}

int ttf_result_find(const char *name)
{
    int i;

    for (i = 0; i < TTF_RESULT_COUNT; i++)
        if (strcmp(result_names[i], name) == 0)
            return i;
    return -ENOENT;
}

void ttf_slot_record_init(struct ttf_slot_record *record)
{
    memset(record, 0, sizeof(*record));
    record->middle_ns = TTF_NS_UNKNOWN;
}

static void free_images(struct ttf_slot_record *record)
{
    unsigned i;

    for (i = 0; i < record->n_images; i++)
        free(record->images[i].shots);
    free(record->images);
    record->images = NULL;
    record->n_images = 0;
}

void ttf_image_init(struct ttf_image *image)
{
    *image = (struct ttf_image){
        .bracket = -1, .mean_level = NAN, .reference_level = NAN, .sharpness = NAN};
}

int ttf_slot_record_images(struct ttf_slot_record *record, unsigned n)
{
    struct ttf_image *images = NULL;
    unsigned i;

    if (n > 0) {
        images = calloc(n, sizeof(*images));
        if (!images)
            return -ENOMEM;
    }
    for (i = 0; i < n; i++)
        ttf_image_init(&images[i]);
    free_images(record);
    record->images = images;
    record->n_images = n;
    return 0;
}

int ttf_image_shots(struct ttf_image *image, unsigned n)
{
    struct ttf_shot *shots = NULL;
    unsigned i, k;

    if (n > 0) {
        shots = calloc(n, sizeof(*shots));
        if (!shots)
            return -ENOMEM;
    }
    for (i = 0; i < n; i++) {
        shots[i].start_ns = shots[i].end_ns = TTF_NS_UNKNOWN;
        for (k = 0; k < TTF_SHOT_LAMPS_MAX; k++)
            shots[i].lamps[k].measured_permille = -1;
    }
    free(image->shots);
    image->shots = shots;
    image->n_shots = n;
    return 0;
}

void ttf_slot_record_free(struct ttf_slot_record *record)
{
    if (!record)
        return;
    free_images(record);
    ttf_slot_record_init(record);
}
