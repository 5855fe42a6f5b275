/* SPDX-License-Identifier: Apache-2.0 */
#include "body.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>

#include "folder.h"
#include "ttf/base/time.h"
#include "ttf/dataset/json_parse.h"

static int not_meant(struct ttf_err *err, const char *field, const char *what)
{
    return ttf_err_set(err, -EINVAL, field, "%s", what);
}

/* An object that has no other names than these, NULL-ended. */
static int read_object(const char *text, size_t bytes, const char *const *names, json_t **ret,
                       struct ttf_err *err)
{
    json_error_t where;
    const char *name;
    json_t *value;
    int r = ttf_json_parse(text, bytes, ret, &where);

    if (r == -ENOMEM)
        return ttf_err_set(err, r, NULL, "no memory");
    if (r < 0)
        return ttf_err_set(err, -EINVAL, "body", "is no JSON: line %d, column %d: %.120s",
                           where.line, where.column, where.text);
    r = json_is_object(*ret) ? 0 : not_meant(err, "body", "an object is meant");
    json_object_foreach(*ret, name, value)
    {
        bool meant = false;

        for (unsigned i = 0; names[i]; i++)
            meant = meant || strcmp(name, names[i]) == 0;
        if (!meant && r == 0)
            r = ttf_err_set(err, -EINVAL, "body", "'%.40s' is not meant here", name);
    }
    if (r < 0)
        json_decref(*ret);
    return r;
}

/* A text that fits; not there: "". */
static int take_text(json_t *object, const char *name, char *ret, size_t size, struct ttf_err *err)
{
    json_t *value = json_object_get(object, name);
    size_t n;

    ret[0] = '\0';
    if (!value)
        return 0;
    if (!json_is_string(value))
        return not_meant(err, name, "a text is meant");
    n = json_string_length(value);
    if (n >= size || strlen(json_string_value(value)) != n)
        return ttf_err_set(err, -EINVAL, name, "a text of at most %zu bytes is meant", size - 1);
    memcpy(ret, json_string_value(value), n + 1);
    return 0;
}

int body_token(const char *text, size_t bytes, char *ret, size_t size, struct ttf_err *err)
{
    static const char *const NAMES[] = {"token", NULL};
    json_t *object;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    r = take_text(object, "token", ret, size, err);
    json_decref(object);
    return r;
}

/* A dataset's or plan's name, or nothing. */
static int take_name(json_t *object, const char *name, char ret[65], struct ttf_err *err)
{
    int r = take_text(object, name, ret, 65, err);

    if (r == 0 && *ret && !folder_is_name(ret))
        r = not_meant(err, name,
                      "a name of at most 64 of A-Z a-z 0-9 . _ - that does not begin with a dot is "
                      "meant");
    return r;
}

int body_start(const char *text, size_t bytes, char ret_plan[65], char ret_dataset[65],
               struct ttf_err *err)
{
    static const char *const NAMES[] = {"plan", "dataset", NULL};
    json_t *object;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    r = take_name(object, "plan", ret_plan, err);
    if (r == 0)
        r = take_name(object, "dataset", ret_dataset, err);
    json_decref(object);
    return r;
}

int body_pause(const char *text, size_t bytes, struct ttf_http_ask *ret, struct ttf_err *err)
{
    static const char *const NAMES[] = {"reason", NULL};
    json_t *object;
    int r;

    *ret = (struct ttf_http_ask){.kind = TTF_HTTP_ASK_PAUSE};
    if (bytes == 0)
        return 0;
    r = read_object(text, bytes, NAMES, &object, err);
    if (r < 0)
        return r;
    r = take_text(object, "reason", ret->reason, sizeof ret->reason, err);
    json_decref(object);
    return r;
}

int body_time(const char *text, size_t bytes, int64_t *ret_utc_ns, struct ttf_err *err)
{
    static const char *const NAMES[] = {"utc_ns", NULL};
    json_t *object, *value;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    value = json_object_get(object, "utc_ns");
    if (json_is_integer(value))
        *ret_utc_ns = json_integer_value(value);
    else
        r = not_meant(err, "utc_ns", "nanoseconds since 1970 are meant, as a whole number");
    json_decref(object);
    return r;
}

int body_change(const char *text, size_t bytes, struct ttf_http_ask *ret, struct ttf_err *err)
{
    static const char *const NAMES[] = {"count", "until_utc_ns", "interval_ns", NULL};
    json_t *object;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    *ret = (struct ttf_http_ask){.kind = TTF_HTTP_ASK_KIND_COUNT};
    for (unsigned i = 0; NAMES[i] && r == 0; i++) {
        json_t *value = json_object_get(object, NAMES[i]);

        if (!value)
            continue;
        if (ret->kind != TTF_HTTP_ASK_KIND_COUNT)
            r = not_meant(err, NAMES[i], "one change at a time is meant");
        else if (!json_is_integer(value) || json_integer_value(value) < 1)
            r = not_meant(err, NAMES[i], "a whole number of 1 or more is meant");
        ret->kind = (enum ttf_http_ask_kind)(TTF_HTTP_ASK_COUNT + i);
        ret->value = json_integer_value(value);
    }
    if (r == 0 && ret->kind == TTF_HTTP_ASK_KIND_COUNT)
        r = not_meant(err, "body", "count, until_utc_ns or interval_ns is missing");
    json_decref(object);
    return r;
}

