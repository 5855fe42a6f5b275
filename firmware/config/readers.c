/* SPDX-License-Identifier: Apache-2.0 */
/* readers.c: one reader per type of member; see decode.h. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "decode.h"

/* Puts the place in front of an error that units.c wrote. */
static int placed(const struct yaml_node *node, struct ttf_err *err)
{
    char what[200], hint[256];

    if (!err)
        return -EINVAL;
    snprintf(what, sizeof what, "%.199s", err->what);
    snprintf(hint, sizeof hint, "%s", err->hint);
    return cfg_error(node, err, hint, "%s", what);
}

/* lo and hi of a field in words, by a unit or plain (kind < 0). */
static int out_of_range(const struct cfg_field *field, const struct yaml_node *node, int kind,
                        double divisor, struct ttf_err *err)
{
    char lo[40], hi[40], text[200];

    if (kind >= 0 && fabs(field->lo) < 9e18 && fabs(field->hi) < 9e18) {
        ttf_unit_format((enum ttf_unit_kind)kind, (int64_t)field->lo, lo, sizeof lo);
        ttf_unit_format((enum ttf_unit_kind)kind, (int64_t)field->hi, hi, sizeof hi);
    } else {
        snprintf(lo, sizeof lo, "%g", field->lo / divisor);
        snprintf(hi, sizeof hi, "%g", field->hi / divisor);
    }
    snprintf(text, sizeof text, "%s: from %s to %s", field->meant, lo, hi);
    return cfg_error(node, err, text, "%.60s is out of its range", node->text);
}

static bool inside(const struct cfg_field *field, double value)
{
    return (field->lo == 0 && field->hi == 0) || (value >= field->lo && value <= field->hi);
}

/* A quantity with a unit, or (kind < 0) a whole number; checked against the field's range. */
static int read_i64(const struct cfg_field *field, struct yaml_node *node, int kind, int64_t *ret,
                    struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);
    int64_t value;
    int r;

    if (!text)
        return -EINVAL;
    r = kind < 0 ? ttf_integer_parse(text, &value, err)
                 : ttf_unit_parse((enum ttf_unit_kind)kind, text, &value, err);
    if (r < 0)
        return placed(node, err);
    if (!inside(field, (double)value))
        return out_of_range(field, node, kind, 1, err);
    *ret = value;
    return 0;
}

int cfg_i64_time(const struct cfg_field *field, struct yaml_node *node, void *at,
                 struct ttf_err *err)
{
    return read_i64(field, node, TTF_UNIT_TIME, at, err);
}

int cfg_i64_bytes(const struct cfg_field *field, struct yaml_node *node, void *at,
                  struct ttf_err *err)
{
    return read_i64(field, node, TTF_UNIT_BYTES, at, err);
}

int cfg_i64(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    return read_i64(field, node, -1, at, err);
}

int cfg_i64_utc(const struct cfg_field *field, struct yaml_node *node, void *at,
                struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);

    if (!text)
        return -EINVAL;
    return ttf_utc_parse(text, at, err) < 0 ? placed(node, err) : 0;
}

int cfg_u64(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    int64_t value = 0;
    int r = read_i64(field, node, -1, &value, err);

    if (r < 0)
        return r;
    if (value < 0)
        return cfg_error(node, err, field->meant, "%.60s is negative", node->text);
    *(uint64_t *)at = (uint64_t)value;
    return 0;
}

/* 32 bits without a sign; the field's table gives the range. */
static int read_u32(const struct cfg_field *field, struct yaml_node *node, int kind, void *at,
                    struct ttf_err *err)
{
    int64_t value = 0;
    int r = read_i64(field, node, kind, &value, err);

    if (r < 0)
        return r;
    if (value < 0)
        return cfg_error(node, err, field->meant, "%.60s is negative", node->text);
    if (value > UINT32_MAX)
        return cfg_error(node, err, field->meant, "%.60s is far too large", node->text);
    *(uint32_t *)at = (uint32_t)value;
    return 0;
}

int cfg_u32(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    return read_u32(field, node, -1, at, err);
}

/* Pixels are what a bare number in a region means: the unit may be left out. */
static bool bare_number(const struct yaml_node *node)
{
    return node->kind == YAML_SCALAR && *node->text &&
           strspn(node->text, "+-.0123456789eE") == strlen(node->text);
}

int cfg_u32_px(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    return read_u32(field, node, bare_number(node) ? -1 : TTF_UNIT_PIXELS, at, err);
}

int cfg_u32_lens(const struct cfg_field *field, struct yaml_node *node, void *at,
                 struct ttf_err *err)
{
    return read_u32(field, node, TTF_UNIT_LENS, at, err);
}

int cfg_u32_ppm(const struct cfg_field *field, struct yaml_node *node, void *at,
                struct ttf_err *err)
{
    return read_u32(field, node, TTF_UNIT_SHARE, at, err);
}

int cfg_i32_mdegc(const struct cfg_field *field, struct yaml_node *node, void *at,
                  struct ttf_err *err)
{
    int64_t value = 0;
    int r = read_i64(field, node, TTF_UNIT_TEMPERATURE, &value, err);

    if (r == 0)
        *(int32_t *)at = (int32_t)value;
    return r;
}

int cfg_unsigned_permille(const struct cfg_field *field, struct yaml_node *node, void *at,
                          struct ttf_err *err)
{
    uint32_t ppm = 0;
    struct cfg_field wide = *field;

    wide.lo *= 1000;
    wide.hi *= 1000;
    int r = read_u32(&wide, node, TTF_UNIT_SHARE, &ppm, err);

