/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A motion JPEG in an AVI (RIFF, as Microsoft's "AVI RIFF File Reference" has it): a head, the JPEGs as they lie on the disk, an index. Its length
 * is known before its first byte, and nothing is encoded anew.
 */
#include "preview_video.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "previews.h"

#define FRAMES_MAX  256
#define FRAME_MAX   ((int64_t)16 << 20) /* bytes of one */
#define PER_SECOND  8
#define HEAD        224 /* bytes before the first frame's chunk */
#define CHUNK       8   /* bytes of a chunk's head */
#define INDEX_ENTRY 16

struct frame {
    char path[TTF_HTTP_REST_MAX + 1];
    uint32_t bytes;
    int64_t at; /* of its chunk in the file */
};

struct video {
    const struct folder *folder;
    char dataset[TTF_HTTP_NAME_MAX + 1];
    uint32_t width, height;
    unsigned n;
    struct frame *frame;
    int64_t index_at, bytes;
    uint64_t inode, made_ns; /* of the first frame: another preview has another */
    uint8_t head[HEAD];
    uint8_t *index;
    int fd; /* of the frame that was read last; -1: none */
    unsigned fd_of;
};

static void video_free(void *ctx)
{
    struct video *v = ctx;

    if (!v)
        return;
    if (v->fd >= 0)
        (void)close(v->fd);
    free(v->frame);
    free(v->index);
    free(v);
}

/* ---- what is in it ---- */

static int add_frame(struct video *v, json_t *frame)
{
    const char *path = json_string_value(json_object_get(frame, "path"));
    struct frame *f = &v->frame[v->n];
    struct stat st;
    int fd;

    if (!path || strlen(path) >= sizeof f->path)
        return -EINVAL;
    fd = folder_preview(v->folder, v->dataset, path, &st);
    if (fd < 0)
        return fd;
    (void)close(fd);
    if (st.st_size < 4 || st.st_size > FRAME_MAX)
        return -EINVAL;
    memcpy(f->path, path, strlen(path) + 1);
    f->bytes = (uint32_t)st.st_size;
    if (v->n == 0) {
        v->inode = (uint64_t)st.st_ino;
        v->made_ns = (uint64_t)st.st_mtim.tv_sec * 1000000000U + (uint64_t)st.st_mtim.tv_nsec;
    }
    v->n++;
    return 0;
}

static int find_frames(struct video *v)
{
    json_t *state = NULL, *frames, *frame;
    struct stat st;
    int fd = previews_open(v->folder, v->dataset, &st, &state);
    int r;
    size_t i;

    if (fd < 0)
        return fd;
    (void)close(fd);
    frames = json_object_get(state, "frames");
    v->width = (uint32_t)json_integer_value(json_object_get(state, "width"));
    v->height = (uint32_t)json_integer_value(json_object_get(state, "height"));
    v->frame = calloc(FRAMES_MAX, sizeof *v->frame);
    r = !v->frame ? -ENOMEM : json_array_size(frames) == 0 ? -ENOENT : 0;
    json_array_foreach(frames, i, frame)
    {
        if (r == 0 && v->n < FRAMES_MAX)
            r = add_frame(v, frame);
    }
    json_decref(state);
    return r;
}

/* ---- the parts that are no frames ---- */

static uint8_t *put32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        *at++ = (uint8_t)(value >> (8 * i));
    return at;
}

static uint8_t *put_tag(uint8_t *at, const char *tag)
{
    memcpy(at, tag, 4);
    return at + 4;
}

static uint8_t *put_chunk(uint8_t *at, const char *tag, uint32_t bytes)
{
    return put32(put_tag(at, tag), bytes);
}

static uint32_t padded(uint32_t bytes)
{
    return bytes + (bytes & 1);
}

static void make_head(struct video *v, uint32_t movi_bytes, uint32_t largest)
{
    uint8_t *at = put_tag(put_chunk(v->head, "RIFF", (uint32_t)(v->bytes - CHUNK)), "AVI ");

    at = put_tag(put_chunk(at, "LIST", 192), "hdrl");
    at = put_chunk(at, "avih", 56);
    at = put32(at, 1000000 / PER_SECOND); /* microseconds a frame */
    at = put32(at, largest * PER_SECOND);
    at = put32(at, 0);
    at = put32(at, 0x10); /* it has an index */
    at = put32(at, v->n);
    at = put32(at, 0);
    at = put32(at, 1); /* streams */
    at = put32(at, largest);
    at = put32(at, v->width);
    at = put32(at, v->height);
    memset(at, 0, 16);
    at = put_tag(put_chunk(at + 16, "LIST", 116), "strl");
    at = put_chunk(at, "strh", 56);
    at = put_tag(put_tag(at, "vids"), "MJPG");
    memset(at, 0, 12);
    at = put32(at + 12, 1); /* rate / scale: frames a second */
    at = put32(at, PER_SECOND);
    at = put32(at, 0);
    at = put32(at, v->n);
    at = put32(at, largest);
    at = put32(at, UINT32_MAX); /* quality: not said */
    at = put32(at, 0);
    at = put32(at, 0);
    at = put32(at, v->width | v->height << 16);
    at = put_chunk(at, "strf", 40);
    at = put32(at, 40);
    at = put32(at, v->width);
    at = put32(at, v->height);
    at = put32(at, 1 | 24U << 16); /* planes, bits */
    at = put_tag(at, "MJPG");
    at = put32(at, v->width * v->height * 3);
    memset(at, 0, 16);
    (void)put_tag(put_chunk(at + 16, "LIST", movi_bytes), "movi");
}

