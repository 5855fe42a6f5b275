/* SPDX-License-Identifier: Apache-2.0 */
/* A slot line's head by its text alone, as ttf_slot_put writes it. */
#include <string.h>

#include "record_line.h"

/* What is left of a line. */
struct text {
    const char *at, *end;
};

static bool take_word(struct text *text, const char *word)
{
    size_t n = strlen(word);

    if ((size_t)(text->end - text->at) < n || memcmp(text->at, word, n) != 0)
        return false;
    text->at += n;
    return true;
}

/* A whole number as JSON has it: no plus, no zeros before it, and none that may not fit. */
static bool take_int(struct text *text, int64_t *ret)
{
    bool negative = text->at < text->end && *text->at == '-';
    const char *first = text->at + negative, *at = first;
    int64_t n = 0;

    for (; at < text->end && *at >= '0' && *at <= '9' && at - first < 18; at++)
        n = n * 10 + (*at - '0');
    if (at == first || at == text->end || (*at >= '0' && *at <= '9') ||
        (*first == '0' && (at - first > 1 || negative)))
        return false;
    text->at = at;
    *ret = negative ? -n : n;
    return true;
}

static bool take_result(struct text *text, enum ttf_result *ret)
{
    for (int i = 0; i < TTF_RESULT_COUNT; i++) {
        struct text behind = *text;

        if (take_word(&behind, ttf_result_name((enum ttf_result)i)) && take_word(&behind, "\",")) {
            *text = behind;
            *ret = (enum ttf_result)i;
            return true;
        }
    }
    return false;
}

bool ttf_slot_head(const char *line, size_t bytes, int64_t *ret_seq, struct ttf_slot_brief *ret)
{
    struct text text = {line, line + bytes};
    struct ttf_slot_brief brief;
    int64_t seq, segment, middle_ns;

    if (!take_word(&text, "{\"type\":\"slot\",\"seq\":") || !take_int(&text, &seq) ||
        !take_word(&text, ",\"index\":") || !take_int(&text, &brief.index) ||
        !take_word(&text, ",\"segment\":") || !take_int(&text, &segment) ||
        !take_word(&text, ",\"due_ns\":") || !take_int(&text, &brief.due_ns))
        return false;
    if (take_word(&text, ",\"middle_ns\":") && !take_int(&text, &middle_ns))
        return false;
    if (!take_word(&text, ",\"result\":\"") || !take_result(&text, &brief.result))
        return false;
    if (brief.index < 0 || segment < 0 || segment > INT32_MAX)
        return false; /* its message names the field */
    brief.segment = (int)segment;
    *ret_seq = seq;
    *ret = brief;
    return true;
}
