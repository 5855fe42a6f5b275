/* SPDX-License-Identifier: Apache-2.0 */
#include "seal.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "strays.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"
#include "vouched.h"

#define SUMMARY_MAX ((size_t)1 << 20)
#define SUMS_MAX    ((size_t)256 << 20)
#define PREFIX      66 /* digits and two blanks */

/* A number to show, whatever the box says. */
static int64_t at_most(int64_t slots)
{
    if (slots < 0)
        return 0;
    return slots < INT32_MAX ? slots : INT32_MAX;
}

int seal_ask(struct wire *wire, const char *name, struct seal_state *ret, struct ttf_err *err)
{
    char url[128], *text = NULL;
    const char *digest;
    json_t *json;
    size_t n;
    int r;

    (void)snprintf(url, sizeof url, "/datasets/%s", name);
    r = pull_wire_get_text(wire, url, 0, -1, SUMMARY_MAX, &text, &n, err);
    if (r < 0)
        return r;
    r = ttf_json_parse(text, n, &json, NULL);
    free(text);
    if (r < 0)
        return ttf_err_set(err, r == -EINVAL ? -EPROTO : r, url, "the box's answer is no JSON");
    *ret = (struct seal_state){
        .slots = at_most(json_integer_value(json_object_get(json, "slots"))),
        .sealed = json_is_true(json_object_get(json, "sealed")),
    };
    digest = json_string_value(json_object_get(json, "digest"));
    if (ret->sealed && (!digest || !ttf_sha256_is_hex(digest)))
        r = ttf_err_set(err, -EPROTO, url, "the box's answer has no digest");
    else if (ret->sealed)
        (void)snprintf(ret->digest, sizeof ret->digest, "%s", digest);
    json_decref(json);
    return r;
}

/* Does a list of hashes name this file of the dataset's root? */
static bool lists(const char *text, const char *name)
{
    char end_of_line[64];

    (void)snprintf(end_of_line, sizeof end_of_line, "  %s\n", name);
    return strstr(text, end_of_line) != NULL;
}

int seal_look(struct ttf_io *io, const char *folder, struct seal_state *state, struct ttf_err *err)
{
    char path[4600], digest[65], *text = NULL;
    bool sealed;
    size_t n;
    int r;

    (void)snprintf(path, sizeof path, "%s/SHA256SUMS", folder);
    r = ttf_io_slurp(io, path, SUMS_MAX, &text, &n, NULL);
    if (r < 0)
        return r == -ENOENT ? 0
                            : ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    sealed = lists(text, "records.jsonl"); /* without these it seals nothing */
    free(text);
    if (!sealed)
        return 0;
    r = ttf_sha256_file(io, path, NULL, digest, err);
    if (r < 0)
        return r;
    state->here = state->sealed && strcmp(digest, state->digest) == 0;
    state->other_here = !state->here;
    return 0;
}

int seal_drop(struct ttf_io *io, const char *folder, struct ttf_err *err)
{
    char path[4600];
    int r;

    (void)snprintf(path, sizeof path, "%s/SHA256SUMS", folder);
    r = io->ops->unlink(io, path);
    if (r == 0 || r == -ENOENT)
        r = io->ops->sync_dir(io, folder);
    return r == 0 ? 0 : ttf_err_set(err, r, path, "cannot be taken away: %s", strerrordesc_np(-r));
}

/* What its record vouches for in the same words was checked when it came; else it is looked at now. */
static int check_one(struct landing *landing, struct settling *settling, struct vouched *vouched,
                     const char *path, const char *hex, struct landed *ret, struct ttf_err *err)
{
    enum vouched_as as = vouched_as(vouched, path, hex);
    int r;

    if (as == VOUCHED_OTHERWISE)
        return ttf_err_set(err, -TTF_EDAMAGED, path,
                           "the box's SHA256SUMS and its records say different things of it");
    r = landing_ensure(landing, path, -1, hex, as == VOUCHED_SO ? LANDING_SIZE : LANDING_HASH, ret,
                       err);
    return r == 0 && ret->unsettled ? settle_add(settling, path, err) : r;
}

