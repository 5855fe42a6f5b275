/* SPDX-License-Identifier: Apache-2.0 */
/*
 * dump DATASET: all that our reader reads of a dataset, as one JSON object in the shape of read.py, so that agree.py can hold the two
 * side by side, field by field. dump --rich FOLDER makes a dataset with everything in it there.
 */
#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lines.h"
#include "record_line.h"
#include "ttf/base/time.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/tiff.h"
#include "unit/dataset_store/rich_dataset.h"

/* ---- what does not apply is absent ---- */

static void text(json_t *o, const char *key, const char *value)
{
    if (value[0])
        json_object_set_new(o, key, json_string(value));
}

static void number(json_t *o, const char *key, int64_t value)
{
    json_object_set_new(o, key, json_integer(value));
}

static void not_0(json_t *o, const char *key, int64_t value)
{
    if (value != 0)
        number(o, key, value);
}

static void instant(json_t *o, const char *key, int64_t value)
{
    if (value != TTF_NS_UNKNOWN)
        number(o, key, value);
}

static void real(json_t *o, const char *key, double value)
{
    if (!isnan(value))
        json_object_set_new(o, key, json_real(value));
}

static void yes(json_t *o, const char *key, bool value)
{
    if (value)
        json_object_set_new(o, key, json_true());
}

static void list(json_t *o, const char *key, json_t *array)
{
    if (json_array_size(array) > 0)
        json_object_set_new(o, key, array);
    else
        json_decref(array);
}

/* ---- dataset.json ---- */

static json_t *stream_of(const struct ttf_stream *s)
{
    json_t *o = json_object();

    text(o, "id", s->id);
    text(o, "camera", s->camera);
    text(o, "channel", s->channel);
    text(o, "quantity", s->quantity);
    text(o, "unit", s->unit);
    number(o, "width", s->width);
    number(o, "height", s->height);
    number(o, "samples", s->samples);
    text(o, "sample_format", ttf_sample_name(s->format));
    real(o, "pedestal", s->encoding.pedestal);
    real(o, "scale", s->encoding.scale);
    text(o, "colour_space", s->colour_space);
    if (s->mm_per_px > 0)
        real(o, "mm_per_px", s->mm_per_px);
    yes(o, "primary", s->primary);
    return o;
}

static void put_origin(json_t *o, const struct ttf_manifest *m)
{
    json_t *group = json_object(), *parent = json_object();

    text(group, "uuid", m->group_uuid);
    text(group, "member", m->group_member);
    if (m->group_uuid[0])
        json_object_set(o, "group", group);
    text(parent, "uuid", m->derived_uuid);
    text(parent, "digest", m->derived_digest);
    text(parent, "command", m->derived_command);
    if (m->has_derived_seed)
        number(parent, "seed", m->derived_seed);
    if (json_object_size(parent) > 0)
        json_object_set(o, "derived_from", parent);
    json_decref(group);
    json_decref(parent);
}

static json_t *manifest_of(const struct ttf_manifest *m)
{
    json_t *o = json_object(), *cameras = json_array(), *channels = json_array();
    json_t *streams = json_array();

    text(o, "uuid", m->uuid);
    text(o, "title", m->title);
    json_object_set_new(o, "simulated", json_boolean(m->simulated));
    yes(o, "rehearsal", m->rehearsal);
    text(o, "box_serial", m->box_serial);
    text(o, "software", m->software);
    text(o, "source", m->source);
    for (unsigned i = 0; i < m->n_cameras; i++) {
        json_t *c = json_object();

        text(c, "id", m->cameras[i].id);
        text(c, "model", m->cameras[i].model);
        not_0(c, "raw_width", m->cameras[i].raw_width);
        not_0(c, "raw_height", m->cameras[i].raw_height);
        text(c, "cfa", m->cameras[i].cfa);
        not_0(c, "raw_bits", m->cameras[i].raw_bits);
        json_array_append_new(cameras, c);
    }
    for (unsigned i = 0; i < m->n_channels; i++) {
        json_t *c = json_object();

        text(c, "id", m->channels[i].id);
        text(c, "title", m->channels[i].title);
        json_array_append_new(channels, c);
    }
    for (unsigned i = 0; i < m->n_streams; i++)
        json_array_append_new(streams, stream_of(&m->streams[i]));
    list(o, "cameras", cameras);
    list(o, "channels", channels);
    list(o, "streams", streams);
    put_origin(o, m);
    return o;
}

