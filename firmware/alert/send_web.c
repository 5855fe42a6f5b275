/* SPDX-License-Identifier: Apache-2.0 */
#include <curl/curl.h>
#include <errno.h>
#include <string.h>

#include "alert.h"

/* NOLINTNEXTLINE(readability-non-const-parameter): libcurl's */
static size_t swallow(char *data, size_t size, size_t n, void *ctx)
{
    (void)data;
    (void)ctx;
    return size * n;
}

static int on_progress(void *ctx, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d)
{
    const volatile int *stop = ctx;

    (void)a;
    (void)b;
    (void)c;
    (void)d;
    return *stop;
}

static CURLcode set_up(CURL *curl, const char *url, int64_t timeout_ns, const volatile int *stop)
{
    long ms = (long)(timeout_ns / TTF_NS_PER_MS);
    CURLcode r = curl_easy_setopt(curl, CURLOPT_URL, url);

    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, ms);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, swallow);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, on_progress);
    if (r == CURLE_OK)
        r = curl_easy_setopt(curl, CURLOPT_XFERINFODATA, (void *)stop);
    return r;
}

int send_web(const char *url, const char *json, int64_t timeout_ns, const volatile int *stop,
             struct ttf_err *err)
{
    struct curl_slist *headers =
        json ? curl_slist_append(NULL, "Content-Type: application/json") : NULL;
    CURL *curl = curl_easy_init();
    CURLcode r = curl ? set_up(curl, url, timeout_ns, stop) : CURLE_OUT_OF_MEMORY;
    long status = 0;

    if (r == CURLE_OK && json)
        r = curl_easy_setopt(curl, CURLOPT_POSTFIELDS, json);
    if (r == CURLE_OK && headers)
        r = curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
    if (r == CURLE_OK)
        r = curl_easy_perform(curl);
    if (r == CURLE_OK)
        r = curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
    curl_easy_cleanup(curl);
    curl_slist_free_all(headers);
    if (r != CURLE_OK) /* the library's own words: they name no address */
        return ttf_err_set(err, -EIO, NULL, "%s", curl_easy_strerror(r));
    if (status < 200 || status > 299)
        return ttf_err_set(err, -EIO, NULL, "it answers with status %ld", status);
    return 0;
}
