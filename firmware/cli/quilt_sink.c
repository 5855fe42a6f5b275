/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_sink.c: see quilt_sink.h. */
#include "quilt_sink.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "derive.h"

static const char *const NAMES[] = {"dataset", "raw", "null"};

struct quilt_sink {
    struct quilt_sink_spec spec;
    struct ttf_io *io;
    const char *path;
    bool finished;
    uint16_t *edited; /* a frame that may be written to; NULL: nothing is edited */
    /* dataset */
    struct ttf_writer *writer;
    enum ttf_tiff_compression compression;
    enum ttf_icc icc;
    int64_t interval_ns, index_step; /* from one of the input's frames to the next */
    /* raw */
    char *beside; /* the name that the file has until it is whole */
    int file;     /* -1: none */
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
    return NAMES[sink->spec.kind];
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
    (void)snprintf(out->quantity, sizeof out->quantity, "%s", in ? in->quantity : "radiance");
    (void)snprintf(out->unit, sizeof out->unit, "%s", in ? in->unit : "1");
    (void)snprintf(out->colour_space, sizeof out->colour_space, "%s",
                   in ? in->colour_space : "linear-srgb");
    out->width = s->spec.config->width;
    out->height = s->spec.config->height;
    out->samples = 3;
    out->format = TTF_SAMPLE_U16;
    out->encoding = s->spec.input->encoding;
    out->mm_per_px = in ? in->mm_per_px * s->spec.shrink : 0;
    out->primary = true;
}

