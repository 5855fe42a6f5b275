/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hostile box: what it answers, parted by zero bytes, behind a byte of how it answers: the manifest, the dataset's summary, records,
 * events, notes, SHA256SUMS, and one content of all other files. Pulled twice, the second time onto what the first has left. Nothing
 * lies outside the dataset's folder, no record is half, and what is said to be sealed is so by its hashes.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crew.h"
#include "disk.h"
#include "framing.h"
#include "fuzz.h"
#include "one.h"
#include "ttf/dataset/hash.h"
#include "ttf/hal/clock_backend.h"

#define FOLDER "here/grass/"

enum part {
    MANIFEST,
    SUMMARY,
    RECORDS,
    EVENTS,
    NOTES,
    SUMS,
    OTHER,
    PARTS
};

enum how {
    WHOLE = 1,   /* whatever is asked for */
    BREAKS = 2,  /* in the middle of an answer that is longer than 64 bytes */
    MISSING = 4, /* events, notes and sums are */
    CORRECT =
        8, /* the digest in the summary and the records' hash in SHA256SUMS are set right: no mutation finds them */
    FRAMED = 16 /* so are seq and crc of records and events */
};

/* ---- the wire ---- */

struct wire {
    struct {
        char *data;
        size_t n;
    } part[PARTS];
    unsigned how;
    int64_t bytes;
};

static bool ends(const char *path, const char *end)
{
    size_t n = strlen(path), m = strlen(end);

    return n >= m && strcmp(path + n - m, end) == 0;
}

static enum part part_of(const char *path)
{
    if (strcmp(path, "/datasets/grass") == 0)
        return SUMMARY;
    if (ends(path, "/files/dataset.json"))
        return MANIFEST;
    if (ends(path, "/grass/records"))
        return RECORDS;
    if (ends(path, "events.jsonl") || ends(path, "/grass/events"))
        return EVENTS;
    if (ends(path, "notes.jsonl") || ends(path, "/grass/notes"))
        return NOTES;
    return ends(path, "/files/SHA256SUMS") ? SUMS : OTHER;
}

int pull_wire_get(struct wire *wire, const char *path, int64_t first, int64_t last,
                  const char *if_tag, const struct wire_sink *sink, struct ttf_err *err)
{
    enum part part = part_of(path);
    int64_t total = (int64_t)wire->part[part].n, end;
    int r;

    (void)if_tag;
    if (wire->how & MISSING && part >= EVENTS && part <= SUMS)
        return ttf_err_set(err, -ENOENT, path, "is not there");
    if (wire->how & WHOLE) {
        first = 0;
        last = -1;
    }
    if (first > 0 && first >= total)
        return -ERANGE;
    end = last < 0 || last >= total ? total : last + 1;
    r = sink->begin ? sink->begin(sink->ctx, first) : 0;
    if (wire->how & BREAKS && end - first > 64)
        end = first + 64;
    if (r == 0 && end > first)
        r = sink->take(sink->ctx, wire->part[part].data + first, (size_t)(end - first));
    wire->bytes += end - first;
    if (r == 0 && wire->how & BREAKS && end - first == 64)
        r = ttf_err_set(err, -ECONNRESET, path, "the box has gone");
    return r;
}

struct text {
    char *data;
    size_t n, max;
    int64_t first;
};

static int text_begin(void *ctx, int64_t first)
{
    return first == ((struct text *)ctx)->first ? 0 : -EPROTO;
}

static int text_take(void *ctx, const void *data, size_t n)
{
    struct text *text = ctx;
    char *more;

    if (text->n + n > text->max)
        return -EFBIG;
    more = realloc(text->data, text->n + n + 1);
    if (!more)
        abort();
    memcpy(more + text->n, data, n);
    text->data = more;
    text->n += n;
    return 0;
}

int pull_wire_get_text(struct wire *wire, const char *path, int64_t first, int64_t last, size_t max,
                       char **ret_text, size_t *ret_bytes, struct ttf_err *err)
{
    struct text text = {.max = max, .first = first};
    const struct wire_sink sink = {text_begin, text_take, &text};
    int r = pull_wire_get(wire, path, first, last, NULL, &sink, err);

    if (r == 0 && !text.data)
        r = text_take(&text, "", 0);
    if (r < 0) {
        free(text.data);
        return err && err->code == r ? r : ttf_err_set(err, r, path, "is not as it was asked for");
    }
    text.data[text.n] = '\0';
    *ret_text = text.data;
    *ret_bytes = text.n;
    return 0;
}

int64_t pull_wire_bytes(const struct wire *wire)
{
    return wire->bytes;
}

/* ---- a crew that does it at once ---- */

struct crew {
    struct landing landing;
};

void crew_do(struct crew *crew, struct errand *e)
{
    crew->landing.name = e->name;
    crew->landing.folder = e->folder;
    crew->landing.doubtful = e->doubtful;
    e->why = (struct ttf_err){0};
    e->r =
        landing_ensure(&crew->landing, e->path, e->bytes, e->sha256, e->trust, &e->landed, &e->why);
}

void crew_wait(struct crew *crew, const struct errand *errand)
{
    (void)crew;
    (void)errand;
}

void crew_drop(struct crew *crew)
{
    (void)crew;
}

/* ---- what must hold ---- */

static int64_t no_time_ns(struct ttf_clock *clock)
{
    (void)clock;
    return TTF_NS_PER_S;
}

