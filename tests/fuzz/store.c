/* SPDX-License-Identifier: Apache-2.0 */
#include "store.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "framing.h"
#include "lines.h"
#include "sums.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"
#include "ttf/dataset/writer.h"

#define AT(path) FUZZ_DATASET "/" path

static const char MANIFEST[] =
    "{\"format\":{\"name\":\"ttf\",\"major\":1,\"minor\":0},"
    "\"uuid\":\"f00dcafe-0000-4000-8000-00006eec9b9f\",\"simulated\":false,"
    "\"streams\":[{\"id\":\"main\",\"quantity\":\"reflectance\",\"width\":4,\"height\":3,"
    "\"samples\":3,\"sample_format\":\"u16\",\"encoding\":{\"pedestal\":2047,\"scale\":31744}}]}";
static const char PLAN[] = "interval: 10s\ncount: 3\n";

/* ---- a small dataset ---- */

static void sha256_of(const void *data, size_t size, char ret[65])
{
    struct ttf_sha256 hash;

    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, data, size);
    ttf_sha256_hex(&hash, ret);
}

/* Puts the file there and writes its entry of a record. */
static size_t put_file(struct fuzz_disk *disk, const char *role, const char *path, const char *data,
                       char *entry, size_t room)
{
    char full[128], sha256[65];

    (void)snprintf(full, sizeof full, AT("%s"), path);
    fuzz_disk_put(disk, full, data, strlen(data));
    sha256_of(data, strlen(data), sha256);
    return (size_t)snprintf(entry, room, "{%s\"path\":\"%s\",\"bytes\":%zu,\"sha256\":\"%s\"}",
                            role, path, strlen(data), sha256);
}

static void put_framed(struct fuzz_disk *disk, const char *path, const void *data, size_t size)
{
    size_t n;
    char *framed = fuzz_frame_lines(data, size, &n);

    fuzz_disk_put(disk, path, framed, n);
    free(framed);
}

void fuzz_store_small(struct fuzz_disk *disk, unsigned mode)
{
    char text[4096], path[64], data[64];
    size_t n;

    fuzz_disk_put(disk, AT("dataset.json"), MANIFEST, sizeof MANIFEST - 1);
    fuzz_disk_put(disk, AT("events.jsonl"), "", 0);
    n = (size_t)sprintf(text, "{\"type\":\"plan\",\"seq\":0,\"plan\":0,\"files\":[");
    n += put_file(disk, "", "plans/0.yaml", PLAN, text + n, sizeof text - n);
    n += (size_t)sprintf(text + n, "]\n{\"type\":\"segment\",\"seq\":0,\"segment\":0,"
                                   "\"first_index\":0,\"origin_ns\":5000000000,\"trust\":\"none\","
                                   "\"interval_ns\":10000000000,\"plan\":0\n");
    for (int i = 0; i < FUZZ_SLOTS; i++) {
        (void)snprintf(path, sizeof path, "frames/main/%06d.tif", i);
        (void)snprintf(data, sizeof data, "picture %d\n", i);
        n += (size_t)sprintf(text + n,
                             "{\"type\":\"slot\",\"seq\":0,\"index\":%d,\"segment\":0,"
                             "\"due_ns\":%d000000000,\"result\":\"captured\",\"images\":[{"
                             "\"stream\":\"main\",\"n_averaged\":1,\"files\":[",
                             i, 5 + 10 * i);
        n += put_file(disk, "\"role\":\"developed\",", path, data, text + n, sizeof text - n);
        n += (size_t)sprintf(text + n, "]}]\n");
    }
    if (mode & FUZZ_ENDED)
        n += (size_t)sprintf(text + n, "{\"type\":\"end\",\"seq\":0,\"reason\":\"count\","
                                       "\"slots\":3,\"captured\":3\n");
    put_framed(disk, AT("records.jsonl"), text, n);
}

