/* SPDX-License-Identifier: Apache-2.0 */
#include "rich_dataset.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "store_test.h"
#include "ttf/dataset/tiff.h"
#include "ttf/dataset/writer.h"

/* The streams, in this order. */
enum {
    TOP,     /* camera top, white light, 16-bit RGB, a bracket of three */
    SIDE,    /* camera side, raking light, 16-bit grey, smaller */
    NIGHT,   /* camera top, infrared, 8-bit grey */
    HEIGHT,  /* a derived displacement in f32 */
    NORMALS, /* derived normals in f16 */
    N_STREAMS
};

static void put_stream(struct ttf_manifest *m, const char *id, const char *camera,
                       const char *channel, const char *quantity, enum ttf_sample format,
                       uint32_t samples)
{
    struct ttf_stream *s = &m->streams[m->n_streams++];

    snprintf(s->id, sizeof(s->id), "%s", id);
    snprintf(s->camera, sizeof(s->camera), "%s", camera);
    snprintf(s->channel, sizeof(s->channel), "%s", channel);
    snprintf(s->quantity, sizeof(s->quantity), "%s", quantity);
    snprintf(s->unit, sizeof(s->unit), "%s", strcmp(quantity, "displacement") == 0 ? "mm" : "1");
    snprintf(s->colour_space, sizeof(s->colour_space), "%s",
             samples == 3 && *camera ? "linear-srgb" : "none");
    s->width = *camera && strcmp(camera, "side") == 0 ? 5 : 8;
    s->height = 6;
    s->samples = samples;
    s->format = format;
    s->encoding = format == TTF_SAMPLE_U16
                      ? (struct ttf_encoding){.pedestal = TTF_PEDESTAL, .scale = TTF_SCALE}
                  : format == TTF_SAMPLE_U8 ? (struct ttf_encoding){.scale = 255}
                                            : (struct ttf_encoding){.scale = 1};
    s->mm_per_px = 0.05;
}

void rich_manifest(struct ttf_manifest *m)
{
    static const char *const channels[][2] = {
        {"white", "all lamps"}, {"raking-left", "from the left"}, {"ir-night", "infrared"}};

    assert_int_equal(ttf_manifest_init(m, NULL), 0);
    snprintf(m->uuid, sizeof(m->uuid), "%s",
             "5ca1ab1e-0000-4000-8000-000000000001"); /* the same bits every time */
    snprintf(m->title, sizeof(m->title), "%s",
             "everything that the format knows: \xc3\xa4\xe2\x82\xac");
    snprintf(m->box_serial, sizeof(m->box_serial), "%s", "box-7");
    m->n_cameras = 2;
    m->cameras[0] = (struct ttf_dataset_camera){"top", "A", 16, 12, "RGGB", 12};
    m->cameras[1] = (struct ttf_dataset_camera){"side", "B", 10, 12, "GRBG", 10};
    for (m->n_channels = 0; m->n_channels < 3; m->n_channels++) {
        snprintf(m->channels[m->n_channels].id, sizeof(m->channels[m->n_channels].id), "%s",
                 channels[m->n_channels][0]);
        snprintf(m->channels[m->n_channels].title, sizeof(m->channels[m->n_channels].title), "%s",
                 channels[m->n_channels][1]);
    }
    put_stream(m, "top", "top", "white", "reflectance", TTF_SAMPLE_U16, 3);
    put_stream(m, "side", "side", "raking-left", "radiance", TTF_SAMPLE_U16, 1);
    put_stream(m, "night", "top", "ir-night", "reflectance", TTF_SAMPLE_U8, 1);
    put_stream(m, "height", "", "", "displacement", TTF_SAMPLE_F32, 1);
    put_stream(m, "normals", "", "", "normals", TTF_SAMPLE_F16, 3);
    m->streams[TOP].primary = true;
    snprintf(m->group_uuid, sizeof(m->group_uuid), "%s", "5ca1ab1e-0000-4000-8000-000000000099");
    snprintf(m->group_member, sizeof(m->group_member), "%s", "box-7 of two");
}

uint16_t rich_code(int64_t slot, int stream, int bracket)
{
    if (stream == NIGHT)
        return (uint16_t)(40 + 3 * slot);
    if (stream == HEIGHT || stream == NORMALS)
        return (uint16_t)(slot + 1); /* in quarters, which half floats hold exactly */
    return (uint16_t)(TTF_PEDESTAL + 1000 + 100 * slot + 2000 * bracket + 7 * stream);
}

