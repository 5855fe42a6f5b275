/* SPDX-License-Identifier: Apache-2.0 */
/* dataset.json: making one, and the rules that hold for every one (FORMAT.md, dataset.json). */
#include "ttf/dataset/manifest.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

#include "manifest_rules.h"
#include "ttf/dataset/hash.h"

int ttf_manifest_init(struct ttf_manifest *manifest, struct ttf_err *err)
{
    uint8_t b[16];

    memset(manifest, 0, sizeof(*manifest));
    if (getrandom(b, sizeof(b), 0) != (ssize_t)sizeof(b))
        return ttf_err_set(err, -EIO, NULL, "the kernel gives no random numbers");
    b[6] = (uint8_t)((b[6] & 0x0f) | 0x40); /* RFC 4122, version 4 */
    b[8] = (uint8_t)((b[8] & 0x3f) | 0x80);
    snprintf(manifest->uuid, sizeof(manifest->uuid),
             "%02x%02x%02x%02x-%02x%02x-%02x%02x-%02x%02x-%02x%02x%02x%02x%02x%02x", b[0], b[1],
             b[2], b[3], b[4], b[5], b[6], b[7], b[8], b[9], b[10], b[11], b[12], b[13], b[14],
             b[15]);
    snprintf(manifest->software, sizeof(manifest->software), "ttfbox %s", TTFBOX_VERSION);
    return 0;
}

const struct ttf_stream *ttf_manifest_primary(const struct ttf_manifest *manifest)
{
    unsigned i;

    for (i = 0; i < manifest->n_streams; i++)
        if (manifest->streams[i].primary)
            return &manifest->streams[i];
    return manifest->n_streams ? &manifest->streams[0] : NULL;
}

const char *ttf_manifest_group(const struct ttf_manifest *manifest)
{
    return manifest->group_uuid[0] ? manifest->group_uuid : manifest->uuid;
}

const struct ttf_stream *ttf_manifest_stream(const struct ttf_manifest *manifest, const char *id)
{
    unsigned i;

    for (i = 0; i < manifest->n_streams; i++)
        if (strcmp(manifest->streams[i].id, id) == 0)
            return &manifest->streams[i];
    return NULL;
}

static bool is_of(const char *text, const char *allowed)
{
    return text[0] != '\0' && text[strspn(text, allowed)] == '\0';
}

