/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/json_parse.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/*
 * A text that jansson has no memory for is, it says, wrong: "invalid token". It has nowhere to keep that an allocation
 * failed, so this does; of the thread that parses, and for the time of one call.
 *
 * And it must not fail to make room for the token it reads: it goes on all the same, looks for the end of a text
 * behind the end of its memory, and copies what it finds there (2.14, lex_scan_string). That room is the first
 * memory it takes for a text, and each next one is twice the last; if there is none, it comes from a reserve
 * that was taken before. Everything else is refused from then on, so that the next value ends it.
 */
static _Thread_local struct {
    bool had_no_memory;
    char *reserve; /* NULL: nothing is parsed now */
    size_t bytes, used;
    void *room; /* for the token, and how much; 0: not taken yet */
    size_t room_bytes;
    void *next_room; /* perhaps: the last memory of twice as much */
} parse;

/* What jansson took its memory from before, and gave it back to; written once. */
static json_malloc_t taken_from;
static json_free_t given_back;

static void *from_reserve(size_t bytes)
{
    void *p = parse.reserve + parse.used;

    if (bytes > parse.bytes - parse.used)
        return NULL;
    parse.used += (bytes + 15) / 16 * 16;
    return p;
}

static void *take(size_t bytes)
{
    bool doubles = parse.room_bytes > 0 && bytes == 2 * parse.room_bytes;
    void *p = NULL;

    if (!parse.reserve)
        return taken_from(bytes);
    if (!parse.had_no_memory)
        p = taken_from(bytes);
    parse.had_no_memory = !p;
    if (!p && doubles)
        p = from_reserve(bytes);
    if (parse.room_bytes == 0) {
        parse.room = p;
        parse.room_bytes = bytes;
    } else if (doubles) {
        parse.next_room = p;
    }
    return p;
}

static bool of_reserve(const void *p)
{
    uintptr_t at = (uintptr_t)p, reserve = (uintptr_t)parse.reserve;

    return parse.reserve && at >= reserve && at - reserve < parse.bytes;
}

static void give(void *p)
{
    if (parse.reserve && p && p == parse.room) {
        parse.room = parse.next_room;
        parse.room_bytes *= 2;
    }
    if (!of_reserve(p))
        given_back(p);
}

static void look_on(void)
{
    json_get_alloc_funcs(&taken_from, &given_back);
    json_set_alloc_funcs(take, give);
}

/* The longest text or number in it. */
static size_t longest_token(const char *text, size_t bytes)
{
    size_t longest = 0, from = 0;
    bool inside = false;

    for (size_t i = 0; i < bytes; i++) {
        if (inside && text[i] == '\\')
            i++; /* whatever it is, it ends nothing */
        else if (text[i] == '"')
            inside = !inside;
        else if (inside || (text[i] != ',' && text[i] != ':' && text[i] > ' '))
            continue;
        if (i - from > longest)
            longest = i - from;
        if (!inside)
            from = i;
    }
    return bytes - from > longest ? bytes - from : longest;
}

int ttf_json_parse(const char *text, size_t bytes, json_t **ret, json_error_t *ret_where)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    bool had_no_memory;
    json_t *json;

    pthread_once(&once, look_on);
    memset(&parse, 0, sizeof(parse));
    /* Twice the longest token, all that led up to it, and what else may be of the same size by chance. */
    parse.bytes = 8 * longest_token(text, bytes) + 512;
    parse.reserve = malloc(parse.bytes);
    if (!parse.reserve)
        return -ENOMEM;
    json = json_loadb(text, bytes, JSON_REJECT_DUPLICATES, ret_where);
    had_no_memory = parse.had_no_memory;
    if (had_no_memory) {
        json_decref(json);
        json = NULL;
    }
    free(parse.reserve);
    parse.reserve = NULL;
    if (json)
        *ret = json;
    return json ? 0 : had_no_memory ? -ENOMEM : -EINVAL;
}