/* ---- records.jsonl ---- */

static json_t *segment_of(const struct ttf_segment *s)
{
    json_t *o = json_object();

    number(o, "segment", s->segment);
    yes(o, "corrects", s->corrects);
    number(o, "first_index", s->first_index);
    text(o, "boot_id", s->boot_id);
    number(o, "origin_ns", s->origin_ns);
    instant(o, "origin_utc_ns", s->origin_utc_ns);
    text(o, "trust", s->trust);
    instant(o, "uncertainty_ns", s->uncertainty_ns);
    number(o, "interval_ns", s->interval_ns);
    if (s->plan >= 0)
        number(o, "plan", s->plan);
    text(o, "zone", s->zone);
    if (s->zone[0])
        number(o, "zone_offset_s", s->zone_offset_s);
    if (s->gap_ns == TTF_NS_UNKNOWN)
        json_object_set_new(o, "gap_ns", json_null());
    else
        not_0(o, "gap_ns", s->gap_ns);
    text(o, "dataset_sha256", s->dataset_sha256);
    not_0(o, "run_ns", s->run_ns);
    not_0(o, "run_utc_ns", s->run_utc_ns);
    text(o, "run_trust", s->run_trust);
    instant(o, "run_gaps_ns", s->run_gaps_ns);
    not_0(o, "run_doubted_ns", s->run_doubted_ns);
    not_0(o, "run_given_up_ns", s->run_given_up_ns);
    text(o, "box", s->box);
    return o;
}

static void put_settings(json_t *o, const char *key, const struct ttf_exposure *e)
{
    json_t *s;

    if (e->exposure_ns == 0)
        return;
    s = json_object();
    number(s, "exposure_ns", e->exposure_ns);
    not_0(s, "gain_milli", e->gain_milli);
    not_0(s, "wb_r_milli", e->wb_r_milli);
    not_0(s, "wb_b_milli", e->wb_b_milli);
    not_0(s, "lens_mdpt", e->lens_mdpt);
    json_object_set_new(o, key, s);
}

static json_t *shot_of(const struct ttf_shot *shot)
{
    json_t *o = json_object(), *lamps = json_array();

    put_settings(o, "asked", &shot->asked);
    put_settings(o, "granted", &shot->granted);
    instant(o, "start_ns", shot->start_ns);
    instant(o, "end_ns", shot->end_ns);
    text(o, "refused", shot->refused);
    for (unsigned i = 0; i < shot->n_lamps; i++) {
        json_t *l = json_object();

        text(l, "name", shot->lamps[i].name);
        number(l, "commanded_permille", shot->lamps[i].commanded_permille);
        if (shot->lamps[i].measured_permille >= 0)
            number(l, "measured_permille", shot->lamps[i].measured_permille);
        json_array_append_new(lamps, l);
    }
    list(o, "lamps", lamps);
    return o;
}

static json_t *flags_of(const char *flags)
{
    json_t *words = json_array();
    char copy[sizeof(((struct ttf_image *)0)->flags)], *rest = copy, *word;

    snprintf(copy, sizeof copy, "%s", flags);
    while ((word = strsep(&rest, ",")))
        if (word[0])
            json_array_append_new(words, json_string(word));
    return words;
}

static json_t *files_of_image(const struct ttf_image *image)
{
    json_t *files = json_array();

    for (unsigned i = 0; i < image->n_files; i++) {
        json_t *f = json_object();

        text(f, "role", image->files[i].role);
        text(f, "path", image->files[i].path);
        number(f, "bytes", image->files[i].bytes);
        text(f, "sha256", image->files[i].sha256);
        json_array_append_new(files, f);
    }
    return files;
}

