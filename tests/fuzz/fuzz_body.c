/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a client sends beside its path: "COOKIES\nQUERY\nBODY". What is taken has names that stay in their folder and
 * counts within their bounds; no cookie opens that was not made under the token.
 */
#include <stdlib.h>
#include <string.h>

#include "body.h"
#include "folder.h"
#include "fuzz.h"
#include "newest.h"
#include "session.h"

#define TOKEN "0123456789abcdef"

static char *cut(char **at, char end)
{
    char *text = *at, *stop = strchr(text, end);

    if (stop)
        *stop = '\0';
    *at = stop ? stop + 1 : text + strlen(text);
    return text;
}

static void check_cookies(const char *text)
{
    char value[SESSION_SIZE];

    if (session_find(text, "ttfbox-8417", value) &&
        (strlen(value) != SESSION_SIZE - 1 || session_valid(value, TOKEN)))
        abort();
}

static void check_view(const char *text)
{
    const struct body_view said = {
        .camera = text, .exposure_ns = text, .gain_milli = text, .lamps = text, .region = text};
    const struct body_view parts[] = {{.lamps = text}, {.region = text}, {.exposure_ns = text}};
    struct ttf_http_view view;

    (void)!body_view(&said, &view, NULL);
    for (unsigned i = 0; i < 3; i++)
        if (body_view(&parts[i], &view, NULL) == 0 &&
            (view.n_lamps > TTF_HTTP_LAMPS_MAX || view.width > 65535 || view.exposure_ns < 0))
            abort();
}

static void check_body(const char *text, size_t bytes)
{
    char plan[65], dataset[65], token[64];
    struct ttf_http_ask ask;
    struct ttf_note note;
    struct ttf_http_calibrate step;
    struct newest newest;

    (void)!body_token(text, bytes, token, sizeof token, NULL);
    if (body_start(text, bytes, plan, dataset, NULL) == 0 &&
        ((*plan && !folder_is_name(plan)) || (*dataset && !folder_is_name(dataset))))
        abort();
    if (body_pause(text, bytes, &ask, NULL) == 0 && strlen(ask.reason) >= sizeof ask.reason)
        abort();
    if (body_calibrate(text, bytes, &step, NULL) == 0 &&
        ((unsigned)step.part > TTF_CALIBRATION_FLICKER || step.frames > 1000 ||
         !(step.reflectance >= 0 && step.reflectance <= 1)))
        abort();
    if (body_change(text, bytes, &ask, NULL) == 0 && ask.value < 1)
        abort();
    if (body_note(text, bytes, &note, NULL) == 0 && ttf_note_check(&note, NULL) < 0)
        abort();
    if (newest_of_line(text, bytes, &newest) == 0 && !folder_is_path(newest.path))
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1), *at = text;

    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    check_cookies(cut(&at, '\n'));
    check_view(cut(&at, '\n'));
    check_body(at, size - (size_t)(at - text));
    free(text);
    return 0;
}
