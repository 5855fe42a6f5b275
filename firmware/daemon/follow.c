/* SPDX-License-Identifier: Apache-2.0 */
#include "follow.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reading {
    struct daemon *d;
    const char *dataset;
    bool second; /* it is the second storage's */
    char *last;  /* readings of the newest slot among what is new; NULL */
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
        situation_segment(reading->d->situation, reading->dataset, reading->second, &segment);
    if (strcmp(line->type, "slot") == 0 && ttf_growth_slot(line, &record, err) == 0) {
        char *readings =
            record.n_images > 0 || record.n_sensors > 0 ? follow_readings(&record) : NULL;

        situation_record(reading->d->situation, reading->dataset, &record, readings);
        if (readings) {
            free(reading->last);
            reading->last = readings;
        }
        ttf_slot_record_free(&record);
    }
    return 0;
}

bool follow_elsewhere(const struct follow *follow, struct daemon *d)
{
    char dataset[65];

    (void)situation_dataset(d->situation, dataset);
    return strcmp(dataset, follow->dataset) != 0;
}

/* What is new in one of the two. A dataset that was begun anew is forgotten with all that was known of it. */
static void read_new(struct follow *follow, struct reading *reading, const char *folder)
{
    struct ttf_growth *growth = reading->second ? &follow->second : &follow->first;
    struct daemon *d = reading->d;
    char path[512 + 96];
    int r;

    (void)snprintf(path, sizeof path, "%s/%s/records.jsonl", folder, follow->dataset);
    r = ttf_growth_read(d->io, path, growth, 0, on_line, reading, NULL);
    if (r != -ESTALE)
        return;
    memset(growth, 0, sizeof *growth);
    if (!reading->second) {
        situation_forget(d->situation, follow->dataset);
        memset(&follow->second, 0, sizeof follow->second);
    }
    (void)!ttf_growth_read(d->io, path, growth, 0, on_line, reading, NULL);
}

void follow_read(struct follow *follow, struct daemon *d)
{
    struct reading reading = {.d = d};
    char dataset[65], second[512];

    (void)situation_dataset(d->situation, dataset);
    if (strcmp(dataset, follow->dataset) != 0) {
        memset(follow, 0, sizeof *follow);
        memcpy(follow->dataset, dataset, sizeof follow->dataset);
    }
    reading.dataset = follow->dataset;
    read_new(follow, &reading, d->config.data);
    situation_get_second(d->situation, second);
    if (*second) {
        reading.second = true;
        read_new(follow, &reading, second);
    }
    if (reading.last)
        ttf_http_events_publish(d->events, "readings", reading.last);
    free(reading.last);
}
