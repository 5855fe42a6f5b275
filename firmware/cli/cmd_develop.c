/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_develop.c: `ttfbox develop`: a dataset's raw frames into a new dataset. */
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "derive.h"
#include "ttf/config/plan_file.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"

struct darkroom {
    struct cli *cli;
    struct ttf_reader *reader;
    struct ttf_writer *writer;
    struct ttf_pool *pool;
    struct ttf_region region;
    struct ttf_calibration calibration; /* the one in use */
    char calibration_id[64];            /* empty: none */
    struct ttf_develop *develop;        /* for `format` under `calibration_id` */
    struct ttf_frame_format format;
    double plan_mm_per_px; /* 0: the plan does not say */
    bool done;
    int64_t images, without_raw;
    char digest[65];
};

/* plans/0.yaml of the parent, if there is one: its region, and the text for the child. */
static int read_plan(struct darkroom *d, char **ret_yaml, char **ret_json)
{
    struct ttf_io *io = d->cli->io;
    struct ttf_plan_file *file = NULL;
    char path[PATH_MAX];
    size_t bytes;

    (void)snprintf(path, sizeof path, "%s/plans/0.json", d->cli->opt.args[0]);
    if (ttf_io_slurp(io, path, 1 << 20, ret_json, &bytes, NULL) < 0)
        *ret_json = NULL;
    (void)snprintf(path, sizeof path, "%s/plans/0.yaml", d->cli->opt.args[0]);
    if (ttf_io_slurp(io, path, 1 << 20, ret_yaml, &bytes, NULL) < 0) {
        *ret_yaml = NULL;
        return 0;
    }
    int r = ttf_plan_file_parse(path, *ret_yaml, bytes, &file, &d->cli->err);

    if (r < 0)
        return r;
    d->region = ttf_plan_file_plan(file)->region;
    d->plan_mm_per_px = ttf_plan_file_plan(file)->mm_per_px;
    ttf_plan_file_free(file);
    return 0;
}

/* The calibration an image is to be developed with: --calibration, else its own. */
static int use_calibration(struct darkroom *d, const char *own_id)
{
    struct cli *cli = d->cli;
    char folder[PATH_MAX];
    int r;

    if (cli->opt.calibration) {
        if (*d->calibration_id)
            return 0;
        (void)snprintf(folder, sizeof folder, "%s", cli->opt.calibration);
    } else {
        if (strcmp(d->calibration_id, own_id) == 0)
            return 0;
        (void)snprintf(folder, sizeof folder, "%s/calibration/%s", cli->opt.args[0], own_id);
    }
    ttf_develop_destroy(d->develop);
    d->develop = NULL;
    ttf_calibration_free(&d->calibration);
    ttf_calibration_init(&d->calibration);
    d->calibration_id[0] = '\0';
    if (!cli->opt.calibration && !*own_id)
        return 0;
    r = ttf_calibration_load(cli->io, folder, &d->calibration, &cli->err);
    if (r < 0)
        return r;
    (void)snprintf(d->calibration_id, sizeof d->calibration_id, "%s", d->calibration.id);
    return ttf_writer_calibration(d->writer, d->calibration_id, folder, &cli->err);
}

static bool same_format(const struct ttf_frame_format *a, const struct ttf_frame_format *b)
{
    return a->width == b->width && a->height == b->height && a->packing == b->packing &&
           a->cfa == b->cfa && a->bits == b->bits && a->black_level == b->black_level &&
           a->white_level == b->white_level;
}

static int use_format(struct darkroom *d, const struct ttf_frame_format *format,
                      const struct ttf_encoding *encoding)
{
    const struct ttf_develop_config config = {
        .format = *format,
        .calibration = *d->calibration_id ? &d->calibration : NULL,
        .region = d->region,
        .encoding = *encoding,
    };

    if (d->develop && same_format(format, &d->format))
        return 0;
    ttf_develop_destroy(d->develop);
    d->develop = NULL;
    d->format = *format;
    return ttf_develop_create(&config, &d->develop, &d->cli->err);
}

struct produce {
    struct darkroom *room;
    const struct ttf_raw_sum *raw;
    struct ttf_tiff_times times;
    struct ttf_image_figures figures;
};

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    struct produce *p = ctx;

    return ttf_develop_tiff(p->room->develop, p->raw, p->room->pool, &p->times, io, file,
                            &p->figures, err);
}

/* Settings as the record has them: a DNG keeps fewer digits. */
static void settings_of(const struct ttf_image *image, struct ttf_raw_sum *raw)
{
    for (unsigned i = 0; i < image->n_shots; i++)
        if (!*image->shots[i].refused && image->shots[i].granted.exposure_ns > 0)
            raw->settings = image->shots[i].granted;
}

