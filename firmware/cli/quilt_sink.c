/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_sink.c: see quilt_sink.h. */
#include "quilt_sink.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "derive.h"

static const char *const NAMES[] = {"dataset", "raw", "null"};

struct quilt_sink {
    enum quilt_sink_kind kind;
    struct ttf_io *io;
    const char *path;
    const struct ttf_sequence *input;
    const struct ttf_quilt_config *config;
    bool finished;
    /* dataset */
    struct ttf_writer *writer;
    enum ttf_tiff_compression compression;
    enum ttf_icc icc;
    int64_t frame; /* commits count */
    /* raw */
    int file; /* -1: none */
    uint8_t *display, *table;
    char digest[65];
};

int quilt_sink_find(const char *name)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(NAMES); i++)
        if (strcmp(NAMES[i], name) == 0)
            return (int)i;
    return -ENOENT;
}

const char *quilt_sink_name(const struct quilt_sink *sink)
{
    return NAMES[sink->kind];
}

const char *quilt_sink_digest(const struct quilt_sink *sink)
{
    return sink->digest;
}

/* One output stream. Its pixels are the input's, so it means what the input's means. */
static void describe_stream(const struct quilt_sink *s, struct ttf_reader *parent,
                            const char *stream, struct ttf_manifest *m)
{
    struct ttf_stream *out = &m->streams[0];
    const struct ttf_stream *in = NULL;

    if (parent)
        in = stream ? ttf_manifest_stream(ttf_reader_manifest(parent), stream)
                    : ttf_manifest_primary(ttf_reader_manifest(parent));
    m->n_streams = 1;
    memset(out, 0, sizeof *out);
    (void)snprintf(out->id, sizeof out->id, "main");
    (void)snprintf(out->quantity, sizeof out->quantity, "%s", in ? in->quantity : "reflectance");
    (void)snprintf(out->unit, sizeof out->unit, "%s", in ? in->unit : "1");
    (void)snprintf(out->colour_space, sizeof out->colour_space, "%s",
                   in ? in->colour_space : "linear-srgb");
    out->width = s->config->width;
    out->height = s->config->height;
    out->samples = 3;
    out->format = TTF_SAMPLE_U16;
    out->encoding = s->input->encoding;
    out->mm_per_px = in ? in->mm_per_px : 0;
    out->primary = true;
}

/* Times of the output: those of the input's slots, from its first one on. */
static int begin_segment(struct quilt_sink *s, struct ttf_reader *parent, struct ttf_err *err)
{
    struct ttf_segment from, segment = {.plan = -1,
                                        .first_index = s->input->index[0],
                                        .origin_utc_ns = TTF_NS_UNKNOWN,
                                        .uncertainty_ns = TTF_NS_UNKNOWN,
                                        .interval_ns = TTF_NS_PER_S};

    (void)snprintf(segment.trust, sizeof segment.trust, "none");
    (void)snprintf(segment.zone, sizeof segment.zone, "UTC");
    if (parent && ttf_reader_segment(parent, 0, &from) == 0)
        segment.interval_ns = from.interval_ns;
    memcpy(segment.boot_id, ttf_writer_manifest(s->writer)->uuid, sizeof segment.boot_id);
    return ttf_writer_segment(s->writer, &segment, err);
}

static int create_dataset(struct cli *cli, struct quilt_sink *s, struct ttf_reader *parent)
{
    struct ttf_manifest *m = calloc(1, sizeof *m);
    int r = -ENOMEM;

    if (!m)
        return ttf_err_set(&cli->err, r, NULL, "no memory");
    if (parent) {
        r = derive_manifest(cli, parent, m);
    } else {
        r = ttf_manifest_init(m, &cli->err);
        (void)snprintf(m->source, sizeof m->source, "%.255s", cli->opt.args[0]);
    }
    if (r == 0) {
        m->derived_seed = (int64_t)s->config->seed;
        m->has_derived_seed = parent != NULL;
        describe_stream(s, parent, cli->opt.stream, m);
        /* A camera's own colours, or none, have no primaries that a profile could name. */
        s->icc =
            strcmp(m->streams[0].colour_space, "linear-srgb") == 0 ? TTF_ICC_LINEAR : TTF_ICC_NONE;
        r = ttf_writer_create(s->io, s->path, m, NULL, NULL, &s->writer, &cli->err);
    }
    if (r == 0)
        r = begin_segment(s, parent, &cli->err);
    free(m);
    return r;
}

static int create_raw(struct quilt_sink *s, struct ttf_err *err)
{
    s->table = malloc(65536);
    s->display = malloc((size_t)s->config->width * s->config->height * 3);
    if (!s->table || !s->display)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    ttf_display8_table(&s->input->encoding, s->table);
    s->file = s->io->ops->open(s->io, s->path, TTF_IO_CREATE_NEW);
    if (s->file < 0)
        return ttf_err_set(err, s->file, s->path, "cannot be written: %s",
                           strerrordesc_np(-s->file));
    return 0;
}

int quilt_sink_create(struct cli *cli, enum quilt_sink_kind kind, struct ttf_reader *parent,
                      const struct ttf_sequence *input, const struct ttf_quilt_config *config,
                      struct quilt_sink **ret)
{
    struct quilt_sink *s = calloc(1, sizeof *s);
    int r = 0;

    if (!s)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    s->kind = kind;
    s->io = cli->io;
    s->path = cli->opt.output;
    s->input = input;
    s->config = config;
    s->file = -1;
    if (cli->opt.compress && strcmp(cli->opt.compress, "deflate") == 0)
        s->compression = TTF_TIFF_DEFLATE;
    if (kind == QUILT_SINK_DATASET)
        r = create_dataset(cli, s, parent);
    else if (kind == QUILT_SINK_RAW)
        r = create_raw(s, &cli->err);
    if (r < 0) {
        quilt_sink_destroy(s);
        return r;
    }
    *ret = s;
    return 0;
}