    if (r < 0)
        return r;
    if (ppm % 1000)
        return cfg_error(node, err, field->meant, "%.60s is finer than a permille", node->text);
    *(unsigned *)at = ppm / 1000;
    return 0;
}

int cfg_double(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);
    double value;

    if (!text)
        return -EINVAL;
    if (ttf_number_parse(text, &value, err) < 0)
        return placed(node, err);
    if (!inside(field, value))
        return out_of_range(field, node, -1, 1, err);
    *(double *)at = value;
    return 0;
}

/* A quantity with a unit as a double: value / divisor. lo and hi are in the member's unit. */
static int read_scaled(const struct cfg_field *field, struct yaml_node *node, int kind,
                       double divisor, double *ret, struct ttf_err *err)
{
    struct cfg_field wide = *field;
    int64_t value = 0;

    wide.lo *= divisor;
    wide.hi *= divisor;
    int r = read_i64(&wide, node, kind, &value, err);

    if (r == 0)
        *ret = (double)value / divisor;
    return r;
}

int cfg_double_px(const struct cfg_field *field, struct yaml_node *node, void *at,
                  struct ttf_err *err)
{
    char *unit = node->kind == YAML_SCALAR ? strstr(node->text, "px") : NULL;

    if (unit && !unit[2]) {
        *unit = '\0';
        if (unit > node->text && unit[-1] == ' ')
            unit[-1] = '\0';
    }
    return cfg_double(field, node, at, err);
}

int cfg_double_ratio(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    if (node->kind == YAML_SCALAR &&
        (strchr(node->text, '%') || strstr(node->text, "permille") || strstr(node->text, "ppm")))
        return read_scaled(field, node, TTF_UNIT_SHARE, 1e6, at, err);
    return cfg_double(field, node, at, err);
}

int cfg_double_hz(const struct cfg_field *field, struct yaml_node *node, void *at,
                  struct ttf_err *err)
{
    return read_scaled(field, node, TTF_UNIT_FREQUENCY, 1e3, at, err);
}

int cfg_double_mains(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    double hz = 0;
    int r = 0;

    if (node->kind != YAML_SCALAR || strcmp(node->text, "none") != 0 || field->lo > 0)
        r = cfg_double_hz(field, node, &hz, err);
    if (r == 0 && hz != 0 && hz != 50 && hz != 60)
        return cfg_error(node, err, field->meant, "no mains has %s", node->text);
    if (r == 0)
        *(double *)at = hz;
    return r;
}

int cfg_double_degc(const struct cfg_field *field, struct yaml_node *node, void *at,
                    struct ttf_err *err)
{
    return read_scaled(field, node, TTF_UNIT_TEMPERATURE, 1e3, at, err);
}

int cfg_u32_milli(const struct cfg_field *field, struct yaml_node *node, void *at,
                  struct ttf_err *err)
{
    double value = 0;
    int r = cfg_double(field, node, &value, err);

    if (r == 0)
        *(uint32_t *)at = (uint32_t)lrint(value * 1000);
    return r;
}

int cfg_bool(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    static const struct cfg_name WORDS[] = {
        {"true", 1}, {"false", 0}, {"yes", 1}, {"no", 0}, {NULL, 0}};
    struct cfg_field words = *field;
    int value = 0;

    words.extra = WORDS;
    int r = cfg_enum(&words, node, &value, err);

    if (r == 0)
        *(bool *)at = value != 0;
    return r;
}

static int read_text(const struct cfg_field *field, struct yaml_node *node, char *at, size_t size,
                     struct ttf_err *err)
{
    const char *text = cfg_scalar(node, field->meant, err);

    if (!text)
        return -EINVAL;
    if (strlen(text) >= size)
        return cfg_error(node, err, field->meant, "longer than %zu letters", size - 1);
    for (const char *p = text; *p; p++)
        if ((unsigned char)*p < 0x20)
            return cfg_error(node, err, field->meant, "holds a control character");
    memset(at, 0, size);
    (void)snprintf(at, size, "%s", text);
    return 0;
}

int cfg_text32(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    return read_text(field, node, at, 32, err);
}

int cfg_text64(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    return read_text(field, node, at, 64, err);
}

int cfg_text128(const struct cfg_field *field, struct yaml_node *node, void *at,
                struct ttf_err *err)
{
    return read_text(field, node, at, 128, err);
}

int cfg_path512(const struct cfg_field *field, struct yaml_node *node, void *at,
                struct ttf_err *err)
{
    int r = read_text(field, node, at, 512, err);

    return r == 0 && *(char *)at == '\0' ? cfg_error(node, err, field->meant, "is empty") : r;
}

int cfg_name32(const struct cfg_field *field, struct yaml_node *node, void *at, struct ttf_err *err)
{
    int r = read_text(field, node, at, 32, err);

    if (r < 0)
        return r;
    if (!*node->text ||
        strspn(node->text, "abcdefghijklmnopqrstuvwxyz0123456789-") != strlen(node->text))
        return cfg_error(node, err, field->meant, "'%.40s' is not a name of a-z, 0-9 and '-'",
                         node->text);
    return 0;
}

int cfg_double3(const struct cfg_field *field, struct yaml_node *node, void *at,
                struct ttf_err *err)
{
    double value[3];
    unsigned i = 0;

    if (node->kind != YAML_LIST || node->n != 3)
        return cfg_error(node, err, field->meant, "three numbers are meant, as [1, 0.9, 0.8]");
    for (struct yaml_node *c = node->child; c; c = c->next) {
        int r = cfg_double(field, c, &value[i++], err);

        if (r < 0)
            return r;
    }
    memcpy(at, value, sizeof value);
    return 0;
}
