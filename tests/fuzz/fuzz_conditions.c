/* SPDX-License-Identifier: Apache-2.0 */
/*
 * "IF-NONE-MATCH\nLAST-EVENT-ID": a tag that is listed stands there in quotes; whoever listens is told that they missed
 * something, or goes on behind an event that was. In the second a leading '~' is the id's beginning, which is another each time.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "answer.h"
#include "fuzz.h"
#include "listeners.h"
#include "ttf/http/events.h"

#define TAG    "5f3c-1a"
#define EVENTS 3

static void check_tags(const char *text)
{
    if (answer_lists_tag(text, TAG) && strcmp(text, "*") != 0 && !strstr(text, "\"" TAG "\""))
        abort();
    if (answer_lists_tag(text, ""))
        abort();
}

/* All that a listener is given, up to the event that was published last. */
static void check_stream(struct event_listener *listener)
{
    char text[1024] = "";
    size_t n = 0;

    while (!strstr(text, "{\"last\":true}\n\n")) {
        ssize_t got = listener_read(listener, n, text + n, sizeof text - 1 - n);

        if (got <= 0)
            abort();
        n += (size_t)got;
        text[n] = '\0';
    }
    if (strncmp(text, "retry: ", 7) != 0)
        abort();
}

static void check_id(const char *text)
{
    char id[TTF_HTTP_EVENT_ID_SIZE], said[512];
    struct event_listener *listener;
    struct ttf_http_events *events;
    const int leaving = 0;

    if (ttf_http_events_create(&events, NULL) < 0)
        return;
    for (unsigned i = 0; i < EVENTS; i++)
        ttf_http_events_publish(events, "state", "{}");
    (void)ttf_http_events_last(events, id);
    *strrchr(id, '-') = '\0';
    (void)snprintf(said, sizeof said, "%s%.400s", *text == '~' ? id : "",
                   *text == '~' ? text + 1 : text);
    if (listener_create(events, said, &leaving, &listener, NULL) == 0) {
        ttf_http_events_publish(events, "state", "{\"last\":true}");
        check_stream(listener);
        listener_free(listener);
    }
    ttf_http_events_destroy(events);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1), *id;

    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    id = strchr(text, '\n');
    if (id)
        *id++ = '\0';
    check_tags(text);
    check_id(id ? id : "");
    free(text);
    return 0;
}
