/* SPDX-License-Identifier: Apache-2.0 */
/* import_video.c: frames of anything that ffmpeg reads, through a pipe. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image_file_codecs.h"
#include "import_source.h"
#include "io_path.h"
#include "video_child.h"

struct video_source {
    struct import_source base; /* first: downcast by address */
    struct video_child child;
    const char *path;
    int64_t frames; /* so far */
    char name[320];
};

struct video_facts {
    int64_t frame_ns; /* 0: not known */
    bool deep;        /* more than 8 bits a sample */
};

static void read_fact(char *line, struct video_facts *facts)
{
    char *value = strchr(line, '=');
    long long num = 0, den = 0;

    if (!value)
        return;
    *value++ = 0;
    if (strcmp(line, "pix_fmt") == 0) {
        static const char *const deep[] = {"10", "12", "14", "16", "48", "64", "p9", "y9", "f32"};

        for (size_t i = 0; i < sizeof(deep) / sizeof(deep[0]); i++)
            facts->deep |= strstr(value, deep[i]) != NULL;
        /* Where the digits are no depth. */
        facts->deep &= strncmp(value, "yuv410p", 7) != 0 && strncmp(value, "nv", 2) != 0;
    } else if (strcmp(line, "avg_frame_rate") == 0 || strcmp(line, "r_frame_rate") == 0) {
        char *end;

        num = strtoll(value, &end, 10);
        if (*end == '/')
            den = strtoll(end + 1, NULL, 10);
        /*
         * The average comes last and is what a film's length says: of uneven frames a fraction of large numbers, where
         * the other rate is that of the film's clock. A million frames a second are none.
         */
        if (num > 0 && den > 0 && den <= INT32_MAX && num / den < 1000000)
            facts->frame_ns = den * TTF_NS_PER_S / num;
    }
}

static int probe(const struct ttf_import_config *config, const char *url, struct video_facts *ret,
                 struct ttf_err *err)
{
    const char *const argv[] = {config->ffprobe ? config->ffprobe : "ffprobe",
                                "-v",
                                "error",
                                "-protocol_whitelist",
                                "file,pipe",
                                "-select_streams",
                                "v:0",
                                "-show_entries",
                                "stream=pix_fmt,r_frame_rate,avg_frame_rate",
                                "-of",
                                "default=noprint_wrappers=1",
                                "-i",
                                url,
                                NULL};
    struct video_child child;
    char text[2048], *save = NULL;
    ssize_t n;
    int code = video_child_start(&child, argv, VIDEO_READ, err);

    if (code)
        return code;
    n = video_child_read(&child, text, sizeof(text) - 1, err);
    code = n < 0 ? (int)n : video_child_finish(&child, err);
    video_child_stop(&child);
    if (code)
        return code;
    text[n] = 0;
    *ret = (struct video_facts){0};
    for (char *line = strtok_r(text, "\n", &save); line; line = strtok_r(NULL, "\n", &save))
        read_fact(line, ret);
    return n > 0 ? 0 : -ENODATA;
}

/* A number of the PPM header and the one white space after it. -1: none. */
static int64_t header_number(struct video_source *source, struct ttf_err *err)
{
    int64_t value = 0;
    char c = 0;

    for (int digits = 0; digits < 8; digits++) {
        if (video_child_read(&source->child, &c, 1, err) != 1)
            return -1;
        if (c < '0' || c > '9')
            return digits > 0 && (c == ' ' || c == '\n') ? value : -1;
        value = value * 10 + (c - '0');
    }
    return -1;
}

/* PPM's 16-bit samples are big-endian. */
static void to_machine_order(struct ttf_pixbuf *pixels)
{
    size_t n = (size_t)pixels->width * pixels->height * 3;
    uint16_t *code = pixels->data;

    for (size_t i = 0; i < n; i++) {
        const uint8_t *bytes = (const uint8_t *)&code[i];

        code[i] = (uint16_t)(bytes[0] << 8 | bytes[1]);
    }
}

static int read_frame(struct video_source *source, struct ttf_pixbuf *ret,
                      struct ttf_image_info *info, struct ttf_err *err)
{
    int64_t width = header_number(source, err), height = header_number(source, err),
            top = header_number(source, err);
    struct ttf_pixbuf pixels;
    size_t bytes;
    int code;