static int develop_raw(struct darkroom *d, int64_t index, struct ttf_image *image,
                       const struct ttf_file_ref *raw_file)
{
    struct cli *cli = d->cli;
    const struct ttf_stream *stream =
        ttf_manifest_stream(ttf_reader_manifest(d->reader), image->stream);
    struct produce p = {.room = d};
    struct ttf_dng_info info;
    struct ttf_raw_sum raw;
    char path[PATH_MAX];
    int r;

    if (!stream)
        return ttf_err_set(&cli->err, -TTF_EDAMAGED, raw_file->path, "is of no known stream");
    (void)snprintf(path, sizeof path, "%s/%s", cli->opt.args[0], raw_file->path);
    r = use_calibration(d, image->calibration);
    if (r == 0)
        r = ttf_dng_read(cli->io, path, &raw, &info, &cli->err);
    if (r < 0)
        return r;
    settings_of(image, &raw);
    p.raw = &raw;
    p.times = info.times;
    r = use_format(d, &raw.format, &stream->encoding);
    if (r == 0)
        r = ttf_writer_file(d->writer, "developed", image->stream, index, image->bracket, "tif",
                            produce, &p, &image->files[0], &cli->err);
    ttf_raw_sum_free(&raw);
    if (r < 0)
        return r;
    image->n_files = 1;
    image->mean_level = p.figures.mean_level;
    image->sharpness = p.figures.sharpness;
    image->reference_level = NAN;
    memset(image->calibration, 0, sizeof image->calibration);
    memcpy(image->calibration, d->calibration_id, strlen(d->calibration_id));
    return 0;
}

/* Images without a raw file cannot be had anew: they are lacking, and say so. */
static int develop_slot(struct darkroom *d, struct ttf_slot_record *record)
{
    bool lacking = false, taken = false;

    for (unsigned i = 0; i < record->n_images; i++) {
        struct ttf_image *image = &record->images[i];
        const struct ttf_file_ref *raw = NULL;
        struct ttf_file_ref copy;

        for (unsigned f = 0; f < image->n_files; f++)
            if (strcmp(image->files[f].role, "raw") == 0)
                raw = &image->files[f];
        if (!raw) {
            if (image->n_files) {
                d->without_raw++;
                (void)snprintf(image->lacking, sizeof image->lacking, "no raw frame was kept");
            }
            image->n_files = 0;
            lacking = true;
            continue;
        }
        copy = *raw;
        int r = develop_raw(d, record->index, image, &copy);

        if (r < 0)
            return r;
        d->images++;
        taken = true;
    }
    if (record->result == TTF_RESULT_CAPTURED && lacking) {
        record->result = taken ? TTF_RESULT_PARTIAL : TTF_RESULT_FAILED;
        (void)snprintf(record->reason, sizeof record->reason, "no raw frame was kept");
    }
    return ttf_writer_commit(d->writer, record, &d->cli->err);
}

static int develop_all(struct darkroom *d)
{
    const struct ttf_reader_summary *s = ttf_reader_summary(d->reader);
    struct cli *cli = d->cli;
    struct cli_progress bar;
    int64_t n = cli->opt.frames && cli->opt.frames < s->slots ? cli->opt.frames : s->slots;
    int r = 0;

    for (int i = 0; r == 0 && i < s->n_segments; i++) {
        struct ttf_segment segment;

        r = ttf_reader_segment(d->reader, i, &segment);
        segment.plan = segment.plan > 0 ? 0 : segment.plan;
        if (r == 0)
            r = ttf_writer_segment(d->writer, &segment, &cli->err);
    }
    cli_stop_catch();
    cli_progress_begin(&bar, cli, "developing");
    for (int64_t i = 0; r == 0 && i < n; i++) {
        struct ttf_slot_record record;

        r = ttf_reader_slot(d->reader, i, &record, &cli->err);
        if (r < 0)
            break;
        r = develop_slot(d, &record);
        ttf_slot_record_free(&record);
        cli_progress_at(&bar, i + 1, n, NULL);
        if (r == 0 && *cli_stop_flag())
            r = ttf_err_set(&cli->err, -ECANCELED, NULL, "stopped");
    }
    cli_progress_end(&bar);
    if (r == 0 && d->images == 0) {
        r = ttf_err_set(&cli->err, -ENODATA, cli->opt.args[0], "holds no raw frame");
        ttf_err_hint(&cli->err, "a plan with 'keep: raw' or 'keep: both' keeps them");
    }
    if (r == 0)
        r = derive_seal(d->writer, n == s->slots ? "count" : "frames", d->digest, &cli->err);
    d->done = r == 0;
    return r;
}

static bool is_of_camera(const struct ttf_calibration *calibration, const struct ttf_stream *stream)
{
    return !*calibration->camera || strcmp(calibration->camera, stream->camera) == 0;
}

