/* SPDX-License-Identifier: Apache-2.0 */
#include "preview_watch.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/json_parse.h"

#define STATE_MAX ((size_t)64 * 1024)

/* How many images are in it; 0: none is there that can be shown. */
static int64_t read_images(struct ttf_io *io, const char *path)
{
    int64_t images = 0;
    char *text = NULL;
    json_t *object;
    size_t bytes;

    if (ttf_io_slurp(io, path, STATE_MAX, &text, &bytes, NULL) < 0)
        return 0;
    if (ttf_json_parse(text, bytes, &object, NULL) == 0) {
        if (json_array_size(json_object_get(object, "frames")) > 0)
            images = json_integer_value(json_object_get(object, "images"));
        json_decref(object);
    }
    free(text);
    return images;
}

static void tell(struct daemon *d, const char *dataset)
{
    struct ttf_json json;
    char path[128];

    (void)snprintf(path, sizeof path, "/api/v1/datasets/%s/preview", dataset);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "dataset", dataset);
    ttf_json_kstring(&json, "path", path);
    ttf_json_object_end(&json);
    daemon_publish(d, "preview", &json);
}

void preview_watch_look(struct preview_watch *watch, struct daemon *d)
{
    struct ttf_io_stat st;
    char dataset[65], path[512 + 96];
    int64_t images;
    bool first;

    situation_dataset(d->situation, dataset);
    first = strcmp(dataset, watch->dataset) != 0;
    if (first) {
        *watch = (struct preview_watch){0};
        memcpy(watch->dataset, dataset, sizeof watch->dataset);
    }
    (void)snprintf(path, sizeof path, "%s/.preview/%s/state.json", d->config.data, dataset);
    if (!*dataset || d->io->ops->stat(d->io, path, &st) < 0 || !st.is_regular)
        return;
    if (st.inode == watch->seen.inode && st.mtime_ns == watch->seen.mtime_ns)
        return;
    watch->seen = st;
    images = read_images(d->io, path);
    if (!first && images > 0 && images != watch->images)
        tell(d, dataset);
    watch->images = images;
}
