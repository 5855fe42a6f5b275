/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/pull/ask.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/json_parse.h"
#include "wire.h"

/* The answer as an object; -EPROTO. */
static int ask(const struct ttf_pull_config *config, const char *path, const char *json,
               json_t **ret, struct ttf_err *err)
{
    struct wire *wire = NULL;
    char *text = NULL;
    size_t bytes = 0;
    int r = pull_wire_create(config, &wire, err);

    if (r == 0)
        r = pull_wire_post_text(wire, path, json, &text, &bytes, err);
    if (r == 0) {
        r = ttf_json_parse(text, bytes, ret, NULL);
        if (r == -EINVAL)
            r = ttf_err_set(err, -EPROTO, config->box, "the box's answer is no JSON");
    }
    free(text);
    pull_wire_destroy(wire);
    return r;
}

int ttf_pull_token(const struct ttf_pull_config *config, char **ret_token, struct ttf_err *err)
{
    json_t *answer = NULL;
    const char *token;
    int r = ask(config, "/session/token", NULL, &answer, err);

    if (r == -EEXIST && err) { /* more than the box can know: what this person can do */
        ttf_err_set(err, r, NULL, "the box has shown its token before, or a person chose it");
        ttf_err_hint(err,
                     "whoever has it can tell it; else write one of your own on the box's card: "
                     "settings/token");
    }
    if (r < 0)
        return r;
    token = json_string_value(json_object_get(answer, "token"));
    *ret_token = token ? strdup(token) : NULL;
    json_decref(answer);
    if (*ret_token)
        return 0;
    return token ? ttf_err_set(err, -ENOMEM, NULL, "no memory")
                 : ttf_err_set(err, -EPROTO, config->box, "the box's answer has no token");
}

int ttf_pull_offer_time(const struct ttf_pull_config *config, struct ttf_err *err)
{
    struct ttf_utc utc;
    char body[64];
    json_t *answer = NULL;
    int r;

    ttf_clock_utc(config->clock, &utc);
    (void)snprintf(body, sizeof body, "{\"utc_ns\":%" PRId64 "}", utc.utc_ns);
    r = ask(config, "/time", body, &answer, err);
    if (r < 0)
        return r;
    r = json_is_true(json_object_get(answer, "taken")) ? 1 : 0;
    json_decref(answer);
    return r;
}