/* What a DNG holds: its size, levels and mosaic, and the crc of its samples as 16 bits, little-endian. */
static void put_raw(json_t *o, const char *dataset, const char *file)
{
    static const char *const CFA[] = {[TTF_CFA_NONE] = "none",
                                      [TTF_CFA_RGGB] = "RGGB",
                                      [TTF_CFA_BGGR] = "BGGR",
                                      [TTF_CFA_GRBG] = "GRBG",
                                      [TTF_CFA_GBRG] = "GBRG"};
    struct ttf_raw_sum sum = {0};
    json_t *raw = json_object();
    char path[4096];
    uint32_t crc = 0;

    snprintf(path, sizeof path, "%s/%s", dataset, file);
    if (ttf_dng_read(ttf_io_posix(), path, &sum, NULL, NULL) == 0) {
        for (size_t i = 0; i < (size_t)sum.format.width * sum.format.height; i++) {
            const uint8_t sample[] = {(uint8_t)sum.sum[i], (uint8_t)(sum.sum[i] >> 8)};

            crc = ttf_crc32(crc, sample, sizeof sample);
        }
        number(raw, "width", sum.format.width);
        number(raw, "height", sum.format.height);
        number(raw, "black", sum.format.black_level);
        number(raw, "white", sum.format.white_level);
        text(raw, "cfa", CFA[sum.format.cfa]);
        number(raw, "crc", crc);
    }
    json_object_set_new(o, "raw", raw);
    ttf_raw_sum_free(&sum);
}

/* What an image says of itself, one developed or beside it: its geometry, its colours, when it was taken. */
static void put_picture(json_t *o, const char *dataset, const struct ttf_file_ref *file)
{
    struct ttf_tiff_reader *reader = NULL;
    json_t *picture = json_object();
    char path[4096];

    snprintf(path, sizeof path, "%s/%s", dataset, file->path);
    if (ttf_tiff_reader_open(ttf_io_posix(), path, &reader, NULL) == 0) {
        const struct ttf_tiff_info *info = ttf_tiff_reader_info(reader);

        number(picture, "width", info->width);
        number(picture, "height", info->height);
        number(picture, "samples", info->samples);
        text(picture, "sample_format", ttf_sample_name(info->format));
        number(picture, "orientation", info->orientation);
        json_object_set_new(picture, "icc", json_boolean(info->has_icc));
        json_object_set_new(picture, "linear", json_boolean(!info->display_encoded));
        instant(picture, "start_utc_ns", info->times.start_utc_ns);
        if (info->zone_known)
            number(picture, "zone_offset_s", info->times.zone_offset_s);
        not_0(picture, "exposure_ns", info->times.exposure_ns);
        json_object_set(o, file->role, picture);
        ttf_tiff_reader_close(reader);
    }
    json_decref(picture);
}

static json_t *image_of(const char *dataset, const struct ttf_image *image)
{
    json_t *o = json_object(), *shots = json_array();

    text(o, "stream", image->stream);
    if (image->bracket >= 0) {
        json_t *b = json_object();

        number(b, "index", image->bracket);
        if (image->relative_exposure > 0)
            real(b, "relative_exposure", image->relative_exposure);
        json_object_set_new(o, "bracket", b);
    }
    text(o, "lacking", image->lacking);
    for (unsigned i = 0; i < image->n_shots; i++)
        json_array_append_new(shots, shot_of(&image->shots[i]));
    list(o, "shots", shots);
    not_0(o, "n_averaged", image->n_averaged);
    text(o, "calibration", image->calibration);
    list(o, "files", files_of_image(image));
    for (unsigned i = 0; i < image->n_files; i++)
        if (strcmp(image->files[i].role, "raw") == 0)
            put_raw(o, dataset, image->files[i].path);
        else
            put_picture(o, dataset, &image->files[i]);
    real(o, "mean_level", image->mean_level);
    real(o, "reference_level", image->reference_level);
    real(o, "sharpness", image->sharpness);
    list(o, "flags", flags_of(image->flags));
    return o;
}

