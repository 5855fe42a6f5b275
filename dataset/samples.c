/* SPDX-License-Identifier: Apache-2.0 */
/* samples.c: samples.json changed: what nobody asked to change stays as people wrote it. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "people_file.h"
#include "samples_private.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/manifest.h"

/* What is there, and what is asked of it. */
struct changing {
    const char *path;
    const struct ttf_sample_change *changes;
    unsigned n_changes;
    struct ttf_sample_region *samples;
    unsigned n;
    json_t *root; /* NULL: there is no file yet */
};

static const struct ttf_sample_change *change_of(const struct changing *c, const char *id)
{
    for (unsigned i = 0; i < c->n_changes; i++)
        if (strcmp(c->changes[i].id, id) == 0)
            return &c->changes[i];
    return NULL;
}

/* ---- what is refused ---- */

static int check_text(const char *id, const char *field, const char *text, size_t room,
                      struct ttf_err *err)
{
    if (!text)
        return 0;
    if (strlen(text) >= room)
        return ttf_err_set(err, -EINVAL, field, "of sample '%.63s': longer than %zu bytes", id,
                           room - 1);
    for (const char *at = text; *at; at++)
        if ((unsigned char)*at < ' ' || *at == 0x7f)
            return ttf_err_set(err, -EINVAL, field, "of sample '%.63s': has a control character",
                               id);
    return 0;
}

static int check(const struct ttf_sample_change *changes, unsigned n, struct ttf_err *err)
{
    int r = 0;

    for (unsigned i = 0; r == 0 && i < n; i++) {
        const struct ttf_sample_change *c = &changes[i];

        if (!c->id || c->id[0] == '\0')
            return ttf_err_set(err, -EINVAL, "id", "a sample needs one");
        for (unsigned other = 0; other < i; other++)
            if (strcmp(changes[other].id, c->id) == 0)
                return ttf_err_set(err, -EINVAL, "id", "'%.63s' is named twice", c->id);
        r = check_text(c->id, "id", c->id, sizeof(((struct ttf_sample_region *)0)->id), err);
        if (r == 0)
            r = check_text(c->id, "title", c->title, sizeof(((struct ttf_sample_region *)0)->title),
                           err);
        if (r == 0)
            r = check_text(c->id, "treatment", c->treatment,
                           sizeof(((struct ttf_sample_region *)0)->treatment), err);
    }
    return r;
}

/* Beside what is there: what is new has a region, what goes is there, and all lie in the picture. */
static int check_beside(const struct changing *c, struct ttf_io *io, struct ttf_err *err)
{
    struct ttf_manifest *manifest = malloc(sizeof(*manifest));
    const struct ttf_stream *primary = NULL;
    unsigned n = c->n;
    int r = manifest ? ttf_manifest_load(io, c->path, manifest, err)
                     : ttf_err_set(err, -ENOMEM, c->path, "no memory");

    if (r == 0)
        primary = ttf_manifest_primary(manifest);
    for (unsigned i = 0; r == 0 && i < c->n_changes; i++) {
        const struct ttf_sample_change *change = &c->changes[i];
        bool there = ttf_samples_find(c->samples, c->n, change->id) != NULL;

        if (change->remove && !there)
            r = ttf_err_set(err, -ENOENT, change->id, "there is no sample of this id");
        else if (!change->remove && !there && !change->region)
            r = ttf_err_set(err, -EINVAL, change->id, "is new, and needs a region");
        else if (!there && ++n > TTF_SAMPLES_MAX)
            r = ttf_err_set(err, -EINVAL, change->id, "more than %d samples", TTF_SAMPLES_MAX);
        else if (change->region && primary &&
                 !ttf_sample_rect_is_within(change->region, primary->width, primary->height))
            r = ttf_err_set(err, -EINVAL, change->id,
                            "its region reaches outside of the picture, which has %u x %u pixels",
                            primary->width, primary->height);
    }
    free(manifest);
    return r;
}

/* ---- what is written ---- */

static void put_value(struct ttf_json *j, const json_t *value);

static void put_fields(struct ttf_json *j, const json_t *object, const char *const *but)
{
    const char *key;
    json_t *value;

    json_object_foreach((json_t *)object, key, value)
    {
        const char *const *known = but;

        while (*known && strcmp(*known, key) != 0)
            known++;
        if (*known)
            continue;
        ttf_json_key(j, key);
        put_value(j, value);
    }
}

static void put_value(struct ttf_json *j, const json_t *value)
{
    static const char *const none[] = {NULL};

    if (j->error) /* nested deeper than anybody writes: no further */
        return;
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        ttf_json_object(j);
        put_fields(j, value, none);
        ttf_json_object_end(j);
        break;
    case JSON_ARRAY:
        ttf_json_array(j);
        for (size_t i = 0; i < json_array_size(value); i++)
            put_value(j, json_array_get(value, i));
        ttf_json_array_end(j);
        break;
    case JSON_STRING:
        ttf_json_string(j, json_string_value(value));
        break;
    case JSON_INTEGER:
        ttf_json_int(j, json_integer_value(value));
        break;
    case JSON_REAL:
        ttf_json_double(j, json_real_value(value));
        break;
    case JSON_TRUE:
    case JSON_FALSE:
        ttf_json_bool(j, json_is_true(value));
        break;
    case JSON_NULL:
        ttf_json_null(j);
        break;
    }
}

