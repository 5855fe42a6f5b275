/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "record_line.h"
#include "ttf/dataset/writer.h"

static void put_text(struct ttf_json *json, const char *key, const char *value)
{
    if (value[0] != '\0')
        ttf_json_kstring(json, key, value);
}

static void put_instant(struct ttf_json *json, const char *key, int64_t value)
{
    if (value != TTF_NS_UNKNOWN)
        ttf_json_kint(json, key, value);
}

static void put_level(struct ttf_json *json, const char *key, double value)
{
    if (!isnan(value))
        ttf_json_kdouble(json, key, value);
}

static void put_control(struct ttf_json *json, const char *key, uint32_t value)
{
    if (value != 0) /* a camera without this control */
        ttf_json_kint(json, key, value);
}

static void put_exposure(struct ttf_json *json, const char *key, const struct ttf_exposure *e)
{
    if (e->exposure_ns == 0)
        return;
    ttf_json_key(json, key);
    ttf_json_object(json);
    ttf_json_kint(json, "exposure_ns", e->exposure_ns);
    put_control(json, "gain_milli", e->gain_milli);
    put_control(json, "wb_r_milli", e->wb_r_milli);
    put_control(json, "wb_b_milli", e->wb_b_milli);
    put_control(json, "lens_mdpt", e->lens_mdpt);
    ttf_json_object_end(json);
}

static void put_shot(struct ttf_json *json, const struct ttf_shot *shot)
{
    unsigned i;

    ttf_json_object(json);
    put_exposure(json, "asked", &shot->asked);
    put_exposure(json, "granted", &shot->granted);
    put_instant(json, "start_ns", shot->start_ns);
    put_instant(json, "end_ns", shot->end_ns);
    put_text(json, "refused", shot->refused);
    if (shot->n_lamps > 0) {
        ttf_json_key(json, "lamps");
        ttf_json_array(json);
        for (i = 0; i < shot->n_lamps; i++) {
            ttf_json_object(json);
            ttf_json_kstring(json, "name", shot->lamps[i].name);
            ttf_json_kint(json, "commanded_permille", shot->lamps[i].commanded_permille);
            if (shot->lamps[i].measured_permille >= 0)
                ttf_json_kint(json, "measured_permille", shot->lamps[i].measured_permille);
            ttf_json_object_end(json);
        }
        ttf_json_array_end(json);
    }
    ttf_json_object_end(json);
}

/* "a,b" as ["a","b"]; blanks around words and empty words fall away. */
static void put_flags(struct ttf_json *json, const char *flags)
{
    char word[sizeof(((struct ttf_image *)0)->flags)];
    size_t n;

    if (flags[strspn(flags, ", ")] == '\0')
        return;
    ttf_json_key(json, "flags");
    ttf_json_array(json);
    for (;;) {
        flags += strspn(flags, ", ");
        n = strcspn(flags, ",");
        if (n == 0)
            break;
        memcpy(word, flags, n);
        flags += n;
        while (word[n - 1] == ' ')
            n--;
        word[n] = '\0';
        ttf_json_string(json, word);
    }
    ttf_json_array_end(json);
}