static void mend_line(const struct fuzz_disk *disk, char *line, size_t n)
{
    const char *path;
    char full[256], sha256[65];
    const uint8_t *data;
    size_t size;

    if (!ttf_sums_parse(line, n, &path) || n - TTF_SUMS_PREFIX > 200)
        return;
    (void)snprintf(full, sizeof full, AT("%.*s"), (int)(n - TTF_SUMS_PREFIX), path);
    data = fuzz_disk_get(disk, full, &size);
    if (!data)
        return;
    sha256_of(data, size, sha256);
    memcpy(line, sha256, 64);
}

void fuzz_store_put_sums(struct fuzz_disk *disk, const uint8_t *data, size_t size, unsigned mode)
{
    char *text = malloc(size + 1);

    if (!text)
        abort();
    memcpy(text, data, size);
    for (size_t at = 0; mode & FUZZ_MEND_SUMS && at < size;) {
        const char *end = memchr(text + at, '\n', size - at);
        size_t length = end ? (size_t)(end - text) - at : size - at;

        mend_line(disk, text + at, length);
        at += length + 1;
    }
    fuzz_disk_put(disk, AT("SHA256SUMS"), text, size);
    free(text);
}

/* ---- what must hold ---- */

/* What looking at a dataset says. */
struct verdict {
    int verified; /* as ttf_verify returned */
    bool damaged, sealed;
    int64_t leftovers;
    int read; /* as ttf_reader_open returned */
    int64_t slots;
};

static int64_t read_all(struct ttf_reader *reader)
{
    int64_t n = ttf_reader_summary(reader)->slots;
    struct ttf_slot_record record;
    struct ttf_err err = {0};

    for (int64_t i = 0; i < n; i++) {
        if (ttf_reader_slot(reader, i, &record, &err) < 0)
            continue;
        if (ttf_reader_find(reader, record.index) != i)
            abort();
        (void)ttf_reader_due_utc_ns(reader, &record);
        ttf_slot_record_free(&record);
    }
    return n;
}

static struct verdict look(struct fuzz_disk *disk)
{
    const struct ttf_verify_options options = {.deep = true};
    uint64_t before = fuzz_disk_digest(disk);
    unsigned handles = fuzz_disk_open_handles(disk);
    struct ttf_verify_report report;
    struct ttf_reader *reader;
    struct verdict v = {0};
    struct ttf_err err = {0};

    v.verified = ttf_verify(&disk->base, FUZZ_DATASET, &options, &report, &err);
    if (v.verified == 0) {
        v.damaged = report.damaged;
        v.sealed = report.sealed;
        v.leftovers = report.n_of[TTF_FINDING_LEFTOVER];
        ttf_verify_report_free(&report);
    }
    v.read = ttf_reader_open(&disk->base, FUZZ_DATASET, &reader, &err);
    if (v.read == 0) {
        v.slots = read_all(reader);
        ttf_reader_close(reader);
    }
    if (fuzz_disk_digest(disk) != before || fuzz_disk_open_handles(disk) != handles)
        abort(); /* looking has changed something */
    return v;
}

/* The whole lines of a file, before somebody goes on with it. */
struct whole_lines {
    const char *path;
    uint8_t *data;
    int64_t bytes;
};

static struct whole_lines whole_lines(struct fuzz_disk *disk, const char *path)
{
    struct whole_lines whole = {.path = path};
    struct ttf_lines_tail tail;
    struct ttf_err err = {0};
    size_t size;
    const uint8_t *data = fuzz_disk_get(disk, path, &size);

    if (data && ttf_lines_scan(&disk->base, path, NULL, NULL, NULL, &tail, &err) == 0) {
        whole.bytes = tail.good_bytes;
        whole.data = malloc((size_t)tail.good_bytes + 1);
        if (!whole.data)
            abort();
        memcpy(whole.data, data, (size_t)tail.good_bytes);
    }
    return whole;
}

static void still_there(const struct fuzz_disk *disk, struct whole_lines *whole, bool opened)
{
    size_t size;
    const uint8_t *data = fuzz_disk_get(disk, whole->path, &size);

    if (opened && whole->data &&
        ((int64_t)size < whole->bytes || memcmp(data, whole->data, (size_t)whole->bytes) != 0))
        abort(); /* a line that was whole is not there any more */
    free(whole->data);
}

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    return ttf_io_pwrite_all(io, file, "new picture\n", 12, 0);
}

