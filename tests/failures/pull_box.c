/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "datasets/plain_stream.h"
#include "pull_box.h"
#include "ttf/dataset/verify.h"
#include "ttf/http/listen.h"
#include "unit/http/scratch.h"

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    (void)err;
    return ttf_io_append_all(io, file, ctx, sizeof(int64_t));
}

static void one_slot(struct ttf_writer *writer, int64_t index)
{
    struct ttf_slot_record record;
    struct ttf_image *image;

    ttf_slot_record_init(&record);
    record.index = index;
    record.due_ns = (5 + 10 * index) * TTF_NS_PER_S;
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    image = &record.images[0];
    strcpy(image->stream, "main");
    image->n_averaged = image->n_files = 1;
    assert_int_equal(ttf_writer_file(writer, "developed", "main", index, -1, "tif", produce, &index,
                                     &image->files[0], NULL),
                     0);
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
}

static void many_slots(struct ttf_io *io, int slots)
{
    struct ttf_segment segment = {.origin_ns = 5 * TTF_NS_PER_S,
                                  .origin_utc_ns = INT64_C(1790000000000000000),
                                  .uncertainty_ns = TTF_NS_PER_S,
                                  .interval_ns = 10 * TTF_NS_PER_S,
                                  .boot_id = "0a0b0c0d-0000-4000-8000-000000000001",
                                  .trust = "rtc",
                                  .zone = "UTC"};
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    char digest[65];

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    plain_stream(&manifest, "linear-srgb");
    assert_int_equal(
        ttf_writer_create(io, SMALL_PATH, &manifest, "interval: 10s\n", "{}\n", &writer, NULL), 0);
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    for (int i = 0; i < slots; i++)
        one_slot(writer, i);
    assert_int_equal(ttf_writer_seal(writer, "count", digest, NULL), 0);
    ttf_writer_close(writer);
}

static void lay_out(struct model_disk *disk)
{
    for (int i = 0; i < disk->n_names; i++) {
        const struct model_name *name = &disk->names[i];
        char path[220];

        if (name->seen < 0 || disk->inodes[name->seen].is_dir ||
            strncmp(name->path, SMALL_PATH "/", strlen(SMALL_PATH) + 1) != 0)
            continue;
        (void)snprintf(path, sizeof path, "data/d/%s", name->path + strlen(SMALL_PATH) + 1);
        scratch_file(path, disk->inodes[name->seen].seen, disk->inodes[name->seen].seen_bytes);
    }
}

void pull_box_begin(struct pull_box *box, int slots)
{
    struct ttf_http_config config = {.folder = "data", .io = ttf_io_posix()};
    struct ttf_http_socket socket = {.fd = -1};
    struct small_run run;

    small_disk_init(&box->disk);
    run = (struct small_run){.io = &box->disk.io};
    if (slots > 0)
        many_slots(&box->disk.io, slots);
    else
        small_run(&run);
    assert_true(slots > 0 || run.sealed);
    lay_out(&box->disk);
    config.clock = box->clock = ttf_clock_real_create();
    assert_true(box->clock != NULL);
    assert_int_equal(ttf_http_server_create(&config, &box->server, NULL), 0);
    assert_int_equal(ttf_http_listen("unix:http", false, &socket, NULL), 0);
    assert_int_equal(ttf_http_server_listen(box->server, socket.fd, true, NULL), 0);
}

void pull_box_end(struct pull_box *box)
{
    ttf_http_server_destroy(box->server);
    ttf_clock_destroy(box->clock);
    model_disk_free(&box->disk);
    (void)unlink("http");
}

int pull_box_pull(struct pull_box *box, struct model_disk *disk, struct ttf_pull_result *ret,
                  struct ttf_err *err)
{
    const struct ttf_pull_config config = {
        .io = &disk->io, .clock = box->clock, .box = "unix:http", .dest = "/m"};

    return ttf_pull(&config, ret, err);
}

#define WRONG(...) return (void)snprintf(ret, SMALL_TEXT, __VA_ARGS__), false

/* Whatever of the dataset is here is whole. */
bool pull_box_is_whole(struct model_disk *disk, char ret[SMALL_TEXT])
{
    const struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    bool damaged;
    int r;

    if (!model_disk_has(disk, SMALL_PATH "/dataset.json") ||
        !model_disk_has(disk, SMALL_PATH "/records.jsonl"))
        return true;
    r = ttf_verify(&disk->io, SMALL_PATH, &options, &report, NULL);
    if (r < 0)
        WRONG("verify: %d", r);
    damaged = report.damaged;
    if (damaged && report.n_findings > 0)
        (void)snprintf(ret, SMALL_TEXT, "%s: %s", report.findings[0].file, report.findings[0].text);
    ttf_verify_report_free(&report);
    return !damaged;
}

static int inode_of(const struct model_disk *disk, const char *path)
{
    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0 && strcmp(disk->names[i].path, path) == 0)
            return disk->names[i].seen;
    return -1;
}

bool pull_box_is_same(const struct pull_box *box, const struct model_disk *disk,
                      char ret[SMALL_TEXT])
{
    for (int i = 0; i < box->disk.n_names; i++) {
        const struct model_name *name = &box->disk.names[i];
        const struct model_inode *a, *b;
        int there;

        if (name->seen < 0 || box->disk.inodes[name->seen].is_dir ||
            strncmp(name->path, SMALL_PATH "/", strlen(SMALL_PATH) + 1) != 0)
            continue;
        there = inode_of(disk, name->path);
        if (there < 0)
            WRONG("%s is not here", name->path);
        a = &box->disk.inodes[name->seen];
        b = &disk->inodes[there];
        if (a->seen_bytes != b->seen_bytes ||
            (a->seen_bytes > 0 && memcmp(a->seen, b->seen, a->seen_bytes) != 0))
            WRONG("%s is another", name->path);
    }
    return true;
}