/* ---- a calibration ---- */

/* A number within bounds; not there: 0. */
static int take_real(json_t *object, const char *name, double least, double most, double *ret,
                     struct ttf_err *err)
{
    json_t *value = json_object_get(object, name);

    *ret = 0;
    if (!value)
        return 0;
    *ret = json_number_value(value);
    if (!json_is_number(value) || !(*ret >= least && *ret <= most))
        return ttf_err_set(err, -EINVAL, name, "a number of %g to %g is meant", least, most);
    return 0;
}

static int take_whole(json_t *object, const char *name, int64_t most, int64_t *ret,
                      struct ttf_err *err)
{
    json_t *value = json_object_get(object, name);

    *ret = 0;
    if (!value)
        return 0;
    *ret = json_integer_value(value);
    if (!json_is_integer(value) || *ret < 1 || *ret > most)
        return ttf_err_set(err, -EINVAL, name, "a whole number of 1 to %lld is meant",
                           (long long)most);
    return 0;
}

static int take_corners(json_t *object, struct ttf_http_calibrate *ret, struct ttf_err *err)
{
    json_t *corners = json_object_get(object, "corners");

    for (size_t i = 0; i < 4; i++)
        for (size_t k = 0; k < 2; k++) {
            json_t *value = json_array_get(json_array_get(corners, i), k);

            if (!json_is_number(value) || json_array_size(corners) != 4 ||
                json_array_size(json_array_get(corners, i)) != 2)
                return not_meant(err, "corners",
                                 "[[X, Y], ...] of the chart's four corners is meant");
            ret->corners[i][k] = json_number_value(value);
        }
    return 0;
}

static int take_calibrate(json_t *object, struct ttf_http_calibrate *ret, struct ttf_err *err)
{
    int64_t frames = 0;
    char part[16];
    int r = take_text(object, "part", part, sizeof part, err);
    int found = r == 0 ? ttf_calibration_part_find(part) : -ENOENT;

    if (r == 0 && found < 0)
        r = not_meant(err, "part", "dark, flat, chart, geometry or flicker is meant");
    else if (r == 0)
        ret->part = (enum ttf_calibration_part)found;
    if (r == 0)
        r = take_name(object, "plan", ret->plan, err);
    if (r == 0)
        r = take_whole(object, "exposure_ns", 1000 * TTF_NS_PER_S, &ret->exposure_ns, err);
    if (r == 0)
        r = take_whole(object, "gain_milli", 1000000, &ret->gain_milli, err);
    if (r == 0)
        r = take_whole(object, "frames", 1000, &frames, err);
    if (r == 0)
        r = take_real(object, "reflectance", 0.01, 1, &ret->reflectance, err);
    if (r == 0)
        r = take_real(object, "pitch_mm", 0.001, 1000, &ret->pitch_mm, err);
    ret->frames = (unsigned)frames;
    if (r == 0 && ret->part == TTF_CALIBRATION_GEOMETRY && ret->pitch_mm == 0)
        r = not_meant(err, "pitch_mm", "how far the dots are apart is missing");
    if (r == 0 && ret->part == TTF_CALIBRATION_CHART)
        r = take_corners(object, ret, err);
    return r;
}

int body_calibrate(const char *text, size_t bytes, struct ttf_http_calibrate *ret,
                   struct ttf_err *err)
{
    static const char *const NAMES[] = {"part",       "plan",    "exposure_ns",
                                        "gain_milli", "frames",  "reflectance",
                                        "pitch_mm",   "corners", NULL};
    json_t *object;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    memset(ret, 0, sizeof *ret);
    r = take_calibrate(object, ret, err);
    json_decref(object);
    return r;
}

int body_name(const char *text, size_t bytes, char ret[65], struct ttf_err *err)
{
    static const char *const NAMES[] = {"name", NULL};
    json_t *object;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    r = take_name(object, "name", ret, err);
    json_decref(object);
    return r;
}

static int take_slots(json_t *object, struct ttf_note *note, struct ttf_err *err)
{
    json_t *ranges = json_object_get(object, "slots"), *range;
    size_t i;

    if (ranges && (!json_is_array(ranges) || json_array_size(ranges) > TTF_NOTE_SLOTS_MAX))
        return ttf_err_set(err, -EINVAL, "slots", "an array of at most %d ranges is meant",
                           TTF_NOTE_SLOTS_MAX);
    json_array_foreach(ranges, i, range)
    {
        json_t *first = json_array_get(range, 0), *last = json_array_get(range, 1);

        if (json_array_size(range) != 2 || !json_is_integer(first) || !json_is_integer(last))
            return not_meant(err, "slots", "[FIRST, LAST] is meant of each range");
        note->slots[note->n_slots][0] = json_integer_value(first);
        note->slots[note->n_slots++][1] = json_integer_value(last);
    }
    return 0;
}