static void put_files(struct ttf_json *json, const struct ttf_image *image)
{
    unsigned i;

    if (image->n_files == 0)
        return;
    ttf_json_key(json, "files");
    ttf_json_array(json);
    for (i = 0; i < image->n_files; i++) {
        ttf_json_object(json);
        ttf_json_kstring(json, "role", image->files[i].role);
        ttf_json_kstring(json, "path", image->files[i].path);
        ttf_json_kint(json, "bytes", image->files[i].bytes);
        ttf_json_kstring(json, "sha256", image->files[i].sha256);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

static void put_image(struct ttf_json *json, const struct ttf_image *image)
{
    unsigned i;

    ttf_json_object(json);
    ttf_json_kstring(json, "stream", image->stream);
    if (image->bracket >= 0) {
        ttf_json_key(json, "bracket");
        ttf_json_object(json);
        ttf_json_kint(json, "index", image->bracket);
        if (image->relative_exposure > 0)
            ttf_json_kdouble(json, "relative_exposure", image->relative_exposure);
        ttf_json_object_end(json);
    }
    put_text(json, "lacking", image->lacking);
    if (image->n_shots > 0) {
        ttf_json_key(json, "shots");
        ttf_json_array(json);
        for (i = 0; i < image->n_shots; i++)
            put_shot(json, &image->shots[i]);
        ttf_json_array_end(json);
    }
    if (image->n_averaged > 0)
        ttf_json_kint(json, "n_averaged", image->n_averaged);
    put_text(json, "calibration", image->calibration);
    put_files(json, image);
    put_level(json, "mean_level", image->mean_level);
    put_level(json, "reference_level", image->reference_level);
    put_level(json, "sharpness", image->sharpness);
    put_flags(json, image->flags);
    ttf_json_object_end(json);
}

static void put_sensors(struct ttf_json *json, const struct ttf_slot_record *record)
{
    const struct ttf_slot_sensor *s;

    if (record->n_sensors == 0)
        return;
    ttf_json_key(json, "sensors");
    ttf_json_array(json);
    for (s = record->sensors; s < record->sensors + record->n_sensors; s++) {
        ttf_json_object(json);
        ttf_json_kstring(json, "name", s->name);
        ttf_json_kstring(json, "kind", s->kind);
        ttf_json_kbool(json, "ok", s->ok);
        if (s->ok)
            ttf_json_kint(json, "value", s->value);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

void ttf_slot_put(struct ttf_json *json, const struct ttf_slot_record *record)
{
    unsigned i;

    ttf_json_kint(json, "index", record->index);
    ttf_json_kint(json, "segment", record->segment);
    ttf_json_kint(json, "due_ns", record->due_ns);
    put_instant(json, "middle_ns", record->middle_ns);
    ttf_json_kstring(json, "result", ttf_result_name(record->result));
    put_text(json, "reason", record->reason);
    if (record->n_images > 0) {
        ttf_json_key(json, "images");
        ttf_json_array(json);
        for (i = 0; i < record->n_images; i++)
            put_image(json, &record->images[i]);
        ttf_json_array_end(json);
    }
    put_sensors(json, record);
}

/*
 * What the text of each part can come to: its keys, numbers of 20 digits, and texts as long as
 * their fields. Names and reasons are plain words: hardly a byte of them is written as \u00xx.
 */
#define SLOT_BYTES  4096 /* times, result, reason, and sensors' 16 x 140 */
#define IMAGE_BYTES 3072 /* names, levels, flags, and files' 4 x 400 */
#define SHOT_BYTES  768  /* settings asked and granted, times, why it was refused */
#define LAMP_BYTES  128

size_t ttf_slot_line_bytes(unsigned n_images, unsigned n_shots, unsigned n_lamps)
{
    return SLOT_BYTES + (size_t)n_images * IMAGE_BYTES +
           (size_t)n_shots * (SHOT_BYTES + (size_t)n_lamps * LAMP_BYTES);
}

void ttf_segment_put(struct ttf_json *json, const struct ttf_segment *s)
{
    ttf_json_kint(json, "segment", s->segment);
    if (s->corrects)
        ttf_json_kbool(json, "corrects", true);
    ttf_json_kint(json, "first_index", s->first_index);
    put_text(json, "boot_id", s->boot_id);
    ttf_json_kint(json, "origin_ns", s->origin_ns);
    put_instant(json, "origin_utc_ns", s->origin_utc_ns);
    ttf_json_kstring(json, "trust", s->trust[0] ? s->trust : "none");
    put_instant(json, "uncertainty_ns", s->uncertainty_ns);
    ttf_json_kint(json, "interval_ns", s->interval_ns);
    if (s->plan >= 0)
        ttf_json_kint(json, "plan", s->plan);
    put_text(json, "zone", s->zone);
    if (s->zone[0])
        ttf_json_kint(json, "zone_offset_s", s->zone_offset_s);
    if (s->gap_ns == TTF_NS_UNKNOWN) {
        ttf_json_key(json, "gap_ns");
        ttf_json_null(json); /* an outage whose length nobody knows yet */
    } else if (s->gap_ns > 0) {
        ttf_json_kint(json, "gap_ns", s->gap_ns);
    }
    put_text(json, "dataset_sha256", s->dataset_sha256);
    if (s->run_ns > 0)
        ttf_json_kint(json, "run_ns", s->run_ns);
    if (s->run_utc_ns > 0) {
        ttf_json_kint(json, "run_utc_ns", s->run_utc_ns);
        ttf_json_kstring(json, "run_trust", s->run_trust);
        put_instant(json, "run_gaps_ns", s->run_gaps_ns);
        if (s->run_doubted_ns > 0)
            ttf_json_kint(json, "run_doubted_ns", s->run_doubted_ns);
        if (s->run_given_up_ns > 0)
            ttf_json_kint(json, "run_given_up_ns", s->run_given_up_ns);
    }
    put_text(json, "box", s->box);
}

void ttf_end_put(struct ttf_json *json, const struct ttf_end_record *e)
{
    ttf_json_kstring(json, "reason", e->reason);
    ttf_json_kint(json, "slots", e->slots);
    ttf_json_kint(json, "captured", e->captured);
    ttf_json_kint(json, "partial", e->partial);
    ttf_json_kint(json, "missed", e->missed);
    ttf_json_kint(json, "failed", e->failed);
    ttf_json_kint(json, "paused", e->paused);
    ttf_json_kint(json, "power", e->power);
}