/* What the new values mean, and how large a pixel is, is the given calibration's to say: the parent may have had another, or none. */
static int name_values(struct darkroom *d, struct ttf_manifest *m)
{
    struct cli *cli = d->cli;
    struct ttf_calibration given;
    int r;

    if (!cli->opt.calibration)
        return 0;
    ttf_calibration_init(&given);
    r = ttf_calibration_load(cli->io, cli->opt.calibration, &given, &cli->err);
    for (unsigned i = 0; r == 0 && i < m->n_streams; i++) {
        struct ttf_stream *s = &m->streams[i];

        (void)snprintf(s->quantity, sizeof s->quantity, "%s",
                       given.has_flat ? "reflectance" : "radiance");
        (void)snprintf(s->colour_space, sizeof s->colour_space, "%s",
                       given.has_flat ? "linear-srgb" : "camera");
        /* As of a capture: the plan's scale first. */
        if (given.has_geometry && !(d->plan_mm_per_px > 0) && is_of_camera(&given, s))
            s->mm_per_px = given.geometry.mm_per_px;
    }
    ttf_calibration_free(&given);
    return r;
}

static int create(struct darkroom *d)
{
    struct cli *cli = d->cli;
    const struct ttf_manifest *old = ttf_reader_manifest(d->reader);
    struct ttf_manifest *m = calloc(1, sizeof *m);
    char *yaml = NULL, *json = NULL;
    int r = m ? derive_manifest(cli, d->reader, m) : -ENOMEM;

    if (r == 0)
        r = read_plan(d, &yaml, &json);
    if (r == 0) {
        m->n_cameras = old->n_cameras;
        memcpy(m->cameras, old->cameras, sizeof m->cameras);
        m->n_channels = old->n_channels;
        memcpy(m->channels, old->channels, sizeof m->channels);
        m->n_streams = old->n_streams;
        memcpy(m->streams, old->streams, sizeof m->streams);
        r = name_values(d, m);
    }
    if (r == 0)
        r = derive_create(cli, cli->opt.output, m, yaml, json, &d->writer);
    if (r == 0)
        derive_people(cli, cli->opt.args[0], cli->opt.output);
    free(yaml);
    free(json);
    free(m);
    return r;
}

static int count_folder(void *ctx, const char *name, bool is_dir)
{
    *(int *)ctx += is_dir && *name != '.';
    return 0;
}

/* A dataset that was gone on with another calibration has several. */
static void say_calibrations(struct darkroom *d)
{
    struct cli *cli = d->cli;
    char path[PATH_MAX];
    int n = 0;

    (void)snprintf(path, sizeof path, "%s/calibration", cli->opt.output);
    (void)!cli->io->ops->list(cli->io, path, count_folder, &n);
    ttf_json_kint(&cli->out, "calibrations", n);
    if (n > 1) {
        cli_say(cli, "calibrations      %d: each picture with its own", n);
        return;
    }
    cli_say(cli, "calibration       %s", *d->calibration_id ? d->calibration_id : "none");
    ttf_json_kstring(&cli->out, "calibration", d->calibration_id);
}

static void say(struct darkroom *d)
{
    struct cli *cli = d->cli;
    bool simulated = ttf_reader_manifest(d->reader)->simulated;

    cli_say(cli, "%sdataset           %s", simulated ? "SIMULATED\n" : "", cli->opt.output);
    cli_say(cli, "images            %" PRId64 " developed, %" PRId64 " without a raw frame",
            d->images, d->without_raw);
    say_calibrations(d);
    if (*d->digest)
        cli_say(cli, "sealed            digest %s", d->digest);
    else
        cli_say(cli, "sealed            no: of a rehearsal");
    ttf_json_kstring(&cli->out, "dataset", cli->opt.output);
    ttf_json_kbool(&cli->out, "simulated", simulated);
    ttf_json_kint(&cli->out, "images", d->images);
    ttf_json_kint(&cli->out, "without_raw", d->without_raw);
    ttf_json_kstring(&cli->out, "digest", d->digest);
}

int cmd_develop(struct cli *cli)
{
    struct darkroom d = {.cli = cli};
    int r = cli_need(cli, cli->opt.output, "-o", "say where the new dataset goes");

    ttf_calibration_init(&d.calibration);
    if (r == 0)
        r = cli_refuse_existing(cli, cli->opt.output);
    if (r == 0)
        r = ttf_reader_open(cli->io, cli->opt.args[0], &d.reader, &cli->err);
    if (r == 0) {
        d.pool = ttf_pool_create((unsigned)cli->opt.threads);
        r = d.pool ? create(&d) : -ENOMEM;
    }
    if (r == 0)
        r = develop_all(&d);
    if (d.writer && d.done) {
        ttf_writer_close(d.writer);
    } else if (d.writer) {
        ttf_writer_abandon(d.writer);
        derive_discard(cli->io, cli->opt.output);
    }
    if (r == 0)
        say(&d);
    ttf_develop_destroy(d.develop);
    ttf_calibration_free(&d.calibration);
    ttf_pool_destroy(d.pool);
    ttf_reader_close(d.reader);
    return r;
}