static void put_text(struct ttf_json *j, const char *key, const char *text, const json_t *was)
{
    const json_t *value = was ? json_object_get(was, key) : NULL;

    if (text && text[0])
        ttf_json_kstring(j, key, text);
    if (text || !value)
        return;
    ttf_json_key(j, key);
    put_value(j, value);
}

static void put_region(struct ttf_json *j, const struct ttf_sample_rect *region, const json_t *was)
{
    static const char *const known[] = {"x", "y", "width", "height", NULL};

    ttf_json_key(j, "region");
    if (!region) {
        put_value(j, was);
        return;
    }
    ttf_json_object(j);
    ttf_json_kint(j, "x", region->x);
    ttf_json_kint(j, "y", region->y);
    ttf_json_kint(j, "width", region->width);
    ttf_json_kint(j, "height", region->height);
    if (was)
        put_fields(j, was, known);
    ttf_json_object_end(j);
}

/* As it is asked for; was: as it stood there, NULL of a new one. */
static void put_changed(struct ttf_json *j, const struct ttf_sample_change *change,
                        const json_t *was)
{
    static const char *const known[] = {"id", "title", "region", "treatment", NULL};

    ttf_json_object(j);
    ttf_json_kstring(j, "id", change->id);
    put_text(j, "title", change->title, was);
    put_region(j, change->region, was ? json_object_get(was, "region") : NULL);
    put_text(j, "treatment", change->treatment, was);
    if (was)
        put_fields(j, was, known);
    ttf_json_object_end(j);
}

static void put_all(struct ttf_json *j, const struct changing *c)
{
    static const char *const known[] = {"samples", NULL};
    const json_t *list = c->root ? json_object_get(c->root, "samples") : NULL;

    ttf_json_object(j);
    ttf_json_key(j, "samples");
    ttf_json_array(j);
    for (unsigned i = 0; i < c->n; i++) {
        const struct ttf_sample_change *change = change_of(c, c->samples[i].id);
        const json_t *was = json_array_get(list, i);

        if (!change)
            put_value(j, was);
        else if (!change->remove)
            put_changed(j, change, was);
    }
    for (unsigned i = 0; i < c->n_changes; i++)
        if (!ttf_samples_find(c->samples, c->n, c->changes[i].id))
            put_changed(j, &c->changes[i], NULL);
    ttf_json_array_end(j);
    if (c->root)
        put_fields(j, c->root, known);
    ttf_json_object_end(j);
}

/* ---- the file ---- */

static int read_old(struct changing *c, struct ttf_io *io, int old, int64_t bytes,
                    struct ttf_err *err)
{
    char *text;
    int64_t n;
    int r;

    if (old < 0)
        return 0;
    if (bytes > (int64_t)TTF_SAMPLES_BYTES_MAX)
        return ttf_err_set(err, -EINVAL, "samples.json", "is longer than %zu bytes",
                           TTF_SAMPLES_BYTES_MAX);
    text = malloc((size_t)bytes + 1);
    if (!text)
        return ttf_err_set(err, -ENOMEM, "samples.json", "no memory");
    n = ttf_io_pread_all(io, old, text, (size_t)bytes, 0);
    if (n != bytes)
        r = n < 0 ? (int)n : -EAGAIN; /* it became shorter meanwhile */
    else
        r = ttf_samples_parse(text, (size_t)bytes, &c->samples, &c->n, &c->root, err);
    free(text);
    if (r == -EINVAL)
        ttf_err_hint(err, "mend samples.json, or remove it, first");
    return r;
}

static int fill(void *ctx, struct ttf_io *io, int old, int64_t bytes, int file, struct ttf_err *err)
{
    struct changing *c = ctx;
    struct ttf_json json;
    char *text = NULL;
    size_t n = 0;
    int r = read_old(c, io, old, bytes, err);

    if (r == 0)
        r = check_beside(c, io, err);
    if (r)
        return r;
    ttf_json_init(&json, true); /* people mend it by hand */
    put_all(&json, c);
    r = ttf_json_take(&json, &text, &n);
    if (r)
        ttf_err_set(err, r, "samples.json", "cannot be put into words: %s", strerrordesc_np(-r));
    else if (n > TTF_SAMPLES_BYTES_MAX)
        r = ttf_err_set(err, -EINVAL, "samples.json", "would be longer than %zu bytes",
                        TTF_SAMPLES_BYTES_MAX);
    else
        r = ttf_io_append_all(io, file, text, n);
    free(text);
    return r;
}

int ttf_samples_change(struct ttf_io *io, const char *path, const struct ttf_sample_change *changes,
                       unsigned n, struct ttf_err *err)
{
    static const struct ttf_people_file file = {
        .name = "samples.json", .fresh = ".samples-new", .addition = "the sample", .fill = fill};
    struct changing c = {.path = path, .changes = changes, .n_changes = n};
    int r = check(changes, n, err);

    if (r == 0)
        r = ttf_people_file_replace(io, path, &file, &c, err);
    json_decref(c.root);
    free(c.samples);
    return r;
}
