/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/json_parse.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>

/*
 * A text that jansson has no memory for is, it says, wrong: "invalid token". Or not even that: of a long text in it the
 * end is left out, and it is well. It has nowhere to keep that an allocation failed, so this does; of the thread
 * that parses, and for the time of one call.
 */
static _Thread_local bool had_no_memory;

/* What jansson took its memory from before, written once. */
static json_malloc_t taken_from;

static void *take(size_t bytes)
{
    void *p = taken_from(bytes);

    had_no_memory = had_no_memory || !p;
    return p;
}

static void look_on(void)
{
    json_free_t given_back;

    json_get_alloc_funcs(&taken_from, &given_back);
    json_set_alloc_funcs(take, given_back);
}

int ttf_json_parse(const char *text, size_t bytes, json_t **ret, json_error_t *ret_where)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    json_t *json;

    pthread_once(&once, look_on);
    had_no_memory = false;
    json = json_loadb(text, bytes, JSON_REJECT_DUPLICATES, ret_where);
    if (json && !had_no_memory) {
        *ret = json;
        return 0;
    }
    json_decref(json);
    return had_no_memory ? -ENOMEM : -EINVAL;
}
