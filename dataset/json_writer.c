/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/json_writer.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_MAX 16u

void ttf_json_init(struct ttf_json *json, bool pretty)
{
    *json = (struct ttf_json){.pretty = pretty};
    json->first[0] = true;
}

void ttf_json_again(struct ttf_json *json, bool pretty)
{
    struct ttf_json kept = *json;

    ttf_json_init(json, pretty);
    json->text = kept.text;
    json->room = kept.room;
}

static void fail(struct ttf_json *json, int error)
{
    if (json->error == 0)
        json->error = error;
}

static int grow(struct ttf_json *json, size_t room)
{
    char *grown = realloc(json->text, room);

    if (!grown)
        return -ENOMEM;
    json->text = grown;
    json->room = room;
    return 0;
}

int ttf_json_reserve(struct ttf_json *json, size_t bytes)
{
    /* One byte more, for the terminator. */
    return bytes < json->room ? 0 : grow(json, bytes + 1);
}

static void put(struct ttf_json *json, const char *text, size_t n)
{
    size_t room = json->room;

    if (json->error)
        return;
    while (room - json->used <= n) { /* one byte more, for the terminator */
        if (room > SIZE_MAX / 4) {
            fail(json, -ENOMEM);
            return;
        }
        room = room ? room * 2 : 512;
    }
    if (room != json->room && grow(json, room) < 0) {
        fail(json, -ENOMEM);
        return;
    }
    memcpy(json->text + json->used, text, n);
    json->used += n;
}

static void new_line(struct ttf_json *json)
{
    unsigned i;

    if (!json->pretty)
        return;
    put(json, "\n", 1);
    for (i = 0; i < json->depth; i++)
        put(json, "  ", 2);
}

/* What stands between a value (or key) and what came before it. */
static void separate(struct ttf_json *json)
{
    if (json->after_key) {
        json->after_key = false;
        return;
    }
    if (json->depth == 0) {
        if (!json->first[0])
            fail(json, -EINVAL); /* a second value at the top */
    } else {
        if (!json->first[json->depth])
            put(json, ",", 1);
        new_line(json);
    }
    json->first[json->depth] = false;
}

static void begin(struct ttf_json *json, const char *bracket)
{
    separate(json);
    put(json, bracket, 1);
    if (json->depth >= DEPTH_MAX) {
        fail(json, -EOVERFLOW);
        return;
    }
    json->depth++;
    json->first[json->depth] = true;
}

static void end(struct ttf_json *json, const char *bracket)
{
    bool empty;

    if (json->depth == 0 || json->after_key) {
        fail(json, -EINVAL);
        return;
    }
    empty = json->first[json->depth];
    json->depth--;
    if (!empty)
        new_line(json);
    put(json, bracket, 1);
}

void ttf_json_object(struct ttf_json *json)
{
    begin(json, "{");
}

void ttf_json_object_end(struct ttf_json *json)
{
    end(json, "}");
}

void ttf_json_array(struct ttf_json *json)
{
    begin(json, "[");
}

void ttf_json_array_end(struct ttf_json *json)
{
    end(json, "]");
}

/* Bytes of the well-formed UTF-8 sequence at s (RFC 3629, table 3-7 of Unicode), 0 if it is none. */
static size_t utf8_length(const unsigned char *s)
{
    unsigned char low = 0x80, high = 0xbf;
    size_t n, i;

    if (s[0] < 0x80)
        return 1;
    if (s[0] >= 0xc2 && s[0] <= 0xdf)
        n = 2;
    else if (s[0] >= 0xe0 && s[0] <= 0xef)
        n = 3;
    else if (s[0] >= 0xf0 && s[0] <= 0xf4)
        n = 4;
    else
        return 0;
    if (s[0] == 0xe0)
        low = 0xa0;
    else if (s[0] == 0xed)
        high = 0x9f; /* no surrogates */
    else if (s[0] == 0xf0)
        low = 0x90;
    else if (s[0] == 0xf4)
        high = 0x8f; /* nothing beyond U+10FFFF */
    for (i = 1; i < n; i++) {
        if (s[i] < low || s[i] > high)
            return 0;
        low = 0x80;
        high = 0xbf;
    }
    return n;
}

