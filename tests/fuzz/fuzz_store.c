/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A dataset whose records.jsonl, events.jsonl and SHA256SUMS are the input: a byte of mode, then
 * each file, with a zero byte between. A fourth part names one more file that lies in the folder.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "framing.h"
#include "fuzz.h"
#include "store.h"

struct part {
    const uint8_t *data;
    size_t size;
};

/* Up to the next zero byte. */
static struct part take(struct part *rest)
{
    const uint8_t *zero = rest->size ? memchr(rest->data, '\0', rest->size) : NULL;
    struct part part = {rest->data, zero ? (size_t)(zero - rest->data) : rest->size};
    size_t used = part.size + (zero ? 1 : 0);

    *rest = (struct part){rest->data + used, rest->size - used};
    return part;
}

static void put_lines(struct fuzz_disk *disk, const char *path, struct part part, bool framed)
{
    size_t n;
    char *text;

    if (!framed) {
        fuzz_disk_put(disk, path, part.data, part.size);
        return;
    }
    text = fuzz_frame_lines(part.data, part.size, &n);
    fuzz_disk_put(disk, path, text, n);
    free(text);
}

/* Of a name that a directory can give: no "//", no dots alone, no part of another file's name. */
static void put_stray(struct fuzz_disk *disk, struct part part)
{
    char path[128];
    size_t size;

    if (part.size == 0 || part.size > 100)
        return;
    (void)snprintf(path, sizeof path, FUZZ_DATASET "/%.*s", (int)part.size,
                   (const char *)part.data);
    if (strstr(path, "//") || strstr(path, "/.") || path[strlen(path) - 1] == '/' ||
        strncmp(path, FUZZ_DATASET "/frames/main/", 15) != 0 || strchr(path + 15, '/') ||
        fuzz_disk_get(disk, path, &size))
        return;
    fuzz_disk_put(disk, path, "stray\n", 6);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_disk disk;
    struct part rest = {data + 1, size - 1}, records, events, sums;

    if (size == 0)
        return 0;
    fuzz_disk_init(&disk);
    fuzz_store_small(&disk, 0);
    records = take(&rest);
    events = take(&rest);
    sums = take(&rest);
    put_lines(&disk, FUZZ_DATASET "/records.jsonl", records, data[0] & FUZZ_FRAME_RECORDS);
    put_lines(&disk, FUZZ_DATASET "/events.jsonl", events, data[0] & FUZZ_FRAME_EVENTS);
    if (sums.size > 0)
        fuzz_store_put_sums(&disk, sums.data, sums.size, data[0]);
    put_stray(&disk, rest);
    fuzz_store_check(&disk);
    fuzz_disk_free(&disk);
    return 0;
}