/* One file of an image. */
struct picture {
    const struct ttf_stream *stream;
    enum ttf_sample format;
    uint16_t code;
    int64_t utc_ns;
};

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct picture *p = ctx;
    struct ttf_tiff_spec spec = {
        .width = p->stream->width,
        .height = p->stream->height,
        .samples = p->stream->samples,
        .format = p->format,
        .icc = strcmp(p->stream->colour_space, "linear-srgb") == 0 ? TTF_ICC_LINEAR : TTF_ICC_NONE,
        .times = {p->utc_ns, 7200, 20 * TTF_NS_PER_MS},
    };
    size_t n = (size_t)spec.width * spec.samples, i;
    struct ttf_tiff_writer *tiff;
    float values[32];
    uint16_t codes[32];
    uint8_t bytes[32];
    const void *row;
    int r;

    for (i = 0; i < n; i++) {
        values[i] = (float)p->code / 4.0f;
        codes[i] = p->code;
        bytes[i] = (uint8_t)p->code;
    }
    row = p->format == TTF_SAMPLE_U8    ? (void *)bytes
          : p->format == TTF_SAMPLE_U16 ? (void *)codes
                                        : values;
    r = ttf_tiff_writer_open(io, file, &spec, &tiff, err);
    if (r)
        return r;
    for (i = 0; i < spec.height && r == 0; i++)
        r = ttf_tiff_writer_rows(tiff, row, 0, 1, err);
    if (r) {
        ttf_tiff_writer_abandon(tiff);
        return r;
    }
    return ttf_tiff_writer_close(tiff, err);
}