static const struct ttf_clock_ops CLOCK_OPS = {.now_ns = no_time_ns};

static void check_names(const struct fuzz_disk *disk)
{
    for (unsigned i = 0; i < disk->n; i++) {
        const char *path = disk->files[i].path;

        if (strncmp(path, FOLDER, strlen(FOLDER)) != 0 || strstr(path, "/../") ||
            strstr(path, "//"))
            abort();
    }
}

static void check_records(const struct fuzz_disk *disk)
{
    size_t n;
    const uint8_t *text = fuzz_disk_get(disk, FOLDER "records.jsonl", &n);

    if (text && n > 0 && text[n - 1] != '\n')
        abort();
}

static void is_hash(const struct fuzz_disk *disk, const char *path, const char *expected,
                    size_t n_hex)
{
    struct ttf_sha256 hash;
    char hex[65];
    size_t n;
    const uint8_t *data = fuzz_disk_get(disk, path, &n);

    if (!data && n == 0 && !expected)
        abort();
    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, data ? data : (const uint8_t *)"", n);
    ttf_sha256_hex(&hash, hex);
    if (strncmp(hex, expected, n_hex) != 0)
        abort();
}

static void check_seal(const struct fuzz_disk *disk, const char *digest)
{
    char path[256];
    size_t n;
    const char *text = (const char *)fuzz_disk_get(disk, FOLDER "SHA256SUMS", &n), *end;

    if (!text)
        abort();
    is_hash(disk, FOLDER "SHA256SUMS", digest, 64);
    for (end = text + n; text < end;
         text = (const char *)memchr(text, '\n', (size_t)(end - text)) + 1) {
        size_t length = (size_t)((const char *)memchr(text, '\n', (size_t)(end - text)) - text);

        (void)snprintf(path, sizeof path, FOLDER "%.*s", (int)(length - 66), text + 66);
        is_hash(disk, path, text, 64);
    }
}

static void pull(struct fuzz_disk *disk, struct wire *wire, const char *digest)
{
    struct ttf_clock clock = {.ops = &CLOCK_OPS};
    const struct ttf_pull_config config = {.io = &disk->base, .clock = &clock, .dest = "here"};
    struct crew crew = {.landing = {.io = &disk->base, .wire = wire}};
    const struct one_skips skips = {0};
    struct one_result result;
    struct ttf_err err = {0};
    int r = one_pull(&config, wire, &crew, "grass", &skips, &result, &err);

    landing_free(&crew.landing);
    if (r < 0 && err.code != r)
        abort(); /* it is not said why */
    if (result.slots < 0 || result.files < 0 || result.damaged < 0)
        abort();
    check_names(disk);
    check_records(disk);
    if (result.sealed && r == 0)
        check_seal(disk, digest);
    if (fuzz_disk_open_handles(disk) > 0)
        abort();
}

/* ---- */

static void hash_of(const struct wire *wire, enum part part, char ret[65])
{
    struct ttf_sha256 hash;

    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, wire->part[part].data, wire->part[part].n);
    ttf_sha256_hex(&hash, ret);
}

static void frame(struct wire *wire, enum part part)
{
    size_t n;
    char *framed = fuzz_frame_lines((const uint8_t *)wire->part[part].data, wire->part[part].n, &n);

    free(wire->part[part].data);
    wire->part[part].data = framed;
    wire->part[part].n = n;
}

static void put_right(struct wire *wire, char digest[65])
{
    static const char NAME[] = "  records.jsonl\n";
    char *text = malloc(200), hex[65];

    if (!text)
        abort();
    if (wire->how & FRAMED) {
        frame(wire, RECORDS);
        frame(wire, EVENTS);
    }
    hash_of(wire, RECORDS, hex);
    for (size_t i = 64; wire->how & CORRECT && i + sizeof NAME - 1 <= wire->part[SUMS].n; i++)
        if (memcmp(wire->part[SUMS].data + i, NAME, sizeof NAME - 1) == 0)
            memcpy(wire->part[SUMS].data + i - 64, hex, 64);
    hash_of(wire, SUMS, digest);
    if (wire->how & CORRECT) {
        free(wire->part[SUMMARY].data);
        wire->part[SUMMARY].data = text;
        wire->part[SUMMARY].n =
            (size_t)snprintf(text, 200, "{\"slots\":3,\"sealed\":true,\"digest\":\"%s\"}", digest);
    } else {
        free(text);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct wire wire = {.how = size > 0 ? data[0] : 0};
    const uint8_t *at = data + (size > 0), *end = data + size;
    struct fuzz_disk disk;
    char digest[65];

    for (unsigned i = 0; i < PARTS; i++) {
        const uint8_t *stop = at < end ? memchr(at, 0, (size_t)(end - at)) : NULL;
        size_t n = (size_t)((stop && i + 1 < PARTS ? stop : end) - at);

        wire.part[i].data = malloc(n + 1);
        if (!wire.part[i].data)
            abort();
        if (n > 0)
            memcpy(wire.part[i].data, at, n);
        wire.part[i].n = n;
        at = stop && i + 1 < PARTS ? stop + 1 : end;
    }
    put_right(&wire, digest);
    fuzz_disk_init(&disk);
    pull(&disk, &wire, digest);
    wire.how &= ~(unsigned)(BREAKS | WHOLE);
    pull(&disk, &wire, digest);
    fuzz_disk_free(&disk);
    for (unsigned i = 0; i < PARTS; i++)
        free(wire.part[i].data);
    return 0;
}
