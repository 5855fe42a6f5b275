/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include "manifest_rules.h"
#include "ttf/dataset/json_writer.h"

static void put_text(struct ttf_json *json, const char *key, const char *value)
{
    if (value[0] != '\0') /* what does not apply is absent */
        ttf_json_kstring(json, key, value);
}

static void put_positive(struct ttf_json *json, const char *key, int64_t value)
{
    if (value > 0)
        ttf_json_kint(json, key, value);
}

static void put_cameras(struct ttf_json *json, const struct ttf_manifest *m)
{
    const struct ttf_dataset_camera *c;

    ttf_json_key(json, "cameras");
    ttf_json_array(json);
    for (c = m->cameras; c < m->cameras + m->n_cameras; c++) {
        ttf_json_object(json);
        ttf_json_kstring(json, "id", c->id);
        put_text(json, "model", c->model);
        put_positive(json, "raw_width", c->raw_width);
        put_positive(json, "raw_height", c->raw_height);
        put_text(json, "cfa", c->cfa);
        put_positive(json, "raw_bits", c->raw_bits);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

static void put_channels(struct ttf_json *json, const struct ttf_manifest *m)
{
    const struct ttf_channel *c;

    ttf_json_key(json, "channels");
    ttf_json_array(json);
    for (c = m->channels; c < m->channels + m->n_channels; c++) {
        ttf_json_object(json);
        ttf_json_kstring(json, "id", c->id);
        put_text(json, "title", c->title);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

static void put_stream(struct ttf_json *json, const struct ttf_stream *s)
{
    ttf_json_object(json);
    ttf_json_kstring(json, "id", s->id);
    put_text(json, "camera", s->camera);
    put_text(json, "channel", s->channel);
    ttf_json_kstring(json, "quantity", s->quantity);
    ttf_json_kstring(json, "unit", s->unit[0] ? s->unit : "1");
    ttf_json_kint(json, "width", s->width);
    ttf_json_kint(json, "height", s->height);
    ttf_json_kint(json, "samples", s->samples);
    ttf_json_kstring(json, "sample_format", ttf_sample_name(s->format));
    ttf_json_key(json, "encoding");
    ttf_json_object(json);
    ttf_json_kdouble(json, "pedestal", s->encoding.pedestal);
    ttf_json_kdouble(json, "scale", s->encoding.scale);
    ttf_json_object_end(json);
    ttf_json_kstring(json, "colour_space", s->colour_space[0] ? s->colour_space : "none");
    if (s->mm_per_px > 0)
        ttf_json_kdouble(json, "mm_per_px", s->mm_per_px);
    if (s->primary)
        ttf_json_kbool(json, "primary", true);
    ttf_json_object_end(json);
}

static void put_origin(struct ttf_json *json, const struct ttf_manifest *m)
{
    if (m->group_uuid[0]) {
        ttf_json_key(json, "group");
        ttf_json_object(json);
        ttf_json_kstring(json, "uuid", m->group_uuid);
        put_text(json, "member", m->group_member);
        ttf_json_object_end(json);
    }
    put_text(json, "source", m->source);
    if (m->derived_uuid[0] || m->derived_command[0] || m->has_derived_seed) {
        ttf_json_key(json, "derived_from");
        ttf_json_object(json);
        put_text(json, "uuid", m->derived_uuid);
        put_text(json, "digest", m->derived_digest);
        put_text(json, "command", m->derived_command);
        if (m->has_derived_seed)
            ttf_json_kint(json, "seed", m->derived_seed);
        ttf_json_object_end(json);
    }
}

static void put_format(struct ttf_json *json)
{
    ttf_json_key(json, "format");
    ttf_json_object(json);
    ttf_json_kstring(json, "name", "ttf");
    ttf_json_kint(json, "major", TTF_FORMAT_MAJOR);
    ttf_json_kint(json, "minor", TTF_FORMAT_MINOR);
    ttf_json_key(json, "required");
    ttf_json_array(json);
    ttf_json_array_end(json);
    ttf_json_key(json, "optional");
    ttf_json_array(json);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
}

int ttf_manifest_write(const struct ttf_manifest *manifest, char **ret_text, struct ttf_err *err)
{
    struct ttf_json json;
    const char *text;
    unsigned i;
    int r;

    r = ttf_manifest_check(manifest, "dataset.json", err);
    if (r)
        return r;
    ttf_json_init(&json, true);
    ttf_json_object(&json);
    put_format(&json);
    ttf_json_kstring(&json, "uuid", manifest->uuid);
    put_text(&json, "title", manifest->title);
    ttf_json_kbool(&json, "simulated", manifest->simulated);
    if (manifest->rehearsal)
        ttf_json_kbool(&json, "rehearsal", true);
    put_text(&json, "box_serial", manifest->box_serial);
    put_text(&json, "software", manifest->software);
    put_cameras(&json, manifest);
    put_channels(&json, manifest);
    ttf_json_key(&json, "streams");
    ttf_json_array(&json);
    for (i = 0; i < manifest->n_streams; i++)
        put_stream(&json, &manifest->streams[i]);
    ttf_json_array_end(&json);
    put_origin(&json, manifest);
    ttf_json_object_end(&json);
    r = ttf_json_finish(&json, &text, NULL);
    if (r == 0) {
        *ret_text = json.text; /* now the caller's */
        return 0;
    }
    ttf_json_free(&json);
    return ttf_err_set(err, r, "dataset.json", "cannot be put into words: %s", strerrordesc_np(-r));
}