static json_t *slot_of(struct ttf_reader *reader, const struct ttf_slot_record *record)
{
    json_t *o = json_object(), *images = json_array(), *sensors = json_array();

    number(o, "index", record->index);
    number(o, "segment", record->segment);
    number(o, "due_ns", record->due_ns);
    instant(o, "due_utc_ns", ttf_reader_due_utc_ns(reader, record));
    instant(o, "middle_ns", record->middle_ns);
    text(o, "result", ttf_result_name(record->result));
    text(o, "reason", record->reason);
    for (unsigned i = 0; i < record->n_sensors; i++) {
        json_t *s = json_object();

        text(s, "name", record->sensors[i].name);
        text(s, "kind", record->sensors[i].kind);
        json_object_set_new(s, "ok", json_boolean(record->sensors[i].ok));
        if (record->sensors[i].ok)
            number(s, "value", record->sensors[i].value);
        json_array_append_new(sensors, s);
    }
    for (unsigned i = 0; i < record->n_images; i++)
        json_array_append_new(images, image_of(ttf_reader_path(reader), &record->images[i]));
    list(o, "sensors", sensors);
    list(o, "images", images);
    return o;
}

struct lines {
    json_t *plans, *calibrations, *end, *events;
};

static int add_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    json_t *o = json_object();

    (void)err;
    text(o, "path", file->path);
    number(o, "bytes", file->bytes);
    text(o, "sha256", file->sha256);
    return json_array_append_new(ctx, o);
}

static json_t *end_of(const struct ttf_end_record *e)
{
    json_t *o = json_object();

    text(o, "reason", e->reason);
    number(o, "slots", e->slots);
    not_0(o, "captured", e->captured);
    not_0(o, "partial", e->partial);
    not_0(o, "missed", e->missed);
    not_0(o, "failed", e->failed);
    not_0(o, "paused", e->paused);
    not_0(o, "power", e->power);
    return o;
}

static int one_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    struct lines *lines = ctx;
    json_t *o = json_object(), *files = json_array();
    struct ttf_end_record end;
    int plan, r = 0;
    char id[64];

    if (strcmp(line->type, "plan") == 0 || strcmp(line->type, "calibration") == 0) {
        bool is_plan = line->type[0] == 'p';

        r = is_plan ? ttf_plan_get(line, &plan, err) : ttf_calibration_get(line, id, err);
        if (r == 0 && is_plan)
            number(o, "plan", plan);
        else if (r == 0)
            text(o, "id", id);
        r = r ? r : ttf_line_files(line, add_file, files, err);
        json_object_set(o, "files", files);
        json_array_append(is_plan ? lines->plans : lines->calibrations, o);
    } else if (strcmp(line->type, "end") == 0) {
        r = ttf_end_get(line, &end, err);
        json_decref(lines->end);
        lines->end = r == 0 ? end_of(&end) : NULL;
    } else if (strcmp(line->type, "event") == 0) {
        json_t *event = json_copy(line->json);

        json_object_del(event, "type");
        json_object_del(event, "crc");
        json_array_append_new(lines->events, event);
    }
    json_decref(o);
    json_decref(files);
    return r;
}

/* ---- what people add ---- */

static void one_note(void *ctx, const struct ttf_note *note)
{
    json_t *o = json_object(), *slots = json_array(), *tags = json_array();

    instant(o, "utc_ns", note->utc_ns);
    text(o, "author", note->author);
    text(o, "text", note->text);
    for (unsigned i = 0; i < note->n_slots; i++)
        json_array_append_new(slots, json_pack("[I,I]", (json_int_t)note->slots[i][0],
                                               (json_int_t)note->slots[i][1]));
    for (unsigned i = 0; i < note->n_tags; i++)
        json_array_append_new(tags, json_string(note->tags[i]));
    list(o, "slots", slots);
    list(o, "tags", tags);
    json_array_append_new(ctx, o);
}