/* Its length, as far as the frames make it: a RIFF's lengths have 32 bits, and players take them as signed. */
static int check_length(const struct video *v)
{
    int64_t bytes = HEAD + CHUNK;

    for (unsigned i = 0; i < v->n; i++)
        bytes += CHUNK + (int64_t)padded(v->frame[i].bytes) + INDEX_ENTRY;
    return bytes > INT32_MAX ? -EINVAL : 0;
}

static int lay_out(struct video *v)
{
    uint32_t movi = 4, largest = 0;
    uint8_t *at;

    if (check_length(v) < 0)
        return -EINVAL;
    v->index = malloc(CHUNK + (size_t)v->n * INDEX_ENTRY);
    if (!v->index)
        return -ENOMEM;
    at = put_chunk(v->index, "idx1", v->n * INDEX_ENTRY);
    for (unsigned i = 0; i < v->n; i++) {
        uint32_t bytes = v->frame[i].bytes;

        at = put_tag(at, "00dc");
        at = put32(at, 0x10); /* each frame stands by itself */
        at = put32(at, movi);
        at = put32(at, bytes);
        v->frame[i].at = HEAD - 4 + (int64_t)movi;
        movi += CHUNK + padded(bytes);
        largest = bytes > largest ? bytes : largest;
    }
    v->index_at = HEAD - 4 + (int64_t)movi;
    v->bytes = v->index_at + CHUNK + (int64_t)v->n * INDEX_ENTRY;
    make_head(v, movi, largest);
    return 0;
}

/* ---- its bytes ---- */

static ssize_t from_memory(const uint8_t *part, int64_t part_bytes, int64_t offset, void *buf,
                           size_t n)
{
    if ((int64_t)n > part_bytes - offset)
        n = (size_t)(part_bytes - offset);
    memcpy(buf, part + offset, n);
    return (ssize_t)n;
}

static ssize_t from_frame(struct video *v, unsigned i, int64_t offset, void *buf, size_t n)
{
    const struct frame *f = &v->frame[i];
    uint8_t head[CHUNK] = {0};
    struct stat st;
    ssize_t got;

    if (offset < CHUNK) {
        (void)put_chunk(head, "00dc", f->bytes);
        return from_memory(head, CHUNK, offset, buf, n);
    }
    offset -= CHUNK;
    if (offset > f->bytes)
        return -EIO;
    if (offset == f->bytes) { /* the next chunk begins at an even place */
        *(uint8_t *)buf = 0;
        return 1;
    }
    if (v->fd < 0 || v->fd_of != i) {
        if (v->fd >= 0)
            (void)close(v->fd);
        v->fd = folder_preview(v->folder, v->dataset, f->path, &st);
        v->fd_of = i;
        if (v->fd < 0 || st.st_size != f->bytes)
            return -EIO; /* it was refreshed twice since: cut off, and asked for anew */
    }
    if ((int64_t)n > f->bytes - offset)
        n = (size_t)(f->bytes - offset);
    got = pread(v->fd, buf, n, offset);
    return got < 0 ? -errno : got;
}

static ssize_t video_read(void *ctx, int64_t offset, void *buf, size_t n)
{
    struct video *v = ctx;
    unsigned low = 0, high = v->n;

    if (offset < HEAD)
        return from_memory(v->head, HEAD, offset, buf, n);
    if (offset >= v->index_at)
        return from_memory(v->index, v->bytes - v->index_at, offset - v->index_at, buf, n);
    while (high - low > 1) { /* the last that begins no later */
        unsigned middle = low + (high - low) / 2;

        if (v->frame[middle].at <= offset)
            low = middle;
        else
            high = middle;
    }
    return from_frame(v, low, offset - v->frame[low].at, buf, n);
}

int preview_video(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    struct video *v = calloc(1, sizeof *v);
    char path[4096 + 80];
    int r = folder_dataset(request->folder, name, path, sizeof path);

    if (!v || r < 0) {
        free(v);
        return !v ? ttf_err_set(&request->err, -ENOMEM, NULL, "no memory")
                  : ttf_err_set(&request->err, r, name, "there is no dataset of this name");
    }
    v->folder = request->folder;
    v->fd = -1;
    memcpy(v->dataset, name, sizeof v->dataset);
    r = find_frames(v);
    if (r == 0)
        r = lay_out(v);
    if (r < 0) {
        video_free(v);
        return ttf_err_set(&request->err, r, name,
                           r == -ENOENT ? "there is no preview of it yet"
                                        : "its preview cannot be read: ask again");
    }
    ret->source = (struct answer_source){video_read, video_free, v};
    ret->bytes = v->bytes;
    ret->ranges = true;
    (void)snprintf(ret->etag, sizeof ret->etag, "%" PRIx64 "-%" PRIx64 "-%" PRIx64, v->inode,
                   v->made_ns, (uint64_t)v->bytes);
    (void)snprintf(ret->file_name, sizeof ret->file_name, "%s-preview.avi", name);
    return 0;
}
