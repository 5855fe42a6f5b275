/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/plain_stream.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"

int folder_setup(void **state)
{
    const char *base = getenv("TMPDIR"); /* NOLINT(concurrency-mt-unsafe) */
    char *path = NULL;

    if (asprintf(&path, "%s/ttf-store-XXXXXX", base ? base : "/tmp") < 0 || !mkdtemp(path))
        return -1;
    *state = path;
    return 0;
}

int folder_teardown(void **state)
{
    run("rm -rf '%s'", (char *)*state);
    free(*state);
    return 0;
}

const char *in(const char *folder, const char *fmt, ...)
{
    static char buffers[16][512];
    static unsigned next;
    char *buffer = buffers[next++ % 16];
    va_list args;
    int n = snprintf(buffer, sizeof(buffers[0]), "%s/", folder);

    va_start(args, fmt);
    vsnprintf(buffer + n, sizeof(buffers[0]) - (size_t)n, fmt, args);
    va_end(args);
    return buffer;
}

int run(const char *fmt, ...)
{
    char *line = NULL, *quiet = NULL;
    va_list args;
    int status = -1;

    va_start(args, fmt);
    if (vasprintf(&line, fmt, args) >= 0 && asprintf(&quiet, "{ %s\n} >/dev/null 2>&1", line) >= 0)
        status = system(quiet); /* NOLINT(concurrency-mt-unsafe,cert-env33-c) */
    va_end(args);
    free(quiet);
    free(line);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int sha256sum_check(const char *dataset)
{
    return run("cd '%s' && sha256sum --strict -c SHA256SUMS", dataset);
}

void small_manifest(struct ttf_manifest *manifest)
{
    assert_int_equal(ttf_manifest_init(manifest, NULL), 0);
    plain_stream(manifest, "linear-srgb");
}

static void small_segment(struct ttf_segment *s)
{
    memset(s, 0, sizeof(*s));
    strcpy(s->boot_id, "0a0b0c0d-0000-4000-8000-000000000001");
    strcpy(s->trust, "rtc");
    strcpy(s->zone, "UTC");
    s->origin_ns = 5 * TTF_NS_PER_S;
    s->origin_utc_ns = INT64_C(1790000000000000000);
    s->uncertainty_ns = TTF_NS_PER_S;
    s->interval_ns = 10 * TTF_NS_PER_S;
}

struct ttf_writer *small_create(struct ttf_io *io, const char *path)
{
    struct ttf_manifest manifest;
    struct ttf_segment segment;
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    small_manifest(&manifest);
    if (ttf_writer_create(io, path, &manifest, "interval: 10s\n", "{}\n", &writer, &err) != 0)
        return NULL;
    small_segment(&segment);
    if (ttf_writer_segment(writer, &segment, &err) != 0) {
        ttf_writer_abandon(writer);
        return NULL;
    }
    return writer;
}

void small_bytes(int64_t index, char ret[64])
{
    memset(ret, 'a' + (char)(index % 26), 64);
    snprintf(ret, 64, "frame %lld", (long long)index);
}

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    char bytes[64];
    int r;

    small_bytes(*(int64_t *)ctx, bytes);
    r = ttf_io_append_all(io, file, bytes, 40);
    return r ? r : ttf_io_append_all(io, file, bytes + 40, 24);
}

int small_slot(struct ttf_writer *writer, int64_t index)
{
    struct ttf_slot_record record;
    int r;

    ttf_slot_record_init(&record);
    if (ttf_slot_record_images(&record, 1) != 0)
        return -1;
    record.index = index;
    record.due_ns = (5 + 10 * index) * TTF_NS_PER_S;
    strcpy(record.images[0].stream, "main");
    record.images[0].n_averaged = 1;
    record.images[0].n_files = 1;
    r = ttf_writer_file(writer, "developed", "main", index, -1, "tif", produce, &index,
                        &record.images[0].files[0], NULL);
    if (r == 0)
        r = ttf_writer_commit(writer, &record, NULL);
    ttf_slot_record_free(&record);
    return r;
}

int64_t small_check(struct ttf_io *io, const char *path)
{
    struct ttf_reader *reader;
    struct ttf_slot_record record;
    const struct ttf_file_ref *file;
    int64_t i, n;
    char bytes[64], hex[65], full[512], *text;
    size_t size;

    assert_int_equal(ttf_reader_open(io, path, &reader, NULL), 0);
    n = ttf_reader_summary(reader)->slots;
    for (i = 0; i < n; i++) {
        assert_int_equal(ttf_reader_slot(reader, i, &record, NULL), 0);
        assert_int_equal(record.index, i);
        assert_int_equal(record.n_images, 1);
        file = &record.images[0].files[0];
        snprintf(full, sizeof(full), "%s/%s", path, file->path); /* in() would come round */
        text = file_text(full, &size);
        small_bytes(record.index, bytes);
        assert_int_equal(size, 64);
        assert_int_equal(file->bytes, 64);
        assert_memory_equal(text, bytes, 64);
        assert_int_equal(ttf_sha256_file(io, full, NULL, hex, NULL), 0);
        assert_string_equal(hex, file->sha256);
        free(text);
        ttf_slot_record_free(&record);
    }
    ttf_reader_close(reader);
    return n;
}

char *file_text(const char *path, size_t *ret_bytes)
{
    struct ttf_err err = {0};
    char *text = NULL;

    if (ttf_io_slurp(ttf_io_posix(), path, 1u << 30, &text, ret_bytes, &err) != 0)
        fail_msg("%s: %s", path, err.what);
    return text;
}

void write_text(const char *path, const void *data, size_t n)
{
    FILE *f;

    (void)unlink(path); /* ext4 waits for the disk when a file is written over */
    f = fopen(path, "we");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, n, f), n);
    assert_int_equal(fclose(f), 0);
}

bool exists(const char *path)
{
    struct stat st;

    return stat(path, &st) == 0;
}

int64_t size_of(const char *path)
{
    struct stat st;

    return stat(path, &st) == 0 ? st.st_size : -1;
}
