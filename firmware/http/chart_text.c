/* SPDX-License-Identifier: Apache-2.0 */
#include "chart_text.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/dataset/json_writer.h"

#define SEGMENTS_MAX 65536 /* boots; of later ones the times are not given */

int chart_segments_put(struct chart_segments *segments, const struct ttf_segment *segment)
{
    size_t i = (size_t)segment->segment;

    if (segment->segment < 0 || i >= SEGMENTS_MAX)
        return 0;
    if (i >= segments->room) {
        size_t room = i < 16 ? 32 : 2 * i;
        struct chart_origin *more = reallocarray(segments->origin, room, sizeof *more);

        if (!more)
            return -ENOMEM;
        segments->origin = more;
        segments->room = room;
    }
    for (; segments->n <= i; segments->n++)
        segments->origin[segments->n] = (struct chart_origin){0, TTF_NS_UNKNOWN};
    segments->origin[i] = (struct chart_origin){segment->origin_ns, segment->origin_utc_ns};
    return 0;
}

void chart_segments_free(struct chart_segments *segments)
{
    free(segments->origin);
    *segments = (struct chart_segments){0};
}

static bool is_there(const struct chart_points *points, unsigned i)
{
    for (int k = 0; k < TTF_RESULT_COUNT; k++)
        if (points->point[i].results[k])
            return true;
    return false;
}

static void put_utc(struct ttf_json *json, const struct chart_segments *segments,
                    const struct chart_point *point)
{
    const struct chart_origin *origin = NULL;
    int64_t utc_ns;

    if (point->segment >= 0 && (size_t)point->segment < segments->n)
        origin = &segments->origin[point->segment];
    if (!origin || origin->origin_utc_ns == TTF_NS_UNKNOWN ||
        __builtin_sub_overflow(point->due_ns, origin->origin_ns, &utc_ns) ||
        __builtin_add_overflow(utc_ns, origin->origin_utc_ns, &utc_ns))
        ttf_json_null(json);
    else
        ttf_json_int(json, utc_ns);
}

static void put_points(struct ttf_json *json, const struct chart_points *points,
                       const struct chart_segments *segments)
{
    ttf_json_key(json, "index");
    ttf_json_array(json);
    for (unsigned i = 0; i < points->n; i++)
        if (is_there(points, i))
            ttf_json_int(json, points->point[i].index);
    ttf_json_array_end(json);
    ttf_json_key(json, "pictured");
    ttf_json_array(json);
    for (unsigned i = 0; i < points->n; i++) {
        if (!is_there(points, i))
            continue;
        if (points->point[i].pictured < 0)
            ttf_json_null(json);
        else
            ttf_json_int(json, points->point[i].pictured);
    }
    ttf_json_array_end(json);
    ttf_json_key(json, "due_utc_ns");
    ttf_json_array(json);
    for (unsigned i = 0; i < points->n; i++)
        if (is_there(points, i))
            put_utc(json, segments, &points->point[i]);
    ttf_json_array_end(json);
    ttf_json_key(json, "results");
    ttf_json_object(json);
    for (int k = 0; k < TTF_RESULT_COUNT; k++) {
        ttf_json_key(json, ttf_result_name((enum ttf_result)k));
        ttf_json_array(json);
        for (unsigned i = 0; i < points->n; i++)
            if (is_there(points, i))
                ttf_json_int(json, points->point[i].results[k]);
        ttf_json_array_end(json);
    }
    ttf_json_object_end(json);
}

enum which {
    LEAST,
    GREATEST,
    MEAN
};

static void put_column(struct ttf_json *json, const struct chart_points *points,
                       const struct chart_series *series, const char *key, enum which which)
{
    ttf_json_key(json, key);
    ttf_json_array(json);
    for (unsigned i = 0; i < points->n; i++) {
        const struct chart_value *v = &series->value[i];

        if (!is_there(points, i))
            continue;
        if (v->n == 0)
            ttf_json_null(json);
        else if (which == MEAN)
            ttf_json_double(json, v->sum / v->n);
        else
            ttf_json_double(json, which == LEAST ? v->min : v->max);
    }
    ttf_json_array_end(json);
}

static void put_series(struct ttf_json *json, const struct chart_points *points,
                       const struct chart_series *series)
{
    static const char *const WHAT[] = {"reference_level", "mean_level", "slot_error_s", "sensor",
                                       "lamp_hours"};

    ttf_json_object(json);
    ttf_json_kstring(json, "what", WHAT[series->what]);
    if (*series->name)
        ttf_json_kstring(json, series->what <= CHART_MEAN ? "stream" : "name", series->name);
    if (*series->kind)
        ttf_json_kstring(json, "kind", series->kind);
    if (series->bracket >= 0)
        ttf_json_kint(json, "bracket", series->bracket);
    put_column(json, points, series, "min", LEAST);
    put_column(json, points, series, "max", GREATEST);
    put_column(json, points, series, "mean", MEAN);
    ttf_json_object_end(json);
}

int chart_text(const char *dataset, const struct chart_points *points,
               const struct chart_segments *segments, bool complete, char **ret_text,
               size_t *ret_bytes)
{
    struct ttf_json json;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "name", dataset);
    ttf_json_kint(&json, "slots", points->slots);
    ttf_json_kint(&json, "slots_per_point", points->width);
    ttf_json_kbool(&json, "complete", complete);
    put_points(&json, points, segments);
    ttf_json_key(&json, "series");
    ttf_json_array(&json);
    for (unsigned i = 0; i < points->n_series; i++)
        put_series(&json, points, &points->series[i]);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    return ttf_json_take(&json, ret_text, ret_bytes);
}