static void put_escaped(struct ttf_json *json, unsigned char c)
{
    static const char letters[] = "\"\\\b\f\n\r\t", escapes[] = "\"\\bfnrt";
    const char *at = c ? strchr(letters, c) : NULL;
    char text[8];

    if (at)
        snprintf(text, sizeof(text), "\\%c", escapes[at - letters]);
    else
        snprintf(text, sizeof(text), "\\u%04x", c);
    put(json, text, strlen(text));
}

static void put_quoted(struct ttf_json *json, const char *value)
{
    const unsigned char *s = (const unsigned char *)value;
    size_t n;

    put(json, "\"", 1);
    while (*s) {
        n = utf8_length(s);
        if (n == 0)
            put(json, "\xef\xbf\xbd", 3); /* U+FFFD */
        else if (n == 1 && (*s < 0x20 || *s == '"' || *s == '\\'))
            put_escaped(json, *s);
        else
            put(json, (const char *)s, n);
        s += n ? n : 1;
    }
    put(json, "\"", 1);
}

void ttf_json_key(struct ttf_json *json, const char *key)
{
    if (json->after_key)
        fail(json, -EINVAL);
    separate(json);
    put_quoted(json, key);
    if (json->pretty)
        put(json, ": ", 2);
    else
        put(json, ":", 1);
    json->after_key = true;
}

void ttf_json_string(struct ttf_json *json, const char *value)
{
    if (!value) {
        ttf_json_null(json);
        return;
    }
    separate(json);
    put_quoted(json, value);
}

void ttf_json_int(struct ttf_json *json, int64_t value)
{
    char text[24];

    separate(json);
    snprintf(text, sizeof(text), "%lld", (long long)value);
    put(json, text, strlen(text));
}

/* The locale's decimal point, which may be several bytes, becomes a dot. */
static void undo_locale(char *text)
{
    char *from = text, *to = text;
    bool foreign = false;

    for (; *from; from++) {
        if (strchr("0123456789+-eE.", *from)) {
            *to++ = *from;
            foreign = false;
        } else if (!foreign) {
            *to++ = '.';
            foreign = true;
        }
    }
    *to = '\0';
}

void ttf_json_double(struct ttf_json *json, double value)
{
    char text[48];
    int digits;

    if (!isfinite(value)) {
        fail(json, -EDOM);
        return;
    }
    separate(json);
    for (digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof(text), "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    undo_locale(text);
    if (value == 0.0 && signbit(value))
        snprintf(text, sizeof(text), "-0.0"); /* "-0" would be read as an integer */
    put(json, text, strlen(text));
}

void ttf_json_bool(struct ttf_json *json, bool value)
{
    separate(json);
    if (value)
        put(json, "true", 4);
    else
        put(json, "false", 5);
}

void ttf_json_null(struct ttf_json *json)
{
    separate(json);
    put(json, "null", 4);
}

void ttf_json_kstring(struct ttf_json *json, const char *key, const char *value)
{
    ttf_json_key(json, key);
    ttf_json_string(json, value);
}

void ttf_json_kint(struct ttf_json *json, const char *key, int64_t value)
{
    ttf_json_key(json, key);
    ttf_json_int(json, value);
}

void ttf_json_kdouble(struct ttf_json *json, const char *key, double value)
{
    ttf_json_key(json, key);
    ttf_json_double(json, value);
}

void ttf_json_kbool(struct ttf_json *json, const char *key, bool value)
{
    ttf_json_key(json, key);
    ttf_json_bool(json, value);
}

void ttf_json_raw(struct ttf_json *json, const char *text)
{
    separate(json);
    put(json, text, strlen(text));
}

int ttf_json_finish(struct ttf_json *json, const char **ret_text, size_t *ret_bytes)
{
    if (json->depth != 0 || json->after_key || json->first[0])
        fail(json, -EINVAL);
    if (json->pretty)
        put(json, "\n", 1);
    if (json->error)
        return json->error;
    json->text[json->used] = '\0'; /* put() keeps a byte free */
    if (ret_text)
        *ret_text = json->text;
    if (ret_bytes)
        *ret_bytes = json->used;
    return 0;
}

int ttf_json_take(struct ttf_json *json, char **ret_text, size_t *ret_bytes)
{
    int r = ttf_json_finish(json, NULL, ret_bytes);

    if (r == 0) {
        *ret_text = json->text;
        json->text = NULL;
    }
    ttf_json_free(json);
    return r;
}

void ttf_json_free(struct ttf_json *json)
{
    free(json->text);
    json->text = NULL;
    json->used = json->room = 0;
}
