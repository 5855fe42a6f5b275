/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "manifest_rules.h"
#include "record_line.h"
#include "ttf/dataset/hash.h"

static struct ttf_json_in reading(const struct ttf_line *line, struct ttf_err *err)
{
    return (struct ttf_json_in){.where = line->where, .wrong = -TTF_EDAMAGED, .err = err};
}

static uint32_t get_control(struct ttf_json_in *in, const json_t *o, const char *key)
{
    return (uint32_t)ttf_in_int(in, o, key, 0, UINT32_MAX, 0, TTF_JSON_OPTIONAL);
}

static void get_exposure(struct ttf_json_in *in, const json_t *shot, const char *key,
                         struct ttf_exposure *e)
{
    const json_t *o = ttf_in_object(in, shot, key, TTF_JSON_OPTIONAL);

    if (!o)
        return;
    e->exposure_ns = ttf_in_int(in, o, "exposure_ns", 1, INT64_MAX, 0, TTF_JSON_REQUIRED);
    e->gain_milli = get_control(in, o, "gain_milli");
    e->wb_r_milli = get_control(in, o, "wb_r_milli");
    e->wb_b_milli = get_control(in, o, "wb_b_milli");
    e->lens_mdpt = get_control(in, o, "lens_mdpt");
}

static int64_t get_instant(struct ttf_json_in *in, const json_t *o, const char *key)
{
    return ttf_in_int(in, o, key, INT64_MIN, INT64_MAX, TTF_NS_UNKNOWN, TTF_JSON_OPTIONAL);
}

static void get_shot(struct ttf_json_in *in, const json_t *o, struct ttf_shot *shot)
{
    const json_t *lamps, *l;
    struct ttf_shot_lamp *lamp;
    size_t i;

    get_exposure(in, o, "asked", &shot->asked);
    get_exposure(in, o, "granted", &shot->granted);
    shot->start_ns = get_instant(in, o, "start_ns");
    shot->end_ns = get_instant(in, o, "end_ns");
    ttf_in_text(in, o, "refused", shot->refused, sizeof(shot->refused), TTF_JSON_CUT);
    lamps = ttf_in_array(in, o, "lamps", TTF_JSON_OPTIONAL);
    for (i = 0; i < json_array_size(lamps) && i < TTF_SHOT_LAMPS_MAX; i++) {
        lamp = &shot->lamps[shot->n_lamps++];
        l = json_array_get(lamps, i);
        ttf_in_text(in, l, "name", lamp->name, sizeof(lamp->name), TTF_JSON_CUT);
        lamp->commanded_permille =
            (int)ttf_in_int(in, l, "commanded_permille", 0, 1000, 0, TTF_JSON_OPTIONAL);
        lamp->measured_permille =
            (int)ttf_in_int(in, l, "measured_permille", 0, INT32_MAX, -1, TTF_JSON_OPTIONAL);
    }
}

static void get_flags(struct ttf_json_in *in, const json_t *o, struct ttf_image *image)
{
    const json_t *flags = ttf_in_array(in, o, "flags", TTF_JSON_OPTIONAL);
    size_t i, used = 0, n;
    const char *word;

    for (i = 0; i < json_array_size(flags); i++) {
        word = json_string_value(json_array_get(flags, i));
        n = word ? strlen(word) : 0;
        if (n == 0 || used + n + 2 > sizeof(image->flags))
            continue;
        if (used > 0)
            image->flags[used++] = ',';
        memcpy(image->flags + used, word, n + 1);
        used += n;
    }
}

static bool role_known(const char *role)
{
    return strcmp(role, "developed") == 0 || strcmp(role, "raw") == 0 ||
           strcmp(role, "uncertainty") == 0 || strcmp(role, "mask") == 0;
}

/* Known roles first; others as far as there is room. Those of later versions may have long names. */
static void get_files(struct ttf_json_in *in, const json_t *o, struct ttf_image *image)
{
    const json_t *files = ttf_in_array(in, o, "files", TTF_JSON_OPTIONAL), *f;
    struct ttf_file_ref *ref;
    const char *role;
    size_t i;
    int pass;

    for (pass = 0; pass < 2; pass++)
        for (i = 0; i < json_array_size(files) && image->n_files < TTF_IMAGE_FILES_MAX; i++) {
            f = json_array_get(files, i);
            role = json_string_value(json_object_get(f, "role"));
            if (!role) {
                ttf_in_wrong(in, "files", "has an entry without a role");
                return;
            }
            ref = &image->files[image->n_files];
            if (role_known(role) != (pass == 0) || strlen(role) >= sizeof(ref->role))
                continue;
            ttf_text_cut(ref->role, sizeof(ref->role), role);
            ttf_in_text(in, f, "path", ref->path, sizeof(ref->path), TTF_JSON_REQUIRED);
            ref->bytes = ttf_in_int(in, f, "bytes", 0, INT64_MAX, 0, TTF_JSON_REQUIRED);
            ttf_in_text(in, f, "sha256", ref->sha256, sizeof(ref->sha256), TTF_JSON_REQUIRED);
            image->n_files++;
        }
}

