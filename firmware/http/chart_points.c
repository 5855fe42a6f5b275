/* SPDX-License-Identifier: Apache-2.0 */
#include "chart_points.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"

void chart_points_free(struct chart_points *points)
{
    for (unsigned i = 0; i < points->n_series; i++)
        free(points->series[i].value);
    free(points->point);
    memset(points, 0, sizeof *points);
}

static void join_values(struct chart_value *into, const struct chart_value *other)
{
    if (other->n == 0)
        return;
    if (into->n == 0) {
        *into = *other;
        return;
    }
    into->min = fmin(into->min, other->min);
    into->max = fmax(into->max, other->max);
    into->sum += other->sum;
    into->n += other->n;
}

static bool is_hole(const struct chart_point *point)
{
    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        if (point->results[i])
            return false;
    return true;
}

static void join_points(struct chart_point *into, const struct chart_point *other)
{
    if (is_hole(into)) {
        *into = *other;
        return;
    }
    if (is_hole(other))
        return;
    if (into->pictured < 0)
        into->pictured = other->pictured;
    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        into->results[i] += other->results[i];
}

/* Two points become one. */
static void halve(struct chart_points *points)
{
    const struct chart_point none = {0};
    const struct chart_value nothing = {0};

    for (unsigned i = 0; i < points->n; i += 2) {
        points->point[i / 2] = points->point[i];
        join_points(&points->point[i / 2], i + 1 < points->n ? &points->point[i + 1] : &none);
    }
    for (unsigned s = 0; s < points->n_series; s++) {
        struct chart_value *value = points->series[s].value;

        for (unsigned i = 0; i < points->n; i += 2) {
            value[i / 2] = value[i];
            join_values(&value[i / 2], i + 1 < points->n ? &value[i + 1] : &nothing);
        }
        memset(value + (points->n + 1) / 2, 0,
               (CHART_POINTS - (points->n + 1) / 2) * sizeof *value);
    }
    points->n = (points->n + 1) / 2;
    memset(points->point + points->n, 0, (CHART_POINTS - points->n) * sizeof *points->point);
    points->width *= 2;
}

/* The point of a slot, made room for. */
static unsigned place(struct chart_points *points, const struct ttf_slot_record *record)
{
    int64_t at = record->index - points->base;

    if (at < 0)
        at = 0; /* out of order: no dataset has it */
    while (at / points->width >= CHART_POINTS)
        halve(points);
    at /= points->width;
    if (at >= points->n)
        points->n = (unsigned)at + 1;
    return (unsigned)at;
}

/* NULL: no more columns are kept, or no memory. */
static struct chart_series *find(struct chart_points *points, enum chart_what what,
                                 const char *name, const char *kind, int bracket)
{
    struct chart_series *series;

    for (unsigned i = 0; i < points->n_series; i++) {
        series = &points->series[i];
        if (series->what == what && series->bracket == bracket && strcmp(series->name, name) == 0 &&
            strcmp(series->kind, kind) == 0)
            return series;
    }
    if (points->n_series == CHART_SERIES)
        return NULL;
    series = &points->series[points->n_series];
    memset(series, 0, sizeof *series);
    series->value = calloc(CHART_POINTS, sizeof *series->value);
    if (!series->value)
        return NULL;
    series->what = what;
    series->bracket = bracket;
    (void)snprintf(series->name, sizeof series->name, "%s", name);
    (void)snprintf(series->kind, sizeof series->kind, "%s", kind);
    points->n_series++;
    return series;
}

static void put(struct chart_series *series, unsigned at, double value)
{
    const struct chart_value one = {value, value, value, 1};

    if (series && isfinite(value))
        join_values(&series->value[at], &one);
}

static void add_lamps(struct chart_points *points, struct chart_lamps *lamps,
                      const struct ttf_slot_record *record)
{
    struct chart_lit lit[CHART_LAMPS];
    unsigned n = chart_lamps_add(lamps, record, lit);

    for (unsigned i = 0; i < n; i++) {
        struct chart_series *series = find(points, CHART_LAMP, lit[i].name, "", -1);

        if (series)
            series->total += (double)lit[i].ns / (double)TTF_NS_PER_H;
    }
}

static void add_values(struct chart_points *points, unsigned at, struct chart_lamps *lamps,
                       const struct ttf_slot_record *record)
{
    int64_t error_ns;

    for (unsigned i = 0; i < record->n_images; i++) {
        const struct ttf_image *image = &record->images[i];

        if (isfinite(image->reference_level))
            put(find(points, CHART_REFERENCE, image->stream, "", image->bracket), at,
                image->reference_level);
        if (isfinite(image->mean_level))
            put(find(points, CHART_MEAN, image->stream, "", image->bracket), at, image->mean_level);
    }
    add_lamps(points, lamps, record);
    if (record->middle_ns != TTF_NS_UNKNOWN &&
        !__builtin_sub_overflow(record->middle_ns, record->due_ns, &error_ns))
        put(find(points, CHART_ERROR, "", "", -1), at, (double)error_ns / (double)TTF_NS_PER_S);
    for (unsigned i = 0; i < record->n_sensors; i++) {
        const struct ttf_slot_sensor *sensor = &record->sensors[i];

        if (sensor->ok)
            put(find(points, CHART_SENSOR, sensor->name, sensor->kind, -1), at,
                (double)sensor->value);
    }
    for (unsigned i = 0; i < points->n_series; i++)
        if (points->series[i].what == CHART_LAMP)
            put(&points->series[i], at, points->series[i].total);
}

int chart_points_add(struct chart_points *points, struct chart_lamps *lamps,
                     const struct ttf_slot_record *record)
{
    struct chart_point *point;
    unsigned at;

    if (!points->point) {
        points->point = calloc(CHART_POINTS, sizeof *points->point);
        if (!points->point)
            return -ENOMEM;
        points->base = record->index;
        points->width = 1;
    }
    at = place(points, record);
    point = &points->point[at];
    if (is_hole(point)) {
        point->index = record->index;
        point->due_ns = record->due_ns;
        point->segment = record->segment;
        point->pictured = -1;
    }
    if (point->pictured < 0 &&
        (record->result == TTF_RESULT_CAPTURED || record->result == TTF_RESULT_PARTIAL))
        point->pictured = record->index;
    point->results[record->result]++;
    points->slots++;
    add_values(points, at, lamps, record);
    return 0;
}