/* One event, one segment where there is none, one slot with a file. False: an index too high to go on. */
static bool go_on(struct ttf_writer *writer)
{
    const struct ttf_writer_state *state = ttf_writer_state(writer);
    const struct ttf_segment first = {.origin_utc_ns = TTF_NS_UNKNOWN,
                                      .trust = "none",
                                      .uncertainty_ns = TTF_NS_UNKNOWN,
                                      .plan = -1};
    struct ttf_slot_record record;
    struct ttf_err err = {0};
    int r = 0;

    if (ttf_writer_event(writer, "door", 1, TTF_NS_UNKNOWN, "opened", NULL, &err) < 0)
        abort();
    if (state->next_index >= INT64_C(1) << 40)
        return false;
    if (state->n_segments == 0)
        r = ttf_writer_segment(writer, &first, &err);
    ttf_slot_record_init(&record);
    record.index = state->next_index;
    record.segment = state->n_segments - 1;
    record.due_ns = 1;
    if (r < 0 || ttf_slot_record_images(&record, 1) < 0)
        abort();
    (void)snprintf(record.images[0].stream, sizeof record.images[0].stream, "main");
    record.images[0].n_averaged = record.images[0].n_files = 1;
    if (ttf_writer_file(writer, "developed", "main", record.index, -1, "tif", produce, NULL,
                        &record.images[0].files[0], &err) < 0 ||
        ttf_writer_commit(writer, &record, &err) < 0)
        abort();
    ttf_slot_record_free(&record);
    return true;
}

/* What was sound stays sound, with that many slots more. */
static void still_sound(struct fuzz_disk *disk, const struct verdict *was, int64_t more)
{
    struct verdict now = look(disk);

    if (was->verified == 0 && (now.verified < 0 || (now.damaged && !was->damaged)))
        abort();
    if (was->read == 0 && (now.read < 0 || now.slots != was->slots + more))
        abort();
}

static void write_on(struct fuzz_disk *disk, struct ttf_writer *writer, const struct verdict *was)
{
    struct ttf_err err = {0};
    int64_t more = go_on(writer) ? 1 : 0;

    still_sound(disk, was, more);
    if (was->verified == 0 && !was->damaged && ttf_writer_seal(writer, "stopped", NULL, &err) < 0)
        abort();
    ttf_writer_close(writer);
    still_sound(disk, was, more);
    if (was->verified == 0 && !was->damaged && !look(disk).sealed)
        abort();
}

static struct ttf_writer *open_it(struct fuzz_disk *disk)
{
    struct ttf_writer *writer = NULL;
    struct ttf_err err = {0};

    if (ttf_writer_open(&disk->base, FUZZ_DATASET, &writer, &err) < 0 && err.code == 0)
        abort(); /* refused without a word */
    return writer;
}

void fuzz_store_check(struct fuzz_disk *disk)
{
    struct verdict was = look(disk);
    struct whole_lines records = whole_lines(disk, AT("records.jsonl"));
    struct whole_lines events = whole_lines(disk, AT("events.jsonl"));
    uint64_t before = fuzz_disk_digest(disk);
    struct ttf_writer *writer = open_it(disk);
    bool opened = writer != NULL;

    if (!opened && fuzz_disk_digest(disk) != before)
        abort(); /* refused, but touched */
    still_there(disk, &records, opened);
    still_there(disk, &events, opened);
    if (opened) {
        ttf_writer_close(writer);
        still_sound(disk, &was, 0);
        before = fuzz_disk_digest(disk);
        writer = open_it(disk);
        if (!writer || ttf_writer_state(writer)->repaired > 0 || fuzz_disk_digest(disk) != before)
            abort(); /* what was repaired once is whole */
        write_on(disk, writer, &was);
    }
    if (fuzz_disk_open_handles(disk) > 0)
        abort();
}