/* Times of the output: those of the input's slots, from its first one on. */
static int begin_segment(struct quilt_sink *s, struct ttf_reader *parent, struct ttf_err *err)
{
    struct ttf_segment from, segment = {.plan = -1,
                                        .first_index = s->spec.input->index[0],
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

static int create_dataset(struct cli *cli, struct quilt_sink *s)
{
    struct ttf_reader *parent = s->spec.parent;
    struct ttf_manifest *m = calloc(1, sizeof *m);
    int r = -ENOMEM;

    if (!m)
        return ttf_err_set(&cli->err, r, NULL, "no memory");
    if (parent) {
        r = derive_manifest(cli, parent, m);
    } else {
        r = ttf_manifest_init(m, &cli->err);
        (void)snprintf(m->source, sizeof m->source, "%.255s", s->spec.source);
    }
    if (r == 0) {
        m->derived_seed = (int64_t)s->spec.config->seed;
        /* nothing was picked where a map is replayed, and it does not say by which seed it was found */
        m->has_derived_seed = parent != NULL && !s->spec.config->replay;
        describe_stream(s, parent, cli->opt.stream, m);
        /* A camera's own colours, or none, have no primaries that a profile could name. */
        s->icc =
            strcmp(m->streams[0].colour_space, "linear-srgb") == 0 ? TTF_ICC_LINEAR : TTF_ICC_NONE;
        r = derive_create(cli, s->path, m, NULL, NULL, &s->writer);
    }
    if (r == 0)
        r = begin_segment(s, parent, &cli->err);
    free(m);
    return r;
}

/* Hidden, in the same folder, of this process. NULL: no memory. */
static char *name_beside(const char *path)
{
    const char *slash = strrchr(path, '/');
    size_t folder = slash ? (size_t)(slash + 1 - path) : 0;
    char *name = NULL;

    return asprintf(&name, "%.*s.%.40s.part-%ld", (int)folder, path, path + folder,
                    (long)getpid()) < 0
               ? NULL
               : name;
}

static int create_raw(struct quilt_sink *s, struct ttf_err *err)
{
    struct ttf_io_stat there;

    s->table = malloc(65536);
    s->display = malloc((size_t)s->spec.config->width * s->spec.config->height * 3);
    if (!s->table || !s->display)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    ttf_display8_table(&s->spec.input->encoding, s->table);
    if (s->io->ops->stat(s->io, s->path, &there) == 0) /* an empty folder passes for an output */
        return ttf_err_set(err, -EEXIST, s->path, "is there already, and no file");
    s->beside = name_beside(s->path);
    if (!s->beside)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)s->io->ops->unlink(s->io, s->beside); /* of a process of the same number, long ago */
    s->file = s->io->ops->open(s->io, s->beside, TTF_IO_CREATE_NEW);
    if (s->file < 0)
        return ttf_err_set(err, s->file, s->path, "cannot be written: %s",
                           strerrordesc_np(-s->file));
    return 0;
}

/* What goes on beyond the input's last frame: a slowed output is longer than its input. */
static void measure_steps(struct quilt_sink *s)
{
    const struct ttf_sequence *input = s->spec.input;

    s->index_step = 1;
    s->interval_ns = TTF_NS_PER_S;
    for (uint32_t t = 1; t < input->n; t++) {
        int64_t step = input->index[t] - input->index[t - 1];

        /* the least: slots may lack an image */
        if (t > 1 && step >= s->index_step)
            continue;
        s->index_step = step;
        s->interval_ns = input->time_ns[t] - input->time_ns[t - 1];
    }
}

int quilt_sink_create(struct cli *cli, const struct quilt_sink_spec *spec, struct quilt_sink **ret)
{
    struct quilt_sink *s = calloc(1, sizeof *s);
    int r = 0;

    if (!s)
        return ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    s->spec = *spec;
    s->io = cli->io;
    s->path = cli->opt.output;
    s->file = -1;
    measure_steps(s);
    if (cli->opt.compress && strcmp(cli->opt.compress, "deflate") == 0)
        s->compression = TTF_TIFF_DEFLATE;
    if (spec->edit) {
        s->edited = malloc((size_t)spec->config->width * spec->config->height * 6);
        if (!s->edited)
            r = ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    }
    if (r == 0 && spec->kind == QUILT_SINK_DATASET)
        r = create_dataset(cli, s);
    else if (r == 0 && spec->kind == QUILT_SINK_RAW)
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
    const struct ttf_pixbuf pixels = {.width = p->sink->spec.config->width,
                                      .height = p->sink->spec.config->height,
                                      .samples = 3,
                                      .format = TTF_SAMPLE_U16,
                                      .stride = (size_t)p->sink->spec.config->width * 6,
                                      .data = (void *)p->codes};
    const struct ttf_tiff_spec spec = {.compression = p->sink->compression,
                                       .icc = p->sink->icc,
                                       .times = {.start_utc_ns = TTF_NS_UNKNOWN},
                                       .software = "ttfbox " TTFBOX_VERSION};

    return ttf_tiff_write(io, file, &pixels, &spec, err);
}

/* How many frames output frame t lies beyond the input's last one; 0: not beyond. */
static int64_t beyond(const struct quilt_sink *s, uint32_t t)
{
    return t < s->spec.input->n ? 0 : (int64_t)t - s->spec.input->n + 1;
}

static int64_t slot_index(const struct quilt_sink *s, uint32_t t)
{
    uint32_t n = s->spec.input->n;

    return s->spec.input->index[t < n ? t : n - 1] + beyond(s, t) * s->index_step;
}

static int64_t slot_time(const struct quilt_sink *s, uint32_t t)
{
    uint32_t n = s->spec.input->n;

    return s->spec.input->time_ns[t < n ? t : n - 1] + beyond(s, t) * s->interval_ns;
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
    record.index = slot_index(s, t);
    record.due_ns = slot_time(s, t);
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

static int append(struct quilt_sink *s, const uint8_t *codes, struct ttf_err *err)
{
    size_t n = (size_t)s->spec.config->width * s->spec.config->height * 3;
    int r = ttf_io_append_all(s->io, s->file, codes, n);

    return r < 0 ? ttf_err_set(err, r, s->path, "cannot be written: %s", strerrordesc_np(-r)) : 0;
}

static int take(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    struct quilt_sink *s = ctx;
    size_t n = (size_t)s->spec.config->width * s->spec.config->height * 3;

    if (s->edited) {
        memcpy(s->edited, codes, n * sizeof *codes);
        s->spec.edit(s->spec.edit_ctx, &s->spec.input->encoding, s->edited);
        codes = s->edited;
    }
    if (s->spec.kind == QUILT_SINK_NULL)
        return 0;
    if (s->spec.kind == QUILT_SINK_DATASET)
        return commit(s, t, codes, err);
    for (size_t i = 0; i < n; i++)
        s->display[i] = s->table[codes[i]];
    return append(s, s->display, err);
}

/* Display codes as they come, each to its place. */
static int take_rows8(void *ctx, uint32_t t, uint32_t y0, uint32_t y1, const uint8_t *codes,
                      struct ttf_err *err)
{
    struct quilt_sink *s = ctx;
    size_t row = (size_t)s->spec.config->width * 3;
    int64_t at = (int64_t)(((uint64_t)t * s->spec.config->height + y0) * row);
    int r = ttf_io_pwrite_all(s->io, s->file, codes, (y1 - y0) * row, at);

    return r < 0 ? ttf_err_set(err, r, s->path, "cannot be written: %s", strerrordesc_np(-r)) : 0;
}

/* Frames of the input are those of the output where rows come as display codes. */
static int reserve(void *ctx, unsigned part, unsigned parts, struct ttf_err *err)
{
    struct quilt_sink *s = ctx;
    uint64_t all = (uint64_t)s->spec.config->width * s->spec.config->height * 3 * s->spec.input->n;
    int64_t from = (int64_t)(all / parts * part);
    int64_t to = part + 1 == parts ? (int64_t)all : (int64_t)(all / parts * (part + 1));
    int r = to > from ? ttf_io_reserve(s->io, s->file, from, to - from) : 0;

    if (r == 0 || r == -EOPNOTSUPP)
        return 0;
    return ttf_err_set(err, r, s->path, "cannot be written: %s", strerrordesc_np(-r));
}

struct ttf_quilt_sink quilt_sink_of(struct quilt_sink *sink)
{
    bool narrow = sink->spec.kind == QUILT_SINK_RAW && !sink->edited;

    return (struct ttf_quilt_sink){.frame = take,
                                   .rows8 = narrow ? take_rows8 : NULL,
                                   .reserve = narrow ? reserve : NULL,
                                   .ctx = sink};
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

    if (s->spec.kind == QUILT_SINK_DATASET) {
        r = derive_seal(s->writer, "count", s->digest, err);
        if (r == 0)
            r = write_report(s, report, err);
    } else if (s->spec.kind == QUILT_SINK_RAW) {
        r = s->io->ops->sync(s->io, s->file, false);
        if (r == 0)
            r = s->io->ops->rename(s->io, s->beside, s->path);
        if (r < 0)
            ttf_err_set(err, r, s->path, "cannot be finished: %s", strerrordesc_np(-r));
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
            (void)s->io->ops->unlink(s->io, s->beside);
    }
    free(s->beside);
    free(s->edited);
    free(s->display);
    free(s->table);
    free(s);
}
