/* SPDX-License-Identifier: Apache-2.0 */
/* state.json of a preview, as the next refresh finds it: whatever it says, a failed try is told in it, and a good one replaces it. */
#include <stdlib.h>
#include <string.h>

#include "disk.h"
#include "fuzz.h"
#include "preview.h"
#include "ttf/dataset/json_parse.h"

#define FOLDER "no-such-folder" /* on no disk */
#define STATE  FOLDER "/.preview/grass/state.json"

static void is_state(const struct fuzz_disk *disk, const char *expected)
{
    const char *state;
    json_t *json;
    size_t n;
    const uint8_t *text = fuzz_disk_get(disk, STATE, &n);

    if (!text || ttf_json_parse((const char *)text, n, &json, NULL) < 0)
        abort();
    state = json_string_value(json_object_get(json, "state"));
    if (!state || strcmp(state, expected) != 0)
        abort();
    json_decref(json);
}

static void check(struct fuzz_disk *disk, struct preview_cache *cache,
                  const struct preview_subject *subject)
{
    const struct preview_made made = {
        .width = 8, .height = 8, .shrunk_by = 1, .frame_step = 1, .n_frames = 1};

    if (cache->generation < 0 || strlen(cache->uuid) >= sizeof cache->uuid)
        abort();
    if (preview_cache_fail(&disk->base, cache, subject, "no room", 1, NULL) == 0)
        is_state(disk, "failed");
    if (preview_cache_begin(&disk->base, cache, NULL) < 0)
        return;
    fuzz_disk_put(disk, FOLDER "/.preview/grass/making", "", 0);
    if (preview_cache_commit(&disk->base, cache, subject, &made, 1, NULL) == 0)
        is_state(disk, "ready");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct preview_subject subject = {
        .name = "grass", .uuid = "0a0b0c0d-0000-4000-8000-000000000001", .images = 7};
    struct preview_cache cache;
    struct fuzz_disk disk;

    fuzz_disk_init(&disk);
    fuzz_disk_put(&disk, STATE, data, size);
    if (preview_cache_open(&disk.base, FOLDER, &subject, &cache, NULL) == 0)
        check(&disk, &cache, &subject);
    preview_cache_close(&cache);
    if (fuzz_disk_open_handles(&disk) > 0)
        abort();
    fuzz_disk_free(&disk);
    return 0;
}