static int take_tags(json_t *object, struct ttf_note *note, struct ttf_err *err)
{
    json_t *tags = json_object_get(object, "tags"), *tag;
    size_t i;

    if (tags && (!json_is_array(tags) || json_array_size(tags) > TTF_NOTE_TAGS_MAX))
        return ttf_err_set(err, -EINVAL, "tags", "an array of at most %d words is meant",
                           TTF_NOTE_TAGS_MAX);
    json_array_foreach(tags, i, tag)
    {
        const char *text = json_string_value(tag);

        if (!text || strlen(text) >= sizeof note->tags[0] || !*text)
            return ttf_err_set(err, -EINVAL, "tags", "a word of at most %zu letters is meant",
                               sizeof note->tags[0] - 1);
        memcpy(note->tags[note->n_tags++], text, strlen(text) + 1);
    }
    return 0;
}

int body_note(const char *text, size_t bytes, struct ttf_note *ret, struct ttf_err *err)
{
    static const char *const NAMES[] = {"text", "author", "slots", "tags", NULL};
    json_t *object;
    int r = read_object(text, bytes, NAMES, &object, err);

    if (r < 0)
        return r;
    memset(ret, 0, sizeof *ret);
    ret->utc_ns = TTF_NS_UNKNOWN;
    r = take_text(object, "text", ret->text, sizeof ret->text, err);
    if (r == 0)
        r = take_text(object, "author", ret->author, sizeof ret->author, err);
    if (r == 0)
        r = take_slots(object, ret, err);
    if (r == 0)
        r = take_tags(object, ret, err);
    json_decref(object);
    return r < 0 ? r : ttf_note_check(ret, err);
}

/* ---- a view ---- */

/* Decimal digits up to `end`, and what stands behind them. */
static bool take_number(const char **at, char end, int64_t max, int64_t *ret)
{
    const char *c = *at;
    int64_t value = 0;

    for (; *c >= '0' && *c <= '9'; c++) {
        if (value > (max - (*c - '0')) / 10)
            return false;
        value = value * 10 + (*c - '0');
    }
    if (c == *at || *c != end)
        return false;
    *at = *c ? c + 1 : c;
    *ret = value;
    return true;
}

static int take_lamps(const char *text, struct ttf_http_view *ret, struct ttf_err *err)
{
    while (text && *text) {
        size_t whole = strcspn(text, ","), n = strcspn(text, ":,");
        int64_t level = 1000;

        if (ret->n_lamps == TTF_HTTP_LAMPS_MAX || n == 0 || n >= sizeof ret->lamps[0].name)
            return not_meant(err, "lamps", "names with commas between are meant");
        if (text[n] == ':') {
            const char *at = text + n + 1;

            if (!take_number(&at, text[whole], 1000, &level))
                return not_meant(err, "lamps", "a level of 0 to 1000 is meant behind a colon");
        }
        memcpy(ret->lamps[ret->n_lamps].name, text, n);
        ret->lamps[ret->n_lamps++].level_permille = (unsigned)level;
        text += whole + (text[whole] == ',');
    }
    return 0;
}

static int take_region(const char *text, struct ttf_http_view *ret, struct ttf_err *err)
{
    int64_t n[4];

    if (!text)
        return 0;
    for (unsigned i = 0; i < 4; i++)
        if (!take_number(&text, i < 3 ? ',' : '\0', 65535, &n[i]))
            return not_meant(err, "region", "X,Y,WIDTH,HEIGHT are meant");
    if (n[2] == 0 || n[3] == 0)
        return not_meant(err, "region", "is empty");
    ret->x = (uint32_t)n[0];
    ret->y = (uint32_t)n[1];
    ret->width = (uint32_t)n[2];
    ret->height = (uint32_t)n[3];
    return 0;
}

int body_view(const struct body_view *said, struct ttf_http_view *ret, struct ttf_err *err)
{
    const char *exposure = said->exposure_ns, *gain = said->gain_milli;
    int r;

    memset(ret, 0, sizeof *ret);
    if (said->camera && strlen(said->camera) >= sizeof ret->camera)
        return not_meant(err, "camera", "is no camera's name");
    if (said->camera)
        memcpy(ret->camera, said->camera, strlen(said->camera) + 1);
    if (exposure && !take_number(&exposure, '\0', TTF_NS_PER_H, &ret->exposure_ns))
        return not_meant(err, "exposure_ns", "nanoseconds, an hour at most, are meant");
    if (gain && !take_number(&gain, '\0', 1000000, &ret->gain_milli))
        return not_meant(err, "gain_milli", "thousandths, 1,000,000 at most, are meant");
    r = take_lamps(said->lamps, ret, err);
    return r < 0 ? r : take_region(said->region, ret, err);
}
