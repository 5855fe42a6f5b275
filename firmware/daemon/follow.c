/* SPDX-License-Identifier: Apache-2.0 */
#include "follow.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/manifest.h"

struct reading {
    struct daemon *d;
    const char *dataset;
    enum course_part part;
    char *last; /* readings of the newest slot among what is new; NULL */
    int64_t last_index;
};

static void put_lamps(const struct ttf_shot *shot, struct ttf_json *json)
{
    ttf_json_key(json, "lamps");
    ttf_json_array(json);
    for (unsigned i = 0; i < shot->n_lamps; i++) {
        ttf_json_object(json);
        ttf_json_kstring(json, "name", shot->lamps[i].name);
        ttf_json_kint(json, "commanded_permille", shot->lamps[i].commanded_permille);
        if (shot->lamps[i].measured_permille >= 0)
            ttf_json_kint(json, "measured_permille", shot->lamps[i].measured_permille);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

static void put_sensors(const struct ttf_slot_record *record, struct ttf_json *json)
{
    ttf_json_key(json, "sensors");
    ttf_json_array(json);
    for (unsigned i = 0; i < record->n_sensors; i++) {
        ttf_json_object(json);
        ttf_json_kstring(json, "name", record->sensors[i].name);
        ttf_json_kstring(json, "kind", record->sensors[i].kind);
        ttf_json_kbool(json, "ok", record->sensors[i].ok);
        ttf_json_kint(json, "value", record->sensors[i].value);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

char *follow_readings(const struct ttf_slot_record *record)
{
    const struct ttf_shot none = {0}, *shot = &none;
    struct ttf_json json;
    char *text = NULL;

    for (unsigned i = 0; i < record->n_images; i++)
        if (record->images[i].n_shots > 0)
            shot = &record->images[i].shots[record->images[i].n_shots - 1];
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kint(&json, "index", record->index);
    put_lamps(shot, &json);
    put_sensors(record, &json);
    ttf_json_object_end(&json);
    return ttf_json_take(&json, &text, NULL) == 0 ? text : NULL;
}

static int on_line(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct reading *reading = ctx;
    struct ttf_slot_record record;
    struct ttf_segment segment;

    if (strcmp(line->type, "segment") == 0 && ttf_growth_segment(line, &segment, err) == 0)
        situation_segment(reading->d->situation, reading->dataset, reading->part, &segment);
    if (strcmp(line->type, "slot") == 0 && ttf_growth_slot(line, &record, err) == 0) {
        char *readings =
            record.n_images > 0 || record.n_sensors > 0 ? follow_readings(&record) : NULL;

        situation_record(reading->d->situation, reading->dataset, reading->part, &record, readings);
        if (readings && (!reading->last || record.index > reading->last_index)) {
            free(reading->last);
            reading->last = readings;
            reading->last_index = record.index;
        } else {
            free(readings);
        }
        ttf_slot_record_free(&record);
    }
    return 0;
}

/* Whether it is about another run than follow, and which. */
static bool elsewhere(const struct follow *follow, struct daemon *d, char ret[65],
                      char ret_second[512])
{
    situation_records(d->situation, ret, ret_second);
    return strcmp(ret, follow->dataset) != 0 || strcmp(ret_second, follow->second) != 0;
}

bool follow_elsewhere(const struct follow *follow, struct daemon *d)
{
    char dataset[65], second[512];

    return elsewhere(follow, d, dataset, second);
}

/* Is what lies in the second storage under this name what a run went on in? */
static int look_at_second(const struct follow *follow, struct daemon *d)
{
    struct ttf_manifest manifest;
    char path[512 + 96];
    int r;

    (void)snprintf(path, sizeof path, "%s/%s", follow->second, follow->dataset);
    r = ttf_manifest_load(d->io, path, &manifest, NULL);
    if (r == 0 && strcmp(manifest.group_member, "second") != 0)
        r = -ENOENT;
    return r;
}

/* What is new in one of the two. 1: it was begun anew. */
static int read_part(struct follow *follow, struct reading *reading, const char *folder)
{
    struct ttf_growth *growth = &follow->growth[reading->part];
    struct daemon *d = reading->d;
    char path[512 + 96];
    int r = 0;

    if (reading->part == COURSE_SECOND && growth->lines == 0)
        r = look_at_second(follow, d);
    (void)snprintf(path, sizeof path, "%s/%s/records.jsonl", folder, follow->dataset);
    if (r == 0)
        r = ttf_growth_read(d->io, path, growth, 0, on_line, reading, NULL);
    follow->missing = follow->missing || r < 0;
    return r == -ESTALE;
}

/* The second one first: it says which slots of the first one are its own. */
static bool read_both(struct follow *follow, struct reading *reading)
{
    bool anew = false;

    follow->missing = false;
    if (*follow->second) {
        reading->part = COURSE_SECOND;
        anew = read_part(follow, reading, follow->second);
    }
    reading->part = COURSE_FIRST;
    return read_part(follow, reading, reading->d->config.data) || anew;
}

void follow_read(struct follow *follow, struct daemon *d)
{
    struct reading reading = {.d = d, .dataset = follow->dataset};
    char dataset[65], second[512];

    if (elsewhere(follow, d, dataset, second)) {
        memset(follow, 0, sizeof *follow);
        memcpy(follow->dataset, dataset, sizeof follow->dataset);
        memcpy(follow->second, second, sizeof follow->second);
    }
    /* A dataset that was begun anew is forgotten with all that was known of it. */
    if (read_both(follow, &reading)) {
        memset(follow->growth, 0, sizeof follow->growth);
        situation_forget(d->situation, follow->dataset);
        (void)read_both(follow, &reading);
    }
    if (reading.last)
        ttf_http_events_publish(d->events, "readings", reading.last);
    free(reading.last);
}
