/* SPDX-License-Identifier: Apache-2.0 */
/* What a record must be before it may become a line. */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "manifest_rules.h"
#include "record_line.h"
#include "ttf/dataset/hash.h"

static int check_file(const struct ttf_file_ref *file, unsigned i, unsigned k, struct ttf_err *err)
{
    if (file->role[0] == '\0' || !ttf_path_ok(file->path) || file->bytes < 0 ||
        !ttf_sha256_is_hex(file->sha256))
        return ttf_err_set(
            err, -EINVAL, "slot",
            "images[%u].files[%u] needs a role, a path inside the dataset, its bytes "
            "and sha256",
            i, k);
    return 0;
}

static int check_image(const struct ttf_slot_record *record, unsigned i, struct ttf_err *err)
{
    const struct ttf_image *image = &record->images[i];
    unsigned k;
    int r;

    if (image->stream[0] == '\0')
        return ttf_err_set(err, -EINVAL, "slot", "images[%u].stream is missing", i);
    if (image->n_files > TTF_IMAGE_FILES_MAX)
        return ttf_err_set(err, -EINVAL, "slot", "images[%u] has too many files", i);
    for (k = 0; k < image->n_files; k++) {
        r = check_file(&image->files[k], i, k, err);
        if (r)
            return r;
    }
    for (k = 0; k < image->n_shots; k++)
        if (image->shots[k].n_lamps > TTF_SHOT_LAMPS_MAX)
            return ttf_err_set(err, -EINVAL, "slot", "images[%u].shots[%u] has too many lamps", i,
                               k);
    if (isinf(image->mean_level) || isinf(image->reference_level) || isinf(image->sharpness) ||
        !isfinite(image->relative_exposure))
        return ttf_err_set(err, -EINVAL, "slot", "images[%u] has an infinite level", i);
    /* A slot commits whole, or names each image it lacks. */
    if (image->n_files == 0 && image->lacking[0] == '\0')
        return ttf_err_set(err, -EINVAL, "slot",
                           "images[%u] has no files and does not say why (lacking)", i);
    if (image->lacking[0] != '\0' && record->result == TTF_RESULT_CAPTURED)
        return ttf_err_set(err, -EINVAL, "slot",
                           "images[%u] is lacking: the slot is partial, not captured", i);
    return 0;
}

int ttf_slot_check(const struct ttf_slot_record *record, struct ttf_err *err)
{
    unsigned i;
    int r;

    if (record->index < 0 || record->segment < 0)
        return ttf_err_set(err, -EINVAL, "slot", "index and segment must be 0 or more");
    if ((unsigned)record->result >= TTF_RESULT_COUNT)
        return ttf_err_set(err, -EINVAL, "slot", "result is unknown");
    if (record->result != TTF_RESULT_CAPTURED && record->reason[0] == '\0')
        return ttf_err_set(err, -EINVAL, "slot", "a %s slot needs a reason",
                           ttf_result_name(record->result));
    if (record->n_sensors > TTF_SLOT_SENSORS_MAX)
        return ttf_err_set(err, -EINVAL, "slot", "too many sensors");
    for (i = 0; i < record->n_images; i++) {
        r = check_image(record, i, err);
        if (r)
            return r;
    }
    return 0;
}

int ttf_segment_check(const struct ttf_segment *s, struct ttf_err *err)
{
    static const char *const trusts[] = {"", "rtc", "ntp", "host", "none"};
    bool known = false;
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(trusts); i++)
        known = known || strcmp(trusts[i], s->trust) == 0;
    if (!known)
        return ttf_err_set(err, -EINVAL, "segment", "trust must be rtc, ntp, host or none");
    if (s->segment < 0 || s->first_index < 0 || s->interval_ns < 0)
        return ttf_err_set(err, -EINVAL, "segment",
                           "segment, first_index and interval_ns must be 0 or more");
    if (s->gap_ns < 0 && s->gap_ns != TTF_NS_UNKNOWN)
        return ttf_err_set(err, -EINVAL, "segment", "gap_ns must be 0 or more");
    return 0;
}
