/* SPDX-License-Identifier: Apache-2.0 */
/*
 * decode.h: from YAML nodes to typed fields by tables, so that every key is
 * checked the same way: its unit, its range, that it is known at all.
 */
#ifndef CONFIG_DECODE_H
#define CONFIG_DECODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/config/units.h"
#include "yaml_tree.h"

struct cfg_field;

/* Reads node into the place `at`. 0, or -EINVAL with *err set through cfg_error. */
typedef int cfg_read_fn(const struct cfg_field *field, struct yaml_node *node, void *at,
                        struct ttf_err *err);

struct cfg_field {
    const char *key;
    cfg_read_fn *read;
    size_t offset;     /* of the member in the struct that the table is for */
    double lo, hi;     /* range, inclusive, in the member's unit; both 0: any */
    const char *meant; /* what the key is for, shown where it is missing or wrong */
    const void *extra; /* of some readers: names of an enum, a table of fields */
    bool required;
};

/*
 * Sets "file:line:col" and "path: text", with the hint "meant". Returns -EINVAL.
 * fmt's text must not end in a full stop.
 */
int cfg_error(const struct yaml_node *node, struct ttf_err *err, const char *hint, const char *fmt,
              ...) TTF_PRINTF(4, 5);

/* The same at the node's key. */
int cfg_error_at_key(const struct yaml_node *node, struct ttf_err *err, const char *hint,
                     const char *fmt, ...) TTF_PRINTF(4, 5);

/*
 * Decodes a map by a table ended by a NULL key. Keys that are in no table are
 * refused with what they might have meant; keys marked used before are left alone.
 */
int cfg_map(const struct cfg_field *fields, struct yaml_node *map, void *base, struct ttf_err *err);

/* A scalar's text, or NULL with *err set. */
const char *cfg_scalar(struct yaml_node *node, const char *meant, struct ttf_err *err);

/* The name of a closed list (ended by NULL) that is nearest to text, or NULL if none is near. */
const char *cfg_nearest(const char *text, const char *const *names);
unsigned cfg_distance(const char *a, const char *b);

/* ---- readers; the member's type is in the name ---- */

struct cfg_name {
    const char *name; /* NULL ends the list */
    int value;
};

cfg_read_fn cfg_i64_time;          /* int64_t ns */
cfg_read_fn cfg_i64_bytes;         /* int64_t */
cfg_read_fn cfg_i64_utc;           /* int64_t ns since 1970 */
cfg_read_fn cfg_i64;               /* int64_t, no unit */
cfg_read_fn cfg_u64;               /* uint64_t, 0..INT64_MAX */
cfg_read_fn cfg_u32;               /* uint32_t */
cfg_read_fn cfg_u32_px;            /* uint32_t, "px" may be left out */
cfg_read_fn cfg_u32_lens;          /* uint32_t mdpt */
cfg_read_fn cfg_u32_milli;         /* uint32_t: a plain number times 1000 */
cfg_read_fn cfg_u32_ppm;           /* uint32_t: a share, in millionths */
cfg_read_fn cfg_unsigned_permille; /* unsigned: a share, whole permille */
cfg_read_fn cfg_i32_mdegc;         /* int32_t */
cfg_read_fn cfg_double;            /* a plain number */
cfg_read_fn cfg_double_px;         /* a plain number, "px" allowed */
cfg_read_fn cfg_double_ratio;      /* a plain number or a share */
cfg_read_fn cfg_double_hz;
cfg_read_fn cfg_double_mains; /* 50 or 60; "none", which is 0, where lo is 0 */
cfg_read_fn cfg_double_degc;
cfg_read_fn cfg_bool;
cfg_read_fn cfg_enum;    /* int; extra: struct cfg_name[] */
cfg_read_fn cfg_section; /* a map; extra: struct cfg_field[], offsets from the same base as `at` */

/* Texts of a given room: char[32], char[64], char[128], char[512]. name: only [a-z0-9-]. */
cfg_read_fn cfg_name32;
cfg_read_fn cfg_text32, cfg_text64, cfg_text128;
cfg_read_fn cfg_path512; /* not empty */

/* 3 numbers: double[3]. */
cfg_read_fn cfg_double3;

#endif
