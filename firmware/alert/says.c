/* SPDX-License-Identifier: Apache-2.0 */
/* says.c: the daemon's own words about what it does, where it is there to say any. Asked for when there is an alarm alone. */
#include <curl/curl.h>
#include <stdio.h>
#include <string.h>

#include "alert.h"
#include "ttf/dataset/json_parse.h"

#define WAIT_MS 500L /* one that hangs keeps nobody from being told in time */

struct answer {
    char text[64 * 1024];
    size_t n;
};

/* NOLINTNEXTLINE(readability-non-const-parameter): libcurl's */
static size_t keep(char *data, size_t size, size_t n, void *ctx)
{
    struct answer *answer = ctx;

    if (n > sizeof answer->text - answer->n)
        return 0;
    memcpy(answer->text + answer->n, data, n);
    answer->n += n;
    return size * n;
}

static CURLcode ask(CURL *curl, const char *socket, struct answer *answer)
{
    CURLcode r = curl_easy_setopt(curl, CURLOPT_URL, "http://localhost/api/v1/status");

    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_UNIX_SOCKET_PATH, socket);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_FAILONERROR, 1L);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, WAIT_MS);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, keep);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_WRITEDATA, answer);
    return r == CURLE_OK ? curl_easy_perform(curl) : r;
}

void says_ask(const char *socket, char *ret, size_t size)
{
    struct answer answer = {.n = 0};
    CURL *curl = *socket ? curl_easy_init() : NULL;
    const char *state, *why;
    json_t *status;

    *ret = '\0';
    if (!curl)
        return;
    if (ask(curl, socket, &answer) == CURLE_OK &&
        ttf_json_parse(answer.text, answer.n, &status, NULL) == 0) {
        state = json_string_value(json_object_get(status, "state"));
        why = json_string_value(json_object_get(status, "why"));
        (void)snprintf(ret, size, "%s%s%s", state ? state : "", state && why ? ": " : "",
                       why ? why : "");
        json_decref(status);
    }
    curl_easy_cleanup(curl);
}