static void get_image(struct ttf_json_in *in, const json_t *o, struct ttf_image *image)
{
    const json_t *bracket, *shots;
    size_t i;

    ttf_in_text(in, o, "stream", image->stream, sizeof(image->stream), TTF_JSON_REQUIRED);
    bracket = ttf_in_object(in, o, "bracket", TTF_JSON_OPTIONAL);
    if (bracket) {
        image->bracket = (int)ttf_in_int(in, bracket, "index", 0, INT32_MAX, 0, TTF_JSON_REQUIRED);
        image->relative_exposure =
            ttf_in_double(in, bracket, "relative_exposure", 0, TTF_JSON_OPTIONAL);
        if (image->relative_exposure < 0 ||
            (image->relative_exposure == 0 && json_object_get(bracket, "relative_exposure")))
            ttf_in_wrong(in, "bracket.relative_exposure", "must be more than 0");
    }
    ttf_in_text(in, o, "lacking", image->lacking, sizeof(image->lacking), TTF_JSON_CUT);
    shots = ttf_in_array(in, o, "shots", TTF_JSON_OPTIONAL);
    if (!in->code && ttf_image_shots(image, (unsigned)json_array_size(shots)) != 0)
        in->code = ttf_err_set(in->err, -ENOMEM, in->where, "no memory for its shots");
    for (i = 0; !in->code && i < json_array_size(shots); i++)
        get_shot(in, json_array_get(shots, i), &image->shots[i]);
    image->n_averaged =
        (unsigned)ttf_in_int(in, o, "n_averaged", 1, UINT32_MAX, 0, TTF_JSON_OPTIONAL);
    ttf_in_text(in, o, "calibration", image->calibration, sizeof(image->calibration),
                TTF_JSON_OPTIONAL);
    get_files(in, o, image);
    image->mean_level = ttf_in_double(in, o, "mean_level", NAN, TTF_JSON_OPTIONAL);
    image->reference_level = ttf_in_double(in, o, "reference_level", NAN, TTF_JSON_OPTIONAL);
    image->sharpness = ttf_in_double(in, o, "sharpness", NAN, TTF_JSON_OPTIONAL);
    get_flags(in, o, image);
}

static void get_sensors(struct ttf_json_in *in, const json_t *o, struct ttf_slot_record *record)
{
    const json_t *sensors = ttf_in_array(in, o, "sensors", TTF_JSON_OPTIONAL), *s;
    struct ttf_slot_sensor *sensor;
    size_t i;

    for (i = 0; i < json_array_size(sensors) && i < TTF_SLOT_SENSORS_MAX; i++) {
        sensor = &record->sensors[record->n_sensors++];
        s = json_array_get(sensors, i);
        ttf_in_at(in, "sensors[%zu].", i);
        ttf_in_text(in, s, "name", sensor->name, sizeof(sensor->name), TTF_JSON_CUT);
        ttf_in_text(in, s, "kind", sensor->kind, sizeof(sensor->kind), TTF_JSON_CUT);
        sensor->ok = ttf_in_bool(in, s, "ok", false, TTF_JSON_REQUIRED);
        sensor->value = ttf_in_int(in, s, "value", INT64_MIN, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    }
    in->at[0] = '\0';
}

static void get_brief(struct ttf_json_in *in, const json_t *o, struct ttf_slot_brief *brief)
{
    char result[32];
    int found;

    brief->index = ttf_in_int(in, o, "index", 0, INT64_MAX - 1, 0, TTF_JSON_REQUIRED);
    brief->segment = (int)ttf_in_int(in, o, "segment", 0, INT32_MAX, 0, TTF_JSON_REQUIRED);
    brief->due_ns = ttf_in_int(in, o, "due_ns", INT64_MIN, INT64_MAX, 0, TTF_JSON_REQUIRED);
    ttf_in_text(in, o, "result", result, sizeof(result), TTF_JSON_REQUIRED);
    found = ttf_result_find(result);
    if (found < 0)
        ttf_in_wrong(in, "result", "is \"%s\", which is none", result);
    else
        brief->result = (enum ttf_result)found;
}

int ttf_slot_get_brief(const struct ttf_line *line, struct ttf_slot_brief *ret, struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);

    get_brief(&in, line->json, ret);
    return in.code;
}

