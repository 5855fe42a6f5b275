/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "preview.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"

#define SIDE    512
#define QUALITY 80
#define SAID    ((size_t)1 << 20)

struct synthesis {
    uint32_t width, height, n;
    int64_t shrunk_by, frame_step;
};

static int64_t number(const json_t *object, const char *key)
{
    return json_integer_value(json_object_get(object, key));
}

/* What the synthesis said of itself. */
static int read_said(struct ttf_io *io, const char *path, struct synthesis *ret,
                     struct ttf_err *err)
{
    const json_t *report, *size, *preview;
    json_t *json = NULL;
    char *text = NULL;
    size_t n = 0;
    int r = ttf_io_slurp(io, path, SAID, &text, &n, err);

    if (r == 0)
        r = ttf_json_parse(text, n, &json, NULL);
    report = json_object_get(json, "report");
    size = json_object_get(json_object_get(report, "parameters"), "size");
    preview = json_object_get(json, "preview");
    ret->width = (uint32_t)json_integer_value(json_array_get(size, 0));
    ret->height = (uint32_t)json_integer_value(json_array_get(size, 1));
    ret->n = (uint32_t)number(report, "output_frames");
    ret->shrunk_by = number(preview, "shrunk_by");
    ret->frame_step = number(preview, "frame_step");
    json_decref(json);
    free(text);
    if (r == 0 && (ret->width == 0 || ret->height == 0 || ret->n == 0 || ret->frame_step < 1 ||
                   ret->width > 65535 || ret->height > 65535))
        r = -EPROTO;
    return r < 0 ? ttf_err_set(err, r, path, "the synthesis did not say what it made") : 0;
}

/* The slots of the dataset's images, in their order: frame t of the synthesis shows that of t * step. */
static int find_slots(struct ttf_io *io, const struct preview_subject *subject,
                      const struct synthesis *s, struct preview_made *ret, struct ttf_err *err)
{
    const struct ttf_sequence_choice alone = {.threads = 1};
    struct ttf_reader *reader = NULL;
    struct ttf_sequence *input = NULL;
    int r = ttf_reader_open(io, subject->path, &reader, err);

    if (r == 0)
        r = ttf_sequence_of_dataset(reader, &alone, &input, err);
    for (unsigned k = 0; k < ret->n_frames && r == 0; k++) {
        uint64_t t = ret->n_frames > 1 ? (uint64_t)k * (s->n - 1) / (ret->n_frames - 1) : 0;
        uint64_t from = t * (uint64_t)s->frame_step;

        ret->slot[k] = input->index[from < input->n ? from : input->n - 1];
    }
    ttf_sequence_destroy(input);
    ttf_reader_close(reader);
    return r;
}

static int write_jpeg(struct ttf_io *io, const char *path, const struct ttf_pixbuf *small,
                      struct ttf_err *err)
{
    void *jpeg = NULL;
    size_t n = 0;
    int r = ttf_jpeg_encode(small, QUALITY, &jpeg, &n, err);

    if (r == 0)
        r = ttf_io_write_file(io, path, jpeg, n, err);
    free(jpeg);
    return r;
}

static int make_frames(struct ttf_io *io, const char *folder, int fd, const struct synthesis *s,
                       const struct preview_made *made, struct ttf_err *err)
{
    struct ttf_pixbuf large = {0}, small = {0};
    size_t frame = (size_t)s->width * s->height * 3;
    char path[4400];
    int r = ttf_pixbuf_alloc(&large, s->width, s->height, 3, TTF_SAMPLE_U8);

    if (r == 0)
        r = ttf_pixbuf_alloc(&small, made->width, made->height, 3, TTF_SAMPLE_U8);
    if (r < 0)
        ttf_err_set(err, r, NULL, "no memory for a frame");
    for (unsigned k = 0; k < made->n_frames && r == 0; k++) {
        uint64_t t = made->n_frames > 1 ? (uint64_t)k * (s->n - 1) / (made->n_frames - 1) : 0;

        if (pread(fd, large.data, frame, (off_t)(t * frame)) != (ssize_t)frame)
            r = ttf_err_set(err, -EIO, folder, "the synthesis is shorter than it says");
        if (r == 0)
            r = ttf_pixbuf_resample(&large, &small);
        (void)snprintf(path, sizeof path, "%s/%03u.jpg", folder, k);
        if (r == 0)
            r = write_jpeg(io, path, &small, err);
    }
    ttf_pixbuf_free(&small);
    ttf_pixbuf_free(&large);
    return r;
}

int preview_strip(struct ttf_io *io, const struct preview_subject *subject,
                  const struct preview_cache *cache, struct preview_made *ret, struct ttf_err *err)
{
    char folder[4300], said[4400], frames[4400];
    struct synthesis s = {0};
    uint32_t longer, divisor;
    int fd, r;

    (void)snprintf(folder, sizeof folder, "%s/making", cache->path);
    (void)snprintf(said, sizeof said, "%s/said.json", folder);
    (void)snprintf(frames, sizeof frames, "%s/frames.rgb", folder);
    r = read_said(io, said, &s, err);
    if (r < 0)
        return r;
    longer = s.width > s.height ? s.width : s.height;
    divisor = (longer + SIDE - 1) / SIDE;
    *ret = (struct preview_made){
        .width = s.width < divisor ? 1 : s.width / divisor,
        .height = s.height < divisor ? 1 : s.height / divisor,
        .shrunk_by = s.shrunk_by,
        .frame_step = s.frame_step,
        .n_frames = s.n < PREVIEW_FRAMES ? s.n : PREVIEW_FRAMES,
    };
    r = find_slots(io, subject, &s, ret, err);
    fd = r == 0 ? open(frames, O_RDONLY | O_CLOEXEC) : -1;
    if (r == 0 && fd < 0)
        r = ttf_err_set(err, -errno, frames, "there is no synthesis");
    if (r == 0)
        r = make_frames(io, folder, fd, &s, ret, err);
    if (fd >= 0)
        (void)close(fd);
    (void)unlink(frames);
    (void)unlink(said);
    return r;
}
