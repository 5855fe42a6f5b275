/* SPDX-License-Identifier: Apache-2.0 */
#include "gives.h"

#include <string.h>

#define ALL_OF(type) ((const struct ttf_http_type[]){{"", type}, {NULL, NULL}})

static const struct ttf_http_type OF_DATASETS[] = {{".tif", "image/tiff"},
                                                   {".dng", "image/x-adobe-dng"},
                                                   {".json", "application/json"},
                                                   {".jsonl", "application/jsonl"},
                                                   {".yaml", "application/yaml"},
                                                   {".png", "image/png"},
                                                   {".jpg", "image/jpeg"},
                                                   {".mp4", "video/mp4"},
                                                   {"SHA256SUMS", "text/plain"},
                                                   {"", "application/octet-stream"},
                                                   {NULL, NULL}};

static const struct ttf_http_type OF_PAGE[] = {{".html", "text/html; charset=utf-8"},
                                               {".css", "text/css; charset=utf-8"},
                                               {".js", "text/javascript; charset=utf-8"},
                                               {".mjs", "text/javascript; charset=utf-8"},
                                               {".svg", "image/svg+xml"},
                                               {".png", "image/png"},
                                               {".jpg", "image/jpeg"},
                                               {".ico", "image/vnd.microsoft.icon"},
                                               {".json", "application/json"},
                                               {".woff2", "font/woff2"},
                                               {".txt", "text/plain; charset=utf-8"},
                                               {NULL, NULL}};

static const char *const LIVE_QUERY[] = {"camera", "exposure_ns", "gain_milli",
                                         "lamps",  "region",      NULL};

const struct ttf_http_gives GIVES_JSON = {.types = ALL_OF("application/json"), .status = 200};
const struct ttf_http_gives GIVES_TAGGED_JSON = {
    .types = ALL_OF("application/json"), .status = 200, .tagged = true};
const struct ttf_http_gives GIVES_ACCEPTED = {.types = ALL_OF("application/json"), .status = 202};
const struct ttf_http_gives GIVES_LINES = {
    .types = ALL_OF("application/jsonl"), .status = 200, .tagged = true, .ranges = true};
const struct ttf_http_gives GIVES_FILE = {
    .types = OF_DATASETS, .status = 200, .tagged = true, .ranges = true};
const struct ttf_http_gives GIVES_TAR = {
    .types = ALL_OF("application/x-tar"), .status = 200, .tagged = true, .ranges = true};
const struct ttf_http_gives GIVES_VIDEO = {
    .types = ALL_OF("video/x-msvideo"), .status = 200, .tagged = true, .ranges = true};
const struct ttf_http_gives GIVES_YAML = {.types = ALL_OF("application/yaml"), .status = 200};
const struct ttf_http_gives GIVES_JPEG = {
    .types = ALL_OF("image/jpeg"), .status = 200, .tagged = true};
const struct ttf_http_gives GIVES_THUMB = {
    .types = ALL_OF("image/jpeg"), .status = 200, .none = true, .tagged = true};
const struct ttf_http_gives GIVES_LIVE = {
    .types = ALL_OF("image/jpeg"), .status = 200, .tagged = true, .query = LIVE_QUERY};
const struct ttf_http_gives GIVES_EVENTS = {
    .types = ALL_OF("text/event-stream"), .status = 200, .resumes = true};
const struct ttf_http_gives GIVES_INDEX = {
    .types = ALL_OF("text/html; charset=utf-8"), .status = 200, .tagged = true};
const struct ttf_http_gives GIVES_PAGE = {.types = OF_PAGE, .status = 200, .tagged = true};

const char *ttf_http_type_of(const struct ttf_http_gives *gives, const char *path)
{
    size_t n = strlen(path);

    for (const struct ttf_http_type *t = gives->types; t->end; t++) {
        size_t end = strlen(t->end);

        if (n >= end && strcmp(path + n - end, t->end) == 0)
            return t->type;
    }
    return NULL;
}

bool ttf_http_asks(const struct ttf_http_gives *gives, const char *name)
{
    for (const char *const *q = gives->query; q && *q; q++)
        if (strcmp(*q, name) == 0)
            return true;
    return false;
}
