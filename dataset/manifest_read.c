/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include "json_read.h"
#include "manifest_rules.h"
#include "ttf/dataset/json_parse.h"

/* Names of `required` that this reader knows: none yet in version 1.0. */
static int check_required(const json_t *format, const char *where, struct ttf_err *err)
{
    const json_t *required = json_object_get(format, "required");
    const char *name;

    if (!required || json_array_size(required) == 0)
        return 0;
    name = json_string_value(json_array_get(required, 0));
    ttf_err_set(err, -ENOTSUP, where,
                "format.required names \"%s\", which this version does not know",
                name ? name : "?");
    ttf_err_hint(err, "read it with a newer version");
    return -ENOTSUP;
}

static int check_format(struct ttf_json_in *in, const json_t *root)
{
    const json_t *format = ttf_in_object(in, root, "format", TTF_JSON_REQUIRED);
    char name[16];
    int64_t major;

    ttf_in_at(in, "format.");
    ttf_in_text(in, format, "name", name, sizeof(name), TTF_JSON_REQUIRED);
    major = ttf_in_int(in, format, "major", 0, INT32_MAX, 0, TTF_JSON_REQUIRED);
    ttf_in_int(in, format, "minor", 0, INT32_MAX, 0, TTF_JSON_REQUIRED);
    ttf_in_array(in, format, "required", TTF_JSON_OPTIONAL);
    if (in->code)
        return in->code;
    if (strcmp(name, "ttf") != 0) {
        ttf_in_wrong(in, "name", "is \"%s\", but must be \"ttf\"", name);
        return in->code;
    }
    if (major != TTF_FORMAT_MAJOR) {
        ttf_err_set(in->err, -ENOTSUP, in->where,
                    "format.major is %lld; this version reads major %d only", (long long)major,
                    TTF_FORMAT_MAJOR);
        ttf_err_hint(in->err, "read it with a newer version");
        return -ENOTSUP;
    }
    in->at[0] = '\0';
    return check_required(format, in->where, in->err);
}

static void get_cameras(struct ttf_json_in *in, const json_t *root, struct ttf_manifest *m)
{
    const json_t *array = ttf_in_array(in, root, "cameras", TTF_JSON_OPTIONAL);
    size_t i;

    if (json_array_size(array) > TTF_CAMERAS_MAX)
        ttf_in_wrong(in, "cameras", "has more than %d", TTF_CAMERAS_MAX);
    for (i = 0; !in->code && i < json_array_size(array); i++) {
        const json_t *o = json_array_get(array, i);
        struct ttf_dataset_camera *c = &m->cameras[i];

        ttf_in_at(in, "cameras[%zu].", i);
        ttf_in_text(in, o, "id", c->id, sizeof(c->id), TTF_JSON_REQUIRED);
        ttf_in_text(in, o, "model", c->model, sizeof(c->model), TTF_JSON_CUT);
        c->raw_width = (uint32_t)ttf_in_int(in, o, "raw_width", 1, 65535, 0, TTF_JSON_OPTIONAL);
        c->raw_height = (uint32_t)ttf_in_int(in, o, "raw_height", 1, 65535, 0, TTF_JSON_OPTIONAL);
        ttf_in_text(in, o, "cfa", c->cfa, sizeof(c->cfa), TTF_JSON_CUT);
        c->raw_bits = (unsigned)ttf_in_int(in, o, "raw_bits", 1, 64, 0, TTF_JSON_OPTIONAL);
        m->n_cameras++;
    }
    in->at[0] = '\0';
}

static void get_channels(struct ttf_json_in *in, const json_t *root, struct ttf_manifest *m)
{
    const json_t *array = ttf_in_array(in, root, "channels", TTF_JSON_OPTIONAL);
    size_t i;

    if (json_array_size(array) > TTF_CHANNELS_MAX)
        ttf_in_wrong(in, "channels", "has more than %d", TTF_CHANNELS_MAX);
    for (i = 0; !in->code && i < json_array_size(array); i++) {
        const json_t *o = json_array_get(array, i);
        struct ttf_channel *c = &m->channels[i];

        ttf_in_at(in, "channels[%zu].", i);
        ttf_in_text(in, o, "id", c->id, sizeof(c->id), TTF_JSON_REQUIRED);
        ttf_in_text(in, o, "title", c->title, sizeof(c->title), TTF_JSON_CUT);
        m->n_channels++;
    }
    in->at[0] = '\0';
}