int ttf_slot_get(const struct ttf_line *line, struct ttf_slot_record *ret, struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);
    struct ttf_slot_record record;
    struct ttf_slot_brief brief = {0};
    const json_t *images;
    size_t i;

    ttf_slot_record_init(&record);
    get_brief(&in, line->json, &brief);
    record.index = brief.index;
    record.segment = brief.segment;
    record.due_ns = brief.due_ns;
    record.result = brief.result;
    record.middle_ns = get_instant(&in, line->json, "middle_ns");
    ttf_in_text(&in, line->json, "reason", record.reason, sizeof(record.reason), TTF_JSON_CUT);
    images = ttf_in_array(&in, line->json, "images", TTF_JSON_OPTIONAL);
    if (!in.code && ttf_slot_record_images(&record, (unsigned)json_array_size(images)) != 0)
        in.code = ttf_err_set(err, -ENOMEM, line->where, "no memory for its images");
    for (i = 0; !in.code && i < json_array_size(images); i++) {
        ttf_in_at(&in, "images[%zu].", i);
        get_image(&in, json_array_get(images, i), &record.images[i]);
    }
    in.at[0] = '\0';
    get_sensors(&in, line->json, &record);
    if (in.code) {
        ttf_slot_record_free(&record);
        return in.code;
    }
    *ret = record;
    return 0;
}

