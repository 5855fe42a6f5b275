/* SPDX-License-Identifier: Apache-2.0 */
/*
 * manifest.h: dataset.json, what is true of a whole dataset. FORMAT.md, section
 * "dataset.json". Written once, at the start.
 */
#ifndef TTF_DATASET_MANIFEST_H
#define TTF_DATASET_MANIFEST_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/pixbuf.h"

#define TTF_FORMAT_MAJOR 1
#define TTF_FORMAT_MINOR 1

#define TTF_STREAMS_MAX  16
#define TTF_CAMERAS_MAX  4
#define TTF_CHANNELS_MAX 16

struct ttf_dataset_camera {
    char id[32];
    char model[64];
    uint32_t raw_width, raw_height; /* 0 where there is no raw */
    char cfa[8];                    /* "RGGB", empty if none */
    unsigned raw_bits;
};

/* A lamp state or filter that streams are taken under. */
struct ttf_channel {
    char id[32]; /* "white", "raking-left", "ir-night" */
    char title[96];
};

struct ttf_stream {
    char id[32];      /* [a-z0-9-], unique; "main" of a plain capture */
    char camera[32];  /* a camera's id, empty if derived or imported */
    char channel[32]; /* a channel's id, empty if none */
    char quantity
        [32]; /* "reflectance", "radiance", "uncertainty", "displacement", "normals", "age", "init", "jump" */
    char unit[32]; /* of value; "1" if none */
    uint32_t width, height;
    uint32_t samples; /* per pixel */
    enum ttf_sample format;
    struct ttf_encoding encoding;
    char colour_space[32]; /* "linear-srgb", "camera", "none" */
    double mm_per_px;      /* 0: not known */
    bool primary;
};

struct ttf_manifest {
    char uuid[37];
    char box_serial[64];
    char software[64];
    char title[128];
    bool simulated;
    bool rehearsal; /* slots tried at once before a capture: never gone on with, never sealed */
    unsigned n_cameras, n_channels, n_streams;
    struct ttf_dataset_camera cameras[TTF_CAMERAS_MAX];
    struct ttf_channel channels[TTF_CHANNELS_MAX];
    struct ttf_stream streams[TTF_STREAMS_MAX];
    char group_uuid[37]; /* empty: of no group */
    char group_member[32];
    /* where it is not a capture */
    char source[256];        /* import: what it was made from; empty if not imported */
    char derived_uuid[37];   /* parent; empty if none */
    char derived_digest[65]; /* hex; empty while the parent is unsealed */
    char derived_command[256];
    int64_t derived_seed;
    bool has_derived_seed;
};

/* Zeroes it; a fresh random uuid (getrandom), the software's name and version. */
TTF_MUST_USE int ttf_manifest_init(struct ttf_manifest *manifest, struct ttf_err *err);

/* The stream marked primary, else the first; NULL if there is none. */
const struct ttf_stream *ttf_manifest_primary(const struct ttf_manifest *manifest);
const struct ttf_stream *ttf_manifest_stream(const struct ttf_manifest *manifest, const char *id);

/* The uuid of the group that it is of, or would be the first of. */
const char *ttf_manifest_group(const struct ttf_manifest *manifest);

/* dataset.json's text (to be freed with free()) and back. Reading: -EINVAL naming the field; -ENOTSUP naming an
 * unknown `required` name or another major version. */
TTF_MUST_USE int ttf_manifest_write(const struct ttf_manifest *manifest, char **ret_text,
                                    struct ttf_err *err);
TTF_MUST_USE int ttf_manifest_read(const char *text, size_t bytes, const char *where,
                                   struct ttf_manifest *ret, struct ttf_err *err);

/* Reads a dataset folder's dataset.json. Besides the above: -ENOENT if there is none. */
TTF_MUST_USE int ttf_manifest_load(struct ttf_io *io, const char *dataset, struct ttf_manifest *ret,
                                   struct ttf_err *err);

#endif