    if (width <= 0 || height <= 0 || (top != 255 && top != 65535))
        return ttf_err_set(err, -EPROTO, source->path, "ffmpeg's frames are not understood");
    code = image_check_size((uint64_t)width, (uint64_t)height, source->path, err);
    if (code)
        return code;
    *info = (struct ttf_image_info){.width = (uint32_t)width,
                                    .height = (uint32_t)height,
                                    .samples = 3,
                                    .format = top == 255 ? TTF_SAMPLE_U8 : TTF_SAMPLE_U16,
                                    .bits = top == 255 ? 8 : 16,
                                    .pages = 1,
                                    .orientation = 1,
                                    .transfer = TTF_TRANSFER_SRGB,
                                    .taken_utc_ns = TTF_NS_UNKNOWN};
    code = ttf_pixbuf_alloc(&pixels, info->width, info->height, 3, info->format);
    if (code)
        return ttf_err_set(err, code, source->path, "no memory for a frame");
    bytes = pixels.stride * pixels.height;
    if (video_child_read(&source->child, pixels.data, bytes, err) != (ssize_t)bytes) {
        ttf_pixbuf_free(&pixels);
        return ttf_err_set(err, -EPROTO, source->path, "ffmpeg stopped in the middle of a frame");
    }
    if (top == 65535)
        to_machine_order(&pixels);
    *ret = pixels;
    return 0;
}

static int video_next(struct import_source *base, struct ttf_pixbuf *ret,
                      struct ttf_image_info *ret_info, const char **ret_name, struct ttf_err *err)
{
    struct video_source *source = (struct video_source *)base;
    char magic[3];
    ssize_t n = video_child_read(&source->child, magic, sizeof(magic), err);
    int code;

    if (n < 0)
        return (int)n;
    if (n == 0) {
        code = video_child_finish(&source->child, err);
        if (code)
            return ttf_err_prefix(err, "%s", source->path), code;
        return 0;
    }
    snprintf(source->name, sizeof(source->name), "%s (frame %lld)", source->path,
             (long long)source->frames++);
    *ret_name = source->name;
    if (n != 3 || memcmp(magic, "P6\n", 3) != 0)
        return ttf_err_set(err, -EPROTO, source->path, "ffmpeg's frames are not understood");
    code = read_frame(source, ret, ret_info, err);
    return code ? code : 1;
}

static void video_destroy(struct import_source *base)
{
    struct video_source *source = (struct video_source *)base;

    video_child_stop(&source->child);
    free(source);
}

static const struct import_source_ops video_ops = {
    .next = video_next,
    .destroy = video_destroy,
};

/* Frames as they are, none doubled or dropped; only files, whatever a playlist may ask for. */
static int start(struct video_source *source, const struct ttf_import_config *config,
                 const char *url, bool deep, struct ttf_err *err)
{
    const char *const argv[] = {config->ffmpeg ? config->ffmpeg : "ffmpeg",
                                "-nostdin",
                                "-v",
                                "error",
                                "-xerror",
                                "-protocol_whitelist",
                                "file,pipe",
                                "-i",
                                url,
                                "-map",
                                "0:v:0",
                                "-vsync",
                                "passthrough",
                                "-sws_flags",
                                "bicubic+accurate_rnd+full_chroma_int+bitexact",
                                "-pix_fmt",
                                deep ? "rgb48be" : "rgb24",
                                "-c:v",
                                "ppm",
                                "-f",
                                "image2pipe",
                                "pipe:1",
                                NULL};

    return video_child_start(&source->child, argv, VIDEO_READ, err);
}

int import_video(const struct ttf_import_config *config, struct import_source **ret,
                 struct ttf_err *err)
{
    const char *path = config->inputs[0];
    struct video_source *source = calloc(1, sizeof(*source));
    char *url = ttf_path_format("file:%s", path);
    struct video_facts facts = {0};
    int code;

    if (!source || !url) {
        code = ttf_err_set(err, -ENOMEM, path, "no memory to read a video");
        goto out;
    }
    code = probe(config, url, &facts, err);
    if (code == -EPROTO || code == -ENODATA) {
        struct ttf_err said = {0};

        if (err && code == -EPROTO)
            said = *err;
        code = ttf_err_set(err, -ENOTSUP, path, "neither a picture nor a video (%s)",
                           said.what[0] ? said.what : "no moving picture in it");
    }
    if (!code)
        code = start(source, config, url, facts.deep, err);
    if (code)
        goto out;
    source->base.ops = &video_ops;
    source->base.frame_ns = facts.frame_ns;
    source->path = path;
    *ret = &source->base;
    source = NULL;
out:
    free(source);
    free(url);
    return code;
}