struct produce {
    const struct quilt_sink *sink;
    const uint16_t *codes;
};

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct produce *p = ctx;
    const struct ttf_pixbuf pixels = {.width = p->sink->config->width,
                                      .height = p->sink->config->height,
                                      .samples = 3,
                                      .format = TTF_SAMPLE_U16,
                                      .stride = (size_t)p->sink->config->width * 6,
                                      .data = (void *)p->codes};
    const struct ttf_tiff_spec spec = {.compression = p->sink->compression,
                                       .icc = p->sink->icc,
                                       .times = {.start_utc_ns = TTF_NS_UNKNOWN},
                                       .software = "ttfbox " TTFBOX_VERSION};

    return ttf_tiff_write(io, file, &pixels, &spec, err);
}

static int commit(struct quilt_sink *s, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    struct produce p = {s, codes};
    struct ttf_slot_record record;
    struct ttf_image *image;
    int r;

    ttf_slot_record_init(&record);
    r = ttf_slot_record_images(&record, 1);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory");
    image = &record.images[0];
    record.index = s->input->index[t];
    record.due_ns = s->input->time_ns[t];
    record.middle_ns = TTF_NS_UNKNOWN;
    record.result = TTF_RESULT_CAPTURED;
    (void)snprintf(image->stream, sizeof image->stream, "main");
    image->n_averaged = 1;
    r = ttf_writer_file(s->writer, "developed", "main", record.index, -1, "tif", produce, &p,
                        &image->files[0], err);
    if (r == 0) {
        image->n_files = 1;
        r = ttf_writer_commit(s->writer, &record, err);
    }
    ttf_slot_record_free(&record);
    return r;
}

static int take(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    struct quilt_sink *s = ctx;
    size_t n = (size_t)s->config->width * s->config->height * 3;
    int r;

    if (s->kind == QUILT_SINK_NULL)
        return 0;
    if (s->kind == QUILT_SINK_DATASET)
        return commit(s, t, codes, err);
    for (size_t i = 0; i < n; i++)
        s->display[i] = s->table[codes[i]];
    r = ttf_io_append_all(s->io, s->file, s->display, n);
    return r < 0 ? ttf_err_set(err, r, s->path, "cannot be written: %s", strerrordesc_np(-r)) : 0;
}

struct ttf_quilt_sink quilt_sink_of(struct quilt_sink *sink)
{
    return (struct ttf_quilt_sink){.frame = take, .ctx = sink};
}

/* At the dataset's root, outside the seal: it holds times. */
static int write_report(struct quilt_sink *s, const struct ttf_quilt_report *report,
                        struct ttf_err *err)
{
    char path[PATH_MAX];
    struct ttf_json json;
    const char *text;
    size_t bytes;
    int r;

    ttf_json_init(&json, true);
    ttf_quilt_report_json(report, &json);
    r = ttf_json_finish(&json, &text, &bytes);
    if (r == 0) {
        (void)snprintf(path, sizeof path, "%s/report.json", s->path);
        r = ttf_io_write_file(s->io, path, text, bytes, err);
    } else {
        ttf_err_set(err, r, "report.json", "cannot be made");
    }
    ttf_json_free(&json);
    return r;
}

int quilt_sink_finish(struct quilt_sink *s, const struct ttf_quilt_report *report,
                      struct ttf_err *err)
{
    int r = 0;

    if (s->kind == QUILT_SINK_DATASET) {
        r = ttf_writer_seal(s->writer, "count", s->digest, err);
        if (r == 0)
            r = write_report(s, report, err);
    } else if (s->kind == QUILT_SINK_RAW) {
        r = s->io->ops->sync(s->io, s->file, false);
        if (r < 0)
            ttf_err_set(err, r, s->path, "cannot be synced: %s", strerrordesc_np(-r));
    }
    s->finished = r == 0;
    return r;
}

void quilt_sink_destroy(struct quilt_sink *s)
{
    if (!s)
        return;
    if (s->writer) {
        if (s->finished) {
            ttf_writer_close(s->writer);
        } else {
            ttf_writer_abandon(s->writer);
            derive_discard(s->io, s->path);
        }
    }
    if (s->file >= 0) {
        (void)s->io->ops->close(s->io, s->file);
        if (!s->finished)
            (void)s->io->ops->unlink(s->io, s->path);
    }
    free(s->display);
    free(s->table);
    free(s);
}

/* ---- the first n frames ---- */

struct first_frames {
    struct ttf_sequence base;
    struct ttf_sequence *whole;
};

static int first_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                      uint16_t *dst, struct ttf_err *err)
{
    return ttf_sequence_read_rows(((struct first_frames *)sequence)->whole, t, y0, rows, dst, err);
}

static void first_destroy(struct ttf_sequence *sequence)
{
    free(sequence);
}

int quilt_first_frames(struct ttf_sequence *whole, uint32_t n, struct ttf_sequence **ret,
                       struct ttf_err *err)
{
    static const struct ttf_sequence_ops OPS = {.read_rows = first_rows, .destroy = first_destroy};
    struct first_frames *f;

    *ret = whole;
    if (n == 0 || n >= whole->n)
        return 0;
    f = malloc(sizeof *f);
    if (!f)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    f->base = *whole;
    f->base.ops = &OPS;
    f->base.n = n;
    f->whole = whole;
    *ret = &f->base;
    return 0;
}