/* False: a stream of samples that this version does not know, left out. */
static bool get_stream(struct ttf_json_in *in, const json_t *o, struct ttf_stream *s)
{
    const json_t *encoding;
    char format[16];
    int found;

    ttf_in_text(in, o, "id", s->id, sizeof(s->id), TTF_JSON_REQUIRED);
    s->primary = ttf_in_bool(in, o, "primary", false, TTF_JSON_OPTIONAL);
    ttf_in_text(in, o, "sample_format", format, sizeof(format), TTF_JSON_REQUIRED);
    found = ttf_sample_find(format);
    if (found < 0) {
        if (s->primary)
            ttf_in_wrong(in, "sample_format", "is \"%s\", which is unknown", format);
        return false;
    }
    s->format = (enum ttf_sample)found;
    ttf_in_text(in, o, "camera", s->camera, sizeof(s->camera), TTF_JSON_OPTIONAL);
    ttf_in_text(in, o, "channel", s->channel, sizeof(s->channel), TTF_JSON_OPTIONAL);
    ttf_in_text(in, o, "quantity", s->quantity, sizeof(s->quantity), TTF_JSON_REQUIRED);
    ttf_in_text(in, o, "unit", s->unit, sizeof(s->unit), TTF_JSON_OPTIONAL);
    if (s->unit[0] == '\0')
        memcpy(s->unit, "1", 2);
    s->width = (uint32_t)ttf_in_int(in, o, "width", 1, 65535, 0, TTF_JSON_REQUIRED);
    s->height = (uint32_t)ttf_in_int(in, o, "height", 1, 65535, 0, TTF_JSON_REQUIRED);
    s->samples = (uint32_t)ttf_in_int(in, o, "samples", 1, 255, 0, TTF_JSON_REQUIRED);
    encoding = ttf_in_object(in, o, "encoding", TTF_JSON_REQUIRED);
    s->encoding.pedestal = ttf_in_double(in, encoding, "pedestal", 0, TTF_JSON_REQUIRED);
    s->encoding.scale = ttf_in_double(in, encoding, "scale", 0, TTF_JSON_REQUIRED);
    ttf_in_text(in, o, "colour_space", s->colour_space, sizeof(s->colour_space), TTF_JSON_OPTIONAL);
    if (s->colour_space[0] == '\0')
        memcpy(s->colour_space, "none", 5);
    s->mm_per_px = ttf_in_double(in, o, "mm_per_px", 0, TTF_JSON_OPTIONAL);
    return true;
}

static void get_streams(struct ttf_json_in *in, const json_t *root, struct ttf_manifest *m)
{
    const json_t *array = ttf_in_array(in, root, "streams", TTF_JSON_REQUIRED);
    size_t i;

    if (json_array_size(array) > TTF_STREAMS_MAX)
        ttf_in_wrong(in, "streams", "has more than %d", TTF_STREAMS_MAX);
    for (i = 0; !in->code && i < json_array_size(array); i++) {
        struct ttf_stream *s = &m->streams[m->n_streams];

        ttf_in_at(in, "streams[%zu].", i);
        if (get_stream(in, json_array_get(array, i), s))
            m->n_streams++;
        else
            memset(s, 0, sizeof(*s));
    }
    in->at[0] = '\0';
}

static void get_origin(struct ttf_json_in *in, const json_t *root, struct ttf_manifest *m)
{
    const json_t *group = ttf_in_object(in, root, "group", TTF_JSON_OPTIONAL);
    const json_t *parent = ttf_in_object(in, root, "derived_from", TTF_JSON_OPTIONAL);

    ttf_in_text(in, root, "source", m->source, sizeof(m->source), TTF_JSON_CUT);
    ttf_in_at(in, "group.");
    if (group) {
        ttf_in_text(in, group, "uuid", m->group_uuid, sizeof(m->group_uuid), TTF_JSON_REQUIRED);
        ttf_in_text(in, group, "member", m->group_member, sizeof(m->group_member), TTF_JSON_CUT);
    }
    ttf_in_at(in, "derived_from.");
    if (parent) {
        ttf_in_text(in, parent, "uuid", m->derived_uuid, sizeof(m->derived_uuid),
                    TTF_JSON_OPTIONAL);
        ttf_in_text(in, parent, "digest", m->derived_digest, sizeof(m->derived_digest),
                    TTF_JSON_OPTIONAL);
        ttf_in_text(in, parent, "command", m->derived_command, sizeof(m->derived_command),
                    TTF_JSON_CUT);
        m->has_derived_seed = json_is_integer(json_object_get(parent, "seed"));
        m->derived_seed =
            ttf_in_int(in, parent, "seed", INT64_MIN, INT64_MAX, 0, TTF_JSON_OPTIONAL);
    }
    in->at[0] = '\0';
}

int ttf_manifest_read(const char *text, size_t bytes, const char *where, struct ttf_manifest *ret,
                      struct ttf_err *err)
{
    struct ttf_json_in in = {.where = where, .wrong = -EINVAL, .err = err};
    struct ttf_manifest m;
    json_error_t parse;
    json_t *root;
    int r;

    r = ttf_json_parse(text, bytes, &root, &parse);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, where, "no memory");
    if (r)
        return ttf_err_set(err, -EINVAL, where, "is not JSON (line %d): %s", parse.line,
                           parse.text);
    memset(&m, 0, sizeof(m));
    r = check_format(&in, root);
    if (r)
        goto out;
    ttf_in_text(&in, root, "uuid", m.uuid, sizeof(m.uuid), TTF_JSON_REQUIRED);
    ttf_in_text(&in, root, "title", m.title, sizeof(m.title), TTF_JSON_CUT);
    m.simulated = ttf_in_bool(&in, root, "simulated", false, TTF_JSON_REQUIRED);
    m.rehearsal = ttf_in_bool(&in, root, "rehearsal", false, TTF_JSON_OPTIONAL);
    ttf_in_text(&in, root, "box_serial", m.box_serial, sizeof(m.box_serial), TTF_JSON_CUT);
    ttf_in_text(&in, root, "software", m.software, sizeof(m.software), TTF_JSON_CUT);
    get_cameras(&in, root, &m);
    get_channels(&in, root, &m);
    get_streams(&in, root, &m);
    get_origin(&in, root, &m);
    r = in.code ? in.code : ttf_manifest_check(&m, where, err);
    if (r == 0)
        *ret = m;
out:
    json_decref(root);
    return r;
}