static void put_file(struct ttf_writer *writer, struct ttf_image *image, int64_t slot,
                     const char *role, struct picture *picture)
{
    struct ttf_err err = {0};

    if (ttf_writer_file(writer, role, image->stream, slot, image->bracket,
                        strcmp(role, "raw") == 0 ? "dng" : "tif", produce, picture,
                        &image->files[image->n_files++], &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
}

/* Nine exposures of which eight went in. */
static void put_shots(struct ttf_image *image, int64_t start_ns, int n)
{
    assert_int_equal(ttf_image_shots(image, (unsigned)n), 0);
    for (int i = 0; i < n; i++) {
        struct ttf_shot *shot = &image->shots[i];

        shot->asked = (struct ttf_exposure){20 * TTF_NS_PER_MS, 1000, 1900, 1500, 3000};
        shot->granted = shot->asked;
        shot->start_ns = start_ns + i * 40 * TTF_NS_PER_MS;
        shot->end_ns = shot->start_ns + 21 * TTF_NS_PER_MS;
        shot->n_lamps = 2;
        snprintf(shot->lamps[0].name, sizeof(shot->lamps[0].name), "%s", "left");
        shot->lamps[0].commanded_permille = 1000;
        shot->lamps[0].measured_permille = 996;
        snprintf(shot->lamps[1].name, sizeof(shot->lamps[1].name), "%s", "right");
        shot->lamps[1].measured_permille = -1;
    }
    if (n > 1)
        snprintf(image->shots[n / 2].refused, sizeof(image->shots[n / 2].refused), "%s", "corrupt");
    image->n_averaged = (unsigned)(n > 1 ? n - 1 : 1);
}

static void put_image(struct ttf_writer *writer, struct ttf_slot_record *record, int stream,
                      int bracket, const char *calibration)
{
    const struct ttf_stream *s = &ttf_writer_manifest(writer)->streams[stream];
    struct ttf_image *image = &record->images[record->n_images++];
    struct picture picture = {.stream = s,
                              .format = s->format,
                              .code = rich_code(record->index, stream, bracket < 0 ? 0 : bracket),
                              .utc_ns = INT64_C(1790000000000000000) + record->due_ns};
    struct ttf_slot_record one; /* for the values that mean "absent" */

    ttf_slot_record_init(&one);
    assert_int_equal(ttf_slot_record_images(&one, 1), 0);
    *image = one.images[0];
    one.images[0] = (struct ttf_image){0};
    ttf_slot_record_free(&one);
    snprintf(image->stream, sizeof(image->stream), "%s", s->id);
    image->bracket = bracket;
    image->relative_exposure = bracket < 0 ? 0 : bracket == 0 ? 0.25 : bracket == 1 ? 1 : 4;
    if (s->camera[0]) {
        put_shots(image, record->due_ns, stream == SIDE ? 9 : 1);
        snprintf(image->calibration, sizeof(image->calibration), "%s", calibration);
    }
    put_file(writer, image, record->index, "developed", &picture);
    if (stream == TOP && bracket == 1) {
        put_file(writer, image, record->index, "raw", &picture);
        put_file(writer, image, record->index, "uncertainty", &picture);
        put_file(writer, image, record->index, "mask", &picture);
        image->reference_level = 0.9;
        snprintf(image->flags, sizeof(image->flags), "%s", "saturated,lamp-unsettled");
    }
    image->mean_level = s->format == TTF_SAMPLE_F16 || s->format == TTF_SAMPLE_F32
                            ? picture.code / 4.0
                            : (picture.code - s->encoding.pedestal) / s->encoding.scale;
    image->sharpness = 0.25;
}

static void put_slot(struct ttf_writer *writer, int64_t index, int segment, int64_t due_ns,
                     const char *calibration)
{
    struct ttf_slot_record record;
    struct ttf_err err = {0};

    ttf_slot_record_init(&record);
    assert_int_equal(ttf_slot_record_images(&record, 8), 0);
    record.n_images = 0;
    record.index = index;
    record.segment = segment;
    record.due_ns = due_ns;
    record.middle_ns = due_ns + 250000;
    for (int b = 0; b < 3; b++)
        put_image(writer, &record, TOP, b, calibration);
    put_image(writer, &record, SIDE, -1, calibration);
    put_image(writer, &record, NIGHT, -1, calibration);
    put_image(writer, &record, HEIGHT, -1, calibration);
    if (index == 3) { /* one image is lacking, and says why */
        struct ttf_image *image = &record.images[record.n_images++];

        snprintf(image->stream, sizeof(image->stream), "%s", "normals");
        snprintf(image->lacking, sizeof(image->lacking), "%s", "no height");
        record.result = TTF_RESULT_PARTIAL;
        snprintf(record.reason, sizeof(record.reason), "%s", "normals: no height");
    } else {
        put_image(writer, &record, NORMALS, -1, calibration);
    }
    record.n_sensors = 2;
    snprintf(record.sensors[0].name, sizeof(record.sensors[0].name), "%s", "box");
    snprintf(record.sensors[0].kind, sizeof(record.sensors[0].kind), "%s", "temp_mdegc");
    record.sensors[0].ok = true;
    record.sensors[0].value = -1500;
    snprintf(record.sensors[1].name, sizeof(record.sensors[1].name), "%s", "air");
    snprintf(record.sensors[1].kind, sizeof(record.sensors[1].kind), "%s", "rh_permille");
    if (ttf_writer_commit(writer, &record, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    ttf_slot_record_free(&record);
}

/* A slot without images. */
static void put_absent(struct ttf_writer *writer, int64_t index, int segment,
                       enum ttf_result result, const char *reason)
{
    struct ttf_slot_record record;

    ttf_slot_record_init(&record);
    record.index = index;
    record.segment = segment;
    record.due_ns = (5 + 10 * index) * TTF_NS_PER_S;
    record.result = result;
    snprintf(record.reason, sizeof(record.reason), "%s", reason);
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
}

static void put_segment(struct ttf_writer *writer, int n, int64_t first, int64_t utc_ns,
                        const char *trust, int plan, int64_t gap_ns, bool corrects)
{
    struct ttf_segment s = {.segment = n,
                            .first_index = first,
                            .origin_ns = 5 * TTF_NS_PER_S,
                            .origin_utc_ns = utc_ns,
                            .uncertainty_ns =
                                utc_ns == TTF_NS_UNKNOWN ? TTF_NS_UNKNOWN : TTF_NS_PER_S,
                            .interval_ns = 10 * TTF_NS_PER_S,
                            .plan = plan,
                            .zone = "Europe/Berlin",
                            .zone_offset_s = 7200,
                            .gap_ns = gap_ns,
                            .corrects = corrects};

    snprintf(s.trust, sizeof(s.trust), "%s", trust);
    snprintf(s.boot_id, sizeof(s.boot_id), "0a0b0c0d-0000-4000-8000-00000000000%d", n);
    assert_int_equal(ttf_writer_segment(writer, &s, NULL), 0);
}

/* A folder as `calibrate` might leave it, for the writer to copy. */
static void put_calibration(struct ttf_writer *writer, const char *id)
{
    char folder[512], file[600], text[100];

    snprintf(folder, sizeof(folder), "%s-%s", ttf_writer_path(writer), id);
    assert_int_equal(run("mkdir -p '%s'", folder), 0);
    snprintf(file, sizeof(file), "%s/calibration.json", folder);
    snprintf(text, sizeof(text), "{\"id\":\"%s\"}\n", id);
    write_text(file, text, strlen(text));
    snprintf(file, sizeof(file), "%s/dark.tif", folder);
    write_text(file, id, strlen(id));
    assert_int_equal(ttf_writer_calibration(writer, id, folder, NULL), 0);
    assert_int_equal(run("rm -rf '%s'", folder), 0);
}

/* What people and other programs add, outside the seal. */
static void put_outside(const char *path)
{
    static const char notes[] =
        "{\"utc_ns\":1790000100000000000,\"author\":\"me\",\"slots\":[[1,2],"
        "[6,6]],\"text\":\"a fly\",\"tags\":[\"exclude\"]}\n"
        "{\"utc_ns\":1790000200000000000,\"text\":\"all well\"}\n";
    static const char samples[] =
        "{\"samples\":[{\"id\":\"s1\",\"title\":\"copper\",\"region\":{\"x\":1,\"y\":1,"
        "\"width\":4,\"height\":3},\"treatment\":\"vinegar\"}]}\n";
    char file[600];

    snprintf(file, sizeof(file), "%s/notes.jsonl", path);
    write_text(file, notes, sizeof(notes) - 1);
    snprintf(file, sizeof(file), "%s/samples.json", path);
    write_text(file, samples, sizeof(samples) - 1);
    snprintf(file, sizeof(file), "%s/report.json", path);
    write_text(file, "{}\n", 3);
    assert_int_equal(run("mkdir -p '%s/preview'", path), 0);
    snprintf(file, sizeof(file), "%s/preview/last.jpg", path);
    write_text(file, "no picture", 10);
}

void rich_build(struct ttf_io *io, const char *path, enum rich_ending ending)
{
    const int64_t utc = INT64_C(1790000000000000000);
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    rich_manifest(&manifest);
    if (ttf_writer_create(io, path, &manifest, "interval: 10s\n", "{\"interval_ns\":1}\n", &writer,
                          &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    put_segment(writer, 0, 0, utc, "rtc", 0, 0, false);
    put_calibration(writer, "cal-a");
    for (int64_t i = 0; i < 4; i++) {
        if (i == 2) {
            put_calibration(writer, "cal-b");
            assert_int_equal(ttf_writer_event(writer, "door", i, utc + i, "opened\nand shut",
                                              "{\"for_ns\":1}", NULL),
                             0);
        }
        put_slot(writer, i, 0, (5 + 10 * i) * TTF_NS_PER_S, i < 2 ? "cal-a" : "cal-b");
    }
    put_absent(writer, 4, 0, TTF_RESULT_POWER, "the box had no power");
    put_absent(writer, 5, 0, TTF_RESULT_POWER, "the box had no power");
    assert_int_equal(ttf_writer_plan(writer, "interval: 10s # changed\n", "{}\n", NULL), 1);
    put_segment(writer, 1, 6, utc + 65 * TTF_NS_PER_S, "ntp", 1, 20 * TTF_NS_PER_S, false);
    put_slot(writer, 6, 1, 5 * TTF_NS_PER_S, "cal-b");
    put_segment(writer, 2, 7, TTF_NS_UNKNOWN, "none", 1, TTF_NS_UNKNOWN, false);
    put_slot(writer, 7, 2, 5 * TTF_NS_PER_S, "cal-a");
    put_segment(writer, 2, 7, utc + 3600 * TTF_NS_PER_S, "host", 1, 3525 * TTF_NS_PER_S, true);
    assert_int_equal(ttf_writer_event(writer, "clock-step", TTF_NS_UNKNOWN, utc, NULL, NULL, NULL),
                     0);
    put_slot(writer, 8, 2, 15 * TTF_NS_PER_S, "cal-a");
    put_outside(path);
    if (ending == RICH_SEALED)
        assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    if (ending != RICH_CUT) {
        ttf_writer_close(writer);
        return;
    }
    ttf_writer_abandon(writer);
    /* Newlines are not synced: power takes the last ones along. */
    assert_int_equal(run("truncate -s -1 '%s/records.jsonl' '%s/events.jsonl'", path, path), 0);
}
