/* SPDX-License-Identifier: Apache-2.0 */
/* jpeg.c: JPEG in and out, by libjpeg-turbo. */
#include <errno.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>

#include <jerror.h>

#include "image_file_codecs.h"

/* A forged progressive file can ask for thousands of passes over a huge picture. */
#define SCANS_MAX   200
#define MEMORY_MAX  (1L << 30) /* bytes of working memory of the library */
#define PIECE_BYTES 65536

/* The library calls back on errors and expects not to get control again: out by longjmp. */
struct jpeg_trap {
    struct jpeg_error_mgr base; /* first */
    struct jpeg_progress_mgr progress;
    jmp_buf out;
    bool corrupt; /* a warning that means lost pixels */
    char message[JMSG_LENGTH_MAX];
};

static void trap_error(j_common_ptr info)
{
    struct jpeg_trap *trap = (struct jpeg_trap *)info->err;

    info->err->format_message(info, trap->message);
    longjmp(trap->out, 1); /* NOLINT(cert-err52-cpp): the library's own protocol */
}

/* What a call that ended in trap_error returns: code, unless the library had no memory. */
static int trap_code(const struct jpeg_trap *trap, int code)
{
    return trap->base.msg_code == JERR_OUT_OF_MEMORY ? -ENOMEM : code;
}

/* Level -1 is a warning. Those that mean that pixels were made up are errors for us. */
static void trap_message(j_common_ptr info, int level)
{
    struct jpeg_trap *trap = (struct jpeg_trap *)info->err;
    int code = info->err->msg_code;

    if (level >= 0 || trap->corrupt)
        return;
    if (code == JWRN_EXTRANEOUS_DATA || code == JWRN_ADOBE_XFORM || code == JWRN_JFIF_MAJOR ||
        code == JWRN_BOGUS_ICC || code == JWRN_NOT_SEQUENTIAL)
        return;
    trap->corrupt = true;
    info->err->format_message(info, trap->message);
}

static void trap_output(j_common_ptr info)
{
}

static void trap_progress(j_common_ptr info)
{
    struct jpeg_trap *trap = (struct jpeg_trap *)info->err;

    if (info->is_decompressor && ((j_decompress_ptr)info)->input_scan_number > SCANS_MAX) {
        snprintf(trap->message, sizeof(trap->message), "more than %d scans", SCANS_MAX);
        longjmp(trap->out, 1); /* NOLINT(cert-err52-cpp) */
    }
}

static struct jpeg_error_mgr *trap_init(struct jpeg_trap *trap)
{
    jpeg_std_error(&trap->base);
    trap->base.error_exit = trap_error;
    trap->base.emit_message = trap_message;
    trap->base.output_message = trap_output;
    trap->progress.progress_monitor = trap_progress;
    return &trap->base;
}

static void read_markers(struct jpeg_decompress_struct *jpeg, struct ttf_image_info *info)
{
    JOCTET *profile = NULL;
    unsigned bytes = 0;

    for (jpeg_saved_marker_ptr m = jpeg->marker_list; m; m = m->next) {
        if (m->marker == JPEG_APP0 + 1 && m->data_length > 6 && memcmp(m->data, "Exif\0", 6) == 0)
            exif_read(m->data + 6, m->data_length - 6, info);
    }
    if (jpeg_read_icc_profile(jpeg, &profile, &bytes)) {
        info->foreign_profile = !image_profile_is_srgb(profile, bytes, info->samples == 1);
        free(profile);
    }
}

/* Everything between create and destroy; leaves by longjmp on errors of the library. */
static int decode(struct jpeg_decompress_struct *jpeg, const uint8_t *data, size_t n,
                  const char *path, struct ttf_pixbuf *pixels, bool want_pixels,
                  struct ttf_image_info *info, struct ttf_err *err)
{
    int code;