int ttf_segment_get(const struct ttf_line *line, struct ttf_segment *ret, struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);
    const json_t *o = line->json;
    struct ttf_segment s = {0};

    s.segment = (int)ttf_in_int(&in, o, "segment", 0, INT32_MAX - 1, 0, TTF_JSON_REQUIRED);
    s.corrects = ttf_in_bool(&in, o, "corrects", false, TTF_JSON_OPTIONAL);
    s.first_index = ttf_in_int(&in, o, "first_index", 0, INT64_MAX - 1, 0, TTF_JSON_REQUIRED);
    ttf_in_text(&in, o, "boot_id", s.boot_id, sizeof(s.boot_id), TTF_JSON_CUT);
    s.origin_ns = ttf_in_int(&in, o, "origin_ns", INT64_MIN, INT64_MAX, 0, TTF_JSON_REQUIRED);
    s.origin_utc_ns = get_instant(&in, o, "origin_utc_ns");
    ttf_in_text(&in, o, "trust", s.trust, sizeof(s.trust), TTF_JSON_CUT);
    if (s.trust[0] == '\0')
        ttf_in_wrong(&in, "trust", "is missing");
    s.uncertainty_ns = get_instant(&in, o, "uncertainty_ns");
    s.interval_ns = ttf_in_int(&in, o, "interval_ns", 0, INT64_MAX, 0, TTF_JSON_REQUIRED);
    s.plan = (int)ttf_in_int(&in, o, "plan", 0, INT32_MAX, -1, TTF_JSON_OPTIONAL);
    ttf_in_text(&in, o, "zone", s.zone, sizeof(s.zone), TTF_JSON_CUT);
    s.zone_offset_s = (int)ttf_in_int(&in, o, "zone_offset_s", -86400, 86400, 0, TTF_JSON_OPTIONAL);
    if (json_is_null(json_object_get(o, "gap_ns")))
        s.gap_ns = TTF_NS_UNKNOWN;
    else
        s.gap_ns = ttf_in_int(&in, o, "gap_ns", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    ttf_in_text(&in, o, "dataset_sha256", s.dataset_sha256, sizeof(s.dataset_sha256),
                TTF_JSON_OPTIONAL);
    if (s.dataset_sha256[0] && !ttf_sha256_is_hex(s.dataset_sha256))
        ttf_in_wrong(&in, "dataset_sha256", "must be 64 hex digits");
    s.run_ns = ttf_in_int(&in, o, "run_ns", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    s.run_utc_ns = ttf_in_int(&in, o, "run_utc_ns", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    ttf_in_text(&in, o, "run_trust", s.run_trust, sizeof(s.run_trust), TTF_JSON_CUT);
    s.run_gaps_ns = get_instant(&in, o, "run_gaps_ns");
    s.run_doubted_ns = ttf_in_int(&in, o, "run_doubted_ns", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    s.run_given_up_ns = ttf_in_int(&in, o, "run_given_up_ns", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    ttf_in_text(&in, o, "box", s.box, sizeof(s.box), TTF_JSON_CUT);
    if (in.code == 0)
        *ret = s;
    return in.code;
}

int ttf_end_get(const struct ttf_line *line, struct ttf_end_record *ret, struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);
    const json_t *o = line->json;
    struct ttf_end_record e = {0};

    ttf_in_text(&in, o, "reason", e.reason, sizeof(e.reason), TTF_JSON_CUT);
    e.slots = ttf_in_int(&in, o, "slots", 0, INT64_MAX, 0, TTF_JSON_REQUIRED);
    e.captured = ttf_in_int(&in, o, "captured", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    e.partial = ttf_in_int(&in, o, "partial", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    e.missed = ttf_in_int(&in, o, "missed", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    e.failed = ttf_in_int(&in, o, "failed", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    e.paused = ttf_in_int(&in, o, "paused", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    e.power = ttf_in_int(&in, o, "power", 0, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    if (in.code == 0)
        *ret = e;
    return in.code;
}

static int plan_number(struct ttf_json_in *in, const struct ttf_line *line)
{
    return (int)ttf_in_int(in, line->json, "plan", 0, INT32_MAX - 1, 0, TTF_JSON_REQUIRED);
}

int ttf_plan_number(const struct ttf_line *line, int *ret, struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);
    int number = plan_number(&in, line);

    if (in.code == 0)
        *ret = number;
    return in.code;
}

int ttf_plan_get(const struct ttf_line *line, int *ret_number, struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);
    int number = plan_number(&in, line);

    ttf_in_array(&in, line->json, "files", TTF_JSON_REQUIRED);
    if (in.code == 0)
        *ret_number = number;
    return in.code;
}

int ttf_calibration_get(const struct ttf_line *line, char ret_id[64], struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);

    ttf_in_text(&in, line->json, "id", ret_id, 64, TTF_JSON_REQUIRED);
    ttf_in_array(&in, line->json, "files", TTF_JSON_REQUIRED);
    return in.code;
}

static int files_of(struct ttf_json_in *in, const json_t *owner, bool of_image,
                    ttf_named_file_fn *fn, void *ctx)
{
    const json_t *files = ttf_in_array(in, owner, "files", TTF_JSON_OPTIONAL), *f;
    struct ttf_named_file file = {.of_image = of_image};
    size_t i;
    int r;

    for (i = 0; !in->code && i < json_array_size(files); i++) {
        f = json_array_get(files, i);
        file.path = json_string_value(json_object_get(f, "path"));
        file.sha256 = json_string_value(json_object_get(f, "sha256"));
        file.bytes = ttf_in_int(in, f, "bytes", 0, INT64_MAX, 0, TTF_JSON_REQUIRED);
        if (!file.path || strlen(file.path) >= sizeof(((struct ttf_file_ref *)0)->path) ||
            !ttf_path_ok(file.path))
            ttf_in_wrong(in, "files", "has an entry whose path does not lie in the dataset");
        else if (!file.sha256 || !ttf_sha256_is_hex(file.sha256))
            ttf_in_wrong(in, "files", "has an entry without a sha256 of 64 hex digits");
        if (in->code)
            break;
        r = fn(ctx, &file, in->err);
        if (r)
            return r;
    }
    return in->code;
}

/* A segment vouches for dataset.json, so that it is guarded before there is a seal. */
static int manifest_of(struct ttf_json_in *in, const json_t *segment, ttf_named_file_fn *fn,
                       void *ctx)
{
    struct ttf_named_file file = {.path = "dataset.json", .bytes = -1};

    file.sha256 = json_string_value(json_object_get(segment, "dataset_sha256"));
    return file.sha256 && ttf_sha256_is_hex(file.sha256) ? fn(ctx, &file, in->err) : 0;
}

int ttf_line_files(const struct ttf_line *line, ttf_named_file_fn *fn, void *ctx,
                   struct ttf_err *err)
{
    struct ttf_json_in in = reading(line, err);
    const json_t *images;
    size_t i;
    int r;

    if (strcmp(line->type, "plan") == 0 || strcmp(line->type, "calibration") == 0)
        return files_of(&in, line->json, false, fn, ctx);
    if (strcmp(line->type, "segment") == 0)
        return manifest_of(&in, line->json, fn, ctx);
    if (strcmp(line->type, "slot") != 0)
        return 0; /* of a later version: its `files` may be anything */
    images = ttf_in_array(&in, line->json, "images", TTF_JSON_OPTIONAL);
    for (i = 0; !in.code && i < json_array_size(images); i++) {
        ttf_in_at(&in, "images[%zu].", i);
        r = files_of(&in, json_array_get(images, i), true, fn, ctx);
        if (r)
            return r;
    }
    return in.code;
}