bool ttf_name_ok(const char *name)
{
    return is_of(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") &&
           strlen(name) <= 64 && strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
}

bool ttf_path_ok(const char *path)
{
    char part[192];
    const char *slash;
    size_t n;

    if (strlen(path) >= sizeof(part))
        return false;
    for (;; path = slash + 1) {
        slash = strchr(path, '/');
        n = slash ? (size_t)(slash - path) : strlen(path);
        if (n >= sizeof(part))
            return false;
        memcpy(part, path, n);
        part[n] = '\0';
        if (!ttf_name_ok(part))
            return false;
        if (!slash)
            return true;
    }
}

static bool is_uuid(const char *text)
{
    size_t i;

    for (i = 0; i < 36; i++)
        if ((i == 8 || i == 13 || i == 18 || i == 23)
                ? text[i] != '-'
                : !strchr("0123456789abcdef", text[i]) || text[i] == '\0')
            return false;
    return text[36] == '\0';
}

static int wrong(struct ttf_err *err, const char *where, const char *what, unsigned i,
                 const char *rule)
{
    return ttf_err_set(err, -EINVAL, where, "%s[%u].%s", what, i, rule);
}

static int check_stream(const struct ttf_manifest *m, unsigned i, const char *where,
                        struct ttf_err *err)
{
    const struct ttf_stream *s = &m->streams[i];
    bool camera = s->camera[0] == '\0', channel = s->channel[0] == '\0';
    unsigned k;

    if (!is_of(s->id, "abcdefghijklmnopqrstuvwxyz0123456789-"))
        return wrong(err, where, "streams", i, "id must be of a-z, 0-9 and '-'");
    for (k = 0; k < i; k++)
        if (strcmp(m->streams[k].id, s->id) == 0)
            return wrong(err, where, "streams", i, "id is there twice");
    for (k = 0; k < m->n_cameras; k++)
        camera = camera || strcmp(m->cameras[k].id, s->camera) == 0;
    for (k = 0; k < m->n_channels; k++)
        channel = channel || strcmp(m->channels[k].id, s->channel) == 0;
    if (!camera)
        return wrong(err, where, "streams", i, "camera is not in cameras[]");
    if (!channel)
        return wrong(err, where, "streams", i, "channel is not in channels[]");
    if (s->quantity[0] == '\0')
        return wrong(err, where, "streams", i, "quantity is missing");
    if (s->width < 1 || s->width > 65535 || s->height < 1 || s->height > 65535)
        return wrong(err, where, "streams", i, "width and height must lie in 1..65535");
    if (s->samples < 1 || s->samples > 255)
        return wrong(err, where, "streams", i, "samples must lie in 1..255");
    if ((unsigned)s->format >= TTF_SAMPLE_COUNT)
        return wrong(err, where, "streams", i, "sample_format is unknown");
    if (!isfinite(s->encoding.pedestal) || !isfinite(s->encoding.scale) || s->encoding.scale == 0.0)
        return wrong(err, where, "streams", i,
                     "encoding needs a pedestal and a scale other than 0");
    if (!isfinite(s->mm_per_px) || s->mm_per_px < 0)
        return wrong(err, where, "streams", i, "mm_per_px must be 0 or more");
    return 0;
}

int ttf_manifest_check(const struct ttf_manifest *m, const char *where, struct ttf_err *err)
{
    unsigned i, k, primaries = 0;
    int r;

    if (!is_uuid(m->uuid))
        return ttf_err_set(err, -EINVAL, where, "uuid must be a lower-case UUID");
    if (m->n_streams < 1 || m->n_streams > TTF_STREAMS_MAX || m->n_cameras > TTF_CAMERAS_MAX ||
        m->n_channels > TTF_CHANNELS_MAX)
        return ttf_err_set(err, -EINVAL, where,
                           "streams must be 1..%d, cameras 0..%d, channels 0..%d", TTF_STREAMS_MAX,
                           TTF_CAMERAS_MAX, TTF_CHANNELS_MAX);
    for (i = 0; i < m->n_cameras; i++) {
        if (!ttf_name_ok(m->cameras[i].id))
            return wrong(err, where, "cameras", i, "id must be a name");
        for (k = 0; k < i; k++)
            if (strcmp(m->cameras[k].id, m->cameras[i].id) == 0)
                return wrong(err, where, "cameras", i, "id is there twice");
    }
    for (i = 0; i < m->n_channels; i++) {
        if (!ttf_name_ok(m->channels[i].id))
            return wrong(err, where, "channels", i, "id must be a name");
        for (k = 0; k < i; k++)
            if (strcmp(m->channels[k].id, m->channels[i].id) == 0)
                return wrong(err, where, "channels", i, "id is there twice");
    }
    for (i = 0; i < m->n_streams; i++) {
        r = check_stream(m, i, where, err);
        if (r)
            return r;
        primaries += m->streams[i].primary;
    }
    if (primaries > 1)
        return ttf_err_set(err, -EINVAL, where, "streams: more than one is primary");
    if (m->group_uuid[0] && !is_uuid(m->group_uuid))
        return ttf_err_set(err, -EINVAL, where, "group.uuid must be a lower-case UUID");
    if (m->derived_uuid[0] && !is_uuid(m->derived_uuid))
        return ttf_err_set(err, -EINVAL, where, "derived_from.uuid must be a lower-case UUID");
    if (m->derived_digest[0] && !ttf_sha256_is_hex(m->derived_digest))
        return ttf_err_set(err, -EINVAL, where, "derived_from.digest must be 64 hex digits");
    return 0;
}