    jpeg->mem->max_memory_to_use = MEMORY_MAX;
    jpeg_mem_src(jpeg, data, n);
    jpeg_save_markers(jpeg, JPEG_APP0 + 1, 0xffff);
    jpeg_save_markers(jpeg, JPEG_APP0 + 2, 0xffff);
    jpeg_read_header(jpeg, TRUE);
    code = image_check_size(jpeg->image_width, jpeg->image_height, path, err);
    if (code)
        return code;
    if (jpeg->num_components != 1 && jpeg->num_components != 3) {
        code = ttf_err_set(err, -ENOTSUP, path, "a JPEG of %d components (CMYK?) is not read",
                           jpeg->num_components);
        ttf_err_hint(err, "save it as RGB");
        return code;
    }
    jpeg->out_color_space = jpeg->num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg->dct_method = JDCT_ISLOW;
    info->width = jpeg->image_width;
    info->height = jpeg->image_height;
    info->samples = (uint32_t)jpeg->num_components;
    info->format = TTF_SAMPLE_U8;
    info->bits = 8;
    info->transfer = TTF_TRANSFER_SRGB;
    read_markers(jpeg, info);
    if (!want_pixels)
        return 0;
    code = ttf_pixbuf_alloc(pixels, info->width, info->height, info->samples, TTF_SAMPLE_U8);
    if (code)
        return ttf_err_set(err, code, path, "no memory for %u x %u pixels", info->width,
                           info->height);
    jpeg_start_decompress(jpeg);
    while (jpeg->output_scanline < jpeg->output_height) {
        JSAMPROW row = ttf_pixbuf_row(pixels, jpeg->output_scanline);

        jpeg_read_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_decompress(jpeg);
    return 0;
}

/* One picture being read: outside of the function that calls setjmp, so that nothing of it is lost by longjmp. */
struct jpeg_reading {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_trap trap;
    struct ttf_pixbuf pixels;
};

static int guarded_decode(struct jpeg_reading *reading, const uint8_t *data, size_t n,
                          const char *path, bool want_pixels, struct ttf_image_info *info,
                          struct ttf_err *err)
{
    if (setjmp(reading->trap.out)) /* NOLINT(cert-err52-cpp) */
        return ttf_err_set(err, trap_code(&reading->trap, -TTF_EDAMAGED), path,
                           "this JPEG cannot be read: %s", reading->trap.message);
    jpeg_create_decompress(&reading->jpeg);
    reading->jpeg.progress = &reading->trap.progress;
    return decode(&reading->jpeg, data, n, path, &reading->pixels, want_pixels, info, err);
}

int jpeg_decode(const uint8_t *data, size_t n, const char *path, struct ttf_pixbuf *ret,
                struct ttf_image_info *info, struct ttf_err *err)
{
    struct jpeg_reading *reading = calloc(1, sizeof(*reading));
    int code;

