/* SPDX-License-Identifier: Apache-2.0 */
#include "session.h"

#include <errno.h>
#include <nettle/hmac.h>
#include <nettle/memops.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "access.h"
#include "body.h"

#define NONCE_BYTES  16
#define NONCE_DIGITS (2 * NONCE_BYTES)

static void put_hex(const uint8_t *bytes, size_t n, char *ret)
{
    static const char DIGITS[] = "0123456789abcdef";

    for (size_t i = 0; i < n; i++) {
        ret[2 * i] = DIGITS[bytes[i] >> 4];
        ret[2 * i + 1] = DIGITS[bytes[i] & 15];
    }
    ret[2 * n] = '\0';
}

/* "NONCE.HMAC" from the digits of the nonce. */
static void seal(const char nonce[NONCE_DIGITS], const char *token, char ret[SESSION_SIZE])
{
    static const char PURPOSE[] = "ttfbox session ";
    struct hmac_sha256_ctx hmac;
    uint8_t mac[SHA256_DIGEST_SIZE];

    hmac_sha256_set_key(&hmac, strlen(token), (const uint8_t *)token);
    hmac_sha256_update(&hmac, sizeof PURPOSE - 1, (const uint8_t *)PURPOSE);
    hmac_sha256_update(&hmac, NONCE_DIGITS, (const uint8_t *)nonce);
    hmac_sha256_digest(&hmac, sizeof mac, mac);
    memmove(ret, nonce, NONCE_DIGITS);
    ret[NONCE_DIGITS] = '.';
    put_hex(mac, sizeof mac, ret + NONCE_DIGITS + 1);
}

const char *session_name(const char *host, char ret[SESSION_NAME_SIZE])
{
    const char *colon = host ? strrchr(host, ':') : NULL;
    size_t n = colon ? strspn(colon + 1, "0123456789") : 0;

    if (n > 0 && n <= 5 && colon[1 + n] == '\0')
        (void)snprintf(ret, SESSION_NAME_SIZE, "ttfbox-%.5s", colon + 1);
    else
        (void)snprintf(ret, SESSION_NAME_SIZE, "ttfbox");
    return ret;
}

int session_make(const char *token, char ret[SESSION_SIZE], struct ttf_err *err)
{
    uint8_t random[NONCE_BYTES];
    char nonce[NONCE_DIGITS + 1];

    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return ttf_err_set(err, -EIO, NULL, "the kernel gives no randomness");
    put_hex(random, sizeof random, nonce);
    seal(nonce, token, ret);
    return 0;
}

bool session_find(const char *header, const char *name, char ret[SESSION_SIZE])
{
    size_t n = strlen(name);

    while (header && *header) {
        size_t part;

        header += strspn(header, "; \t");
        part = strcspn(header, ";");
        if (strncmp(header, name, n) == 0 && header[n] == '=' && part == n + SESSION_SIZE) {
            memcpy(ret, header + n + 1, SESSION_SIZE - 1);
            ret[SESSION_SIZE - 1] = '\0';
            return true;
        }
        header += part;
    }
    return false;
}

bool session_valid(const char *value, const char *token)
{
    char expected[SESSION_SIZE];

    if (!token || strlen(value) != SESSION_SIZE - 1)
        return false;
    seal(value, token, expected);
    return memeql_sec(value, expected, SESSION_SIZE - 1);
}

/* ---- routes ---- */

int session_begin(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char given[512], value[SESSION_SIZE], name[SESSION_NAME_SIZE];
    int r = body_token(request->body, request->body_bytes, given, sizeof given, &request->err);

    if (r < 0)
        return r;
    if (!access_same_token(given, request->token))
        return ttf_err_set(&request->err, -EACCES, "token", "this is not the box's token");
    r = session_make(request->token, value, &request->err);
    if (r < 0)
        return r;
    answer_header(ret, "Set-Cookie", "%s=%s; Path=/; HttpOnly; SameSite=Strict",
                  session_name(request_header(request, "Host"), name), value);
    return answer_done(request, ret);
}

int session_show(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    struct ttf_http_box *box = request->box;
    bool waits = box && request->at_cable && box->ops->token_waits && box->ops->token_waits(box);
    char *text = malloc(100);
    int n;

    if (!text)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    n = snprintf(text, 100, "{\"box\":%s,\"read\":%s,\"change\":%s,\"token_waits\":%s}",
                 box ? "true" : "false", request->may_read ? "true" : "false",
                 request->may_change ? "true" : "false", waits ? "true" : "false");
    answer_json(ret, text, (size_t)n);
    return 0;
}

/* The token itself, once: README.md, "How a person gets the token". */
int session_token(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    struct ttf_http_box *box = request->box;
    char *text;
    int n, r;

    if (!box || !box->ops->token_show || !request->token)
        return ttf_err_set(&request->err, -ENODEV, NULL, "this server has no box");
    text = malloc(100);
    if (!text)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    r = box->ops->token_show(box, &request->err);
    if (r < 0) {
        free(text);
        return r;
    }
    /* It was made by the box, of hex digits. */
    n = snprintf(text, 100, "{\"token\":\"%s\"}", request->token);
    answer_json(ret, text, (size_t)n);
    return 0;
}

int session_end(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char name[SESSION_NAME_SIZE];

    answer_header(ret, "Set-Cookie", "%s=; Path=/; HttpOnly; SameSite=Strict; Max-Age=0",
                  session_name(request_header(request, "Host"), name));
    return answer_done(request, ret);
}
