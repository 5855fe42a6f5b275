/* SPDX-License-Identifier: Apache-2.0 */
#include "json_read.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void ttf_in_wrong(struct ttf_json_in *in, const char *key, const char *fmt, ...)
{
    char text[160];
    va_list args;

    if (in->code)
        return;
    va_start(args, fmt);
    vsnprintf(text, sizeof(text), fmt, args);
    va_end(args);
    in->code = in->wrong;
    ttf_err_set(in->err, in->wrong, in->where, "%s%s %s", in->at, key, text);
}

void ttf_in_at(struct ttf_json_in *in, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    vsnprintf(in->at, sizeof(in->at), fmt, args);
    va_end(args);
}

void ttf_text_cut(char *dst, size_t size, const char *src)
{
    size_t n = strlen(src);

    if (n >= size) {
        n = size - 1;
        while (n > 0 && ((unsigned char)src[n] & 0xc0) == 0x80)
            n--; /* the character that begins here would not be whole */
    }
    memcpy(dst, src, n);
    dst[n] = '\0';
}

/* The value under key, NULL if absent, null or not for use. */
static const json_t *get(struct ttf_json_in *in, const json_t *object, const char *key,
                         enum ttf_json_need need)
{
    const json_t *value;

    if (in->code)
        return NULL;
    value = json_object_get(object, key);
    if (json_is_null(value))
        value = NULL;
    if (!value && need == TTF_JSON_REQUIRED)
        ttf_in_wrong(in, key, "is missing");
    return value;
}

const json_t *ttf_in_object(struct ttf_json_in *in, const json_t *object, const char *key,
                            enum ttf_json_need need)
{
    const json_t *value = get(in, object, key, need);

    if (value && !json_is_object(value)) {
        ttf_in_wrong(in, key, "must be an object");
        return NULL;
    }
    return value;
}

const json_t *ttf_in_array(struct ttf_json_in *in, const json_t *object, const char *key,
                           enum ttf_json_need need)
{
    const json_t *value = get(in, object, key, need);

    if (value && !json_is_array(value)) {
        ttf_in_wrong(in, key, "must be an array");
        return NULL;
    }
    return value;
}

void ttf_in_text(struct ttf_json_in *in, const json_t *object, const char *key, char *ret,
                 size_t size, enum ttf_json_need need)
{
    const json_t *value = get(in, object, key, need);
    const char *text;

    ret[0] = '\0';
    if (!value)
        return;
    text = json_string_value(value);
    if (!text)
        ttf_in_wrong(in, key, "must be a text");
    else if (strlen(text) >= size && need != TTF_JSON_CUT)
        ttf_in_wrong(in, key, "is longer than %zu bytes", size - 1);
    else if (need == TTF_JSON_REQUIRED && text[0] == '\0')
        ttf_in_wrong(in, key, "must not be empty");
    else
        ttf_text_cut(ret, size, text);
}

int64_t ttf_in_int(struct ttf_json_in *in, const json_t *object, const char *key, int64_t min,
                   int64_t max, int64_t absent, enum ttf_json_need need)
{
    const json_t *value = get(in, object, key, need);
    int64_t number;

    if (!value)
        return absent;
    if (!json_is_integer(value)) {
        ttf_in_wrong(in, key, "must be a whole number");
        return absent;
    }
    number = json_integer_value(value);
    if (number < min || number > max) {
        ttf_in_wrong(in, key, "is %lld, but must lie in %lld..%lld", (long long)number,
                     (long long)min, (long long)max);
        return absent;
    }
    return number;
}

double ttf_in_double(struct ttf_json_in *in, const json_t *object, const char *key, double absent,
                     enum ttf_json_need need)
{
    const json_t *value = get(in, object, key, need);

    if (!value)
        return absent;
    if (!json_is_number(value)) {
        ttf_in_wrong(in, key, "must be a number");
        return absent;
    }
    return json_number_value(value);
}

bool ttf_in_bool(struct ttf_json_in *in, const json_t *object, const char *key, bool absent,
                 enum ttf_json_need need)
{
    const json_t *value = get(in, object, key, need);

    if (!value)
        return absent;
    if (!json_is_boolean(value)) {
        ttf_in_wrong(in, key, "must be true or false");
        return absent;
    }
    return json_is_true(value);
}