    if (!reading)
        return ttf_err_set(err, -ENOMEM, path, "no memory to read a JPEG");
    reading->jpeg.err = trap_init(&reading->trap);
    code = guarded_decode(reading, data, n, path, ret != NULL, info, err);
    jpeg_destroy_decompress(&reading->jpeg);
    if (!code && ret && reading->trap.corrupt)
        code = ttf_err_set(err, -TTF_EDAMAGED, path, "this JPEG is damaged: %s",
                           reading->trap.message);
    if (code)
        ttf_pixbuf_free(&reading->pixels);
    else if (ret)
        *ret = reading->pixels;
    free(reading);
    return code;
}

/* Where compressed bytes go: a piece at a time to the handle, or into memory. */
struct jpeg_target {
    struct jpeg_destination_mgr base; /* first */
    struct ttf_io *io;                /* NULL: into memory */
    int file;
    uint8_t *bytes; /* by malloc */
    int64_t offset;
    int error;
    uint8_t piece[PIECE_BYTES];
};

static void target_begin(j_compress_ptr jpeg)
{
    struct jpeg_target *target = (struct jpeg_target *)jpeg->dest;

    target->base.next_output_byte = target->piece;
    target->base.free_in_buffer = sizeof(target->piece);
}

static int target_keep(struct jpeg_target *target, size_t n)
{
    uint8_t *grown = realloc(target->bytes, (size_t)target->offset + n + 1);

    if (!grown)
        return -ENOMEM;
    memcpy(grown + target->offset, target->piece, n);
    target->bytes = grown;
    return 0;
}

static void target_put(j_compress_ptr jpeg, size_t n)
{
    struct jpeg_target *target = (struct jpeg_target *)jpeg->dest;

    target->error =
        target->io ? ttf_io_pwrite_all(target->io, target->file, target->piece, n, target->offset)
                   : target_keep(target, n);
    if (target->error)
        ERREXIT(jpeg, JERR_FILE_WRITE);
    target->offset += (int64_t)n;
    target_begin(jpeg);
}

static boolean target_full(j_compress_ptr jpeg)
{
    target_put(jpeg, PIECE_BYTES);
    return TRUE;
}

static void target_end(j_compress_ptr jpeg)
{
    target_put(jpeg, PIECE_BYTES - jpeg->dest->free_in_buffer);
}

static void encode(struct jpeg_compress_struct *jpeg, const struct ttf_pixbuf *pixels, int quality)
{
    jpeg->image_width = pixels->width;
    jpeg->image_height = pixels->height;
    jpeg->input_components = (int)pixels->samples;
    jpeg->in_color_space = pixels->samples == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(jpeg);
    jpeg_set_quality(jpeg, quality, TRUE);
    jpeg->dct_method = JDCT_ISLOW;
    if (quality >= 90) {
        jpeg->comp_info[0].h_samp_factor = 1;
        jpeg->comp_info[0].v_samp_factor = 1;
    }
    jpeg_start_compress(jpeg, TRUE);
    while (jpeg->next_scanline < jpeg->image_height) {
        JSAMPROW row = ttf_pixbuf_row(pixels, jpeg->next_scanline);

        jpeg_write_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_compress(jpeg);
}

struct jpeg_writing {
    struct jpeg_compress_struct jpeg;
    struct jpeg_trap trap;
    struct jpeg_target target;
};

static int guarded_encode(struct jpeg_writing *writing, const struct ttf_pixbuf *pixels,
                          int quality)
{
    if (setjmp(writing->trap.out)) /* NOLINT(cert-err52-cpp) */
        return writing->target.error ? writing->target.error : trap_code(&writing->trap, -EINVAL);
    jpeg_create_compress(&writing->jpeg);
    writing->jpeg.dest = &writing->target.base;
    encode(&writing->jpeg, pixels, quality);
    return 0;
}

static int check(const struct ttf_pixbuf *pixels, int quality, struct ttf_err *err)
{
    if (pixels->format != TTF_SAMPLE_U8 || (pixels->samples != 1 && pixels->samples != 3) ||
        quality < 1 || quality > 100)
        return ttf_err_set(err, -EINVAL, NULL, "a JPEG holds 8-bit grey or RGB, quality 1 to 100");
    if (pixels->width > JPEG_MAX_DIMENSION || pixels->height > JPEG_MAX_DIMENSION)
        return ttf_err_set(err, -EFBIG, NULL, "a JPEG's sides are at most %ld pixels",
                           JPEG_MAX_DIMENSION);
    return 0;
}

static int write_out(struct jpeg_writing *writing, const struct ttf_pixbuf *pixels, int quality,
                     struct ttf_err *err)
{
    int code;

    writing->target.base.init_destination = target_begin;
    writing->target.base.empty_output_buffer = target_full;
    writing->target.base.term_destination = target_end;
    writing->jpeg.err = trap_init(&writing->trap);
    code = guarded_encode(writing, pixels, quality);
    jpeg_destroy_compress(&writing->jpeg);
    if (code)
        ttf_err_set(err, code, NULL, "writing a JPEG failed: %s", writing->trap.message);
    return code;
}

int ttf_jpeg_write(struct ttf_io *io, int file, const struct ttf_pixbuf *pixels, int quality,
                   struct ttf_err *err)
{
    struct jpeg_writing *writing;
    int code = check(pixels, quality, err);

    if (code)
        return code;
    writing = calloc(1, sizeof(*writing));
    if (!writing)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write a JPEG");
    writing->target.io = io;
    writing->target.file = file;
    code = write_out(writing, pixels, quality, err);
    free(writing);
    return code;
}

int ttf_jpeg_encode(const struct ttf_pixbuf *pixels, int quality, void **ret, size_t *ret_bytes,
                    struct ttf_err *err)
{
    struct jpeg_writing *writing;
    int code = check(pixels, quality, err);

    if (code)
        return code;
    writing = calloc(1, sizeof(*writing));
    if (!writing)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write a JPEG");
    code = write_out(writing, pixels, quality, err);
    if (code) {
        free(writing->target.bytes);
    } else {
        *ret = writing->target.bytes;
        *ret_bytes = (size_t)writing->target.offset;
    }
    free(writing);
    return code;
}