/* Every file of the list. only: that one alone; NULL: all. *ret: what came of the last. */
static int check_listed(struct landing *landing, struct settling *settling, struct vouched *vouched,
                        const char *text, size_t n, const char *only, struct landed *ret,
                        struct ttf_err *err)
{
    const char *end = text + n;

    while (text < end) {
        const char *lf = memchr(text, '\n', (size_t)(end - text));
        size_t length = lf ? (size_t)(lf - text) : 0;
        char hex[65], path[192];
        int r = 0;

        if (length <= PREFIX || length - PREFIX >= sizeof path)
            return ttf_err_set(err, -TTF_EDAMAGED, "SHA256SUMS", "a line of the box's is none");
        memcpy(hex, text, 64);
        hex[64] = '\0';
        memcpy(path, text + PREFIX, length - PREFIX);
        path[length - PREFIX] = '\0';
        if (!ttf_sha256_is_hex(hex) || !landing_is_listed(path))
            return ttf_err_set(err, -TTF_EDAMAGED, "SHA256SUMS", "a line of the box's is none");
        if (!only || strcmp(only, path) == 0)
            r = check_one(landing, settling, vouched, path, hex, ret, err);
        if (r < 0)
            return r;
        text = lf + 1;
    }
    return 0;
}

/* The records first: what they say of the others has to be said by those that are sealed. Then what 'verify' asks of a seal. */
static int check_all(struct landing *landing, struct settling *settling, struct grown *records,
                     struct vouched *vouched, const char *text, size_t n, struct ttf_err *err)
{
    struct vouched none = {0};
    struct landed landed = {0};
    int r;

    if (!lists(text, "records.jsonl") || !lists(text, "dataset.json"))
        return ttf_err_set(err, -TTF_EDAMAGED, "SHA256SUMS",
                           "the box's does not list the records and dataset.json");
    r = check_listed(landing, settling, &none, text, n, "records.jsonl", &landed, err);
    if (r == 0 && landed.came) { /* they are others than those that were gone through */
        vouched_free(vouched);
        r = vouched_read(records, vouched, err);
    } else {
        vouched_sort(vouched);
    }
    if (r == 0)
        r = check_listed(landing, settling, vouched, text, n, NULL, &landed, err);
    if (r == 0 && !(vouched->ended && vouched_all_listed(vouched)))
        r = ttf_err_set(err, -TTF_EDAMAGED, "SHA256SUMS",
                        "the box's does not list all that its records name, or they have no end");
    return r;
}

int seal_close(struct landing *landing, struct settling *settling, struct grown *records,
               struct vouched *vouched, struct seal_state *state, bool *ret_sealed,
               struct ttf_err *err)
{
    char url[128], digest[65], *text = NULL;
    struct ttf_sha256 hash;
    size_t n;
    int r;

    *ret_sealed = state->here;
    if (!state->sealed || state->here)
        return 0;
    (void)snprintf(url, sizeof url, "/datasets/%s/files/SHA256SUMS", landing->name);
    r = pull_wire_get_text(landing->wire, url, 0, -1, SUMS_MAX, &text, &n, err);
    if (r < 0)
        return r;
    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, text, n);
    ttf_sha256_hex(&hash, digest);
    /* Gone on with since it was asked: its next state is for the next time. */
    if (strcmp(digest, state->digest) == 0) {
        r = check_all(landing, settling, records, vouched, text, n, err);
        if (r == 0)
            r = settle_all(settling, err);
        if (r == 0)
            r = strays_put_aside(landing->io, landing->folder, text, &state->aside, err);
        if (r == 0)
            r = landing_put(landing, "SHA256SUMS", text, n, err);
        *ret_sealed = r == 0;
    }
    free(text);
    return r;
}