static json_t *samples_of(const char *path)
{
    struct ttf_sample_region *regions = NULL;
    json_t *samples = json_array();
    unsigned n = 0;

    if (ttf_samples_read(ttf_io_posix(), path, &regions, &n, NULL) != 0)
        n = 0;
    for (unsigned i = 0; i < n; i++) {
        json_t *o = json_object(), *r = json_object();

        text(o, "id", regions[i].id);
        text(o, "title", regions[i].title);
        text(o, "treatment", regions[i].treatment);
        number(r, "x", regions[i].region.x);
        number(r, "y", regions[i].region.y);
        number(r, "width", regions[i].region.width);
        number(r, "height", regions[i].region.height);
        json_object_set_new(o, "region", r);
        json_array_append_new(samples, o);
    }
    free(regions);
    return samples;
}

/* ---- all of it ---- */

static int read_slots(struct ttf_reader *reader, json_t *root, struct ttf_err *err)
{
    const struct ttf_reader_summary *sum = ttf_reader_summary(reader);
    json_t *slots = json_array(), *segments = json_array(), *counts = json_object();
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int r = 0;

    for (int i = 0; r == 0 && i < sum->n_segments; i++) {
        r = ttf_reader_segment(reader, i, &segment);
        if (r == 0)
            json_array_append_new(segments, segment_of(&segment));
    }
    for (int64_t i = 0; r == 0 && i < sum->slots; i++) {
        r = ttf_reader_slot(reader, i, &record, err);
        if (r == 0) {
            json_array_append_new(slots, slot_of(reader, &record));
            ttf_slot_record_free(&record);
        }
    }
    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        number(counts, ttf_result_name((enum ttf_result)i), sum->counts[i]);
    json_object_set_new(root, "segments", segments);
    json_object_set_new(root, "slots", slots);
    json_object_set_new(root, "counts", counts);
    json_object_set_new(root, "ended", json_boolean(sum->ended));
    json_object_set_new(root, "sealed", json_boolean(sum->sealed));
    return r;
}

static int read_lines(const char *path, json_t *root, struct ttf_err *err)
{
    struct lines lines = {json_array(), json_array(), NULL, json_array()};
    struct ttf_lines_tail tail;
    char file[4096];
    int r;

    snprintf(file, sizeof file, "%s/records.jsonl", path);
    r = ttf_lines_scan(ttf_io_posix(), file, one_line, NULL, &lines, &tail, err);
    snprintf(file, sizeof file, "%s/events.jsonl", path);
    if (r == 0)
        r = ttf_lines_scan(ttf_io_posix(), file, one_line, NULL, &lines, &tail, err);
    if (r == -ENOENT) /* nothing wrote events */
        r = 0;
    json_object_set_new(root, "plans", lines.plans);
    json_object_set_new(root, "calibrations", lines.calibrations);
    json_object_set_new(root, "events", lines.events);
    if (lines.end)
        json_object_set_new(root, "end", lines.end);
    return r;
}

static int dump(const char *path)
{
    json_t *root = json_object(), *notes = json_array();
    const struct ttf_note_visitor visitor = {.note = one_note, .ctx = notes};
    struct ttf_reader *reader = NULL;
    struct ttf_err err = {0};
    char digest[65];
    int r = ttf_reader_open(ttf_io_posix(), path, &reader, &err);

    if (r == 0) {
        json_object_set_new(root, "manifest", manifest_of(ttf_reader_manifest(reader)));
        r = read_slots(reader, root, &err);
    }
    r = r ? r : read_lines(path, root, &err);
    r = r ? r : ttf_notes_read(ttf_io_posix(), path, &visitor, &err);
    if (r == 0 && ttf_reader_digest(reader, digest, NULL) == 0)
        text(root, "digest", digest);
    json_object_set_new(root, "notes", notes);
    json_object_set_new(root, "samples", samples_of(path));
    if (r == 0)
        (void)json_dumpf(root, stdout, JSON_SORT_KEYS | JSON_INDENT(1));
    else
        fprintf(stderr, "%s: %s: %s\n", path, err.where, err.what);
    ttf_reader_close(reader);
    json_decref(root);
    return r ? 1 : 0;
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--rich") == 0) {
        rich_build(ttf_io_posix(), argv[2], RICH_SEALED);
        return 0;
    }
    return argc == 2 ? dump(argv[1]) : 2;
}
