/* SPDX-License-Identifier: Apache-2.0 */
/* JSON text, lines, dataset.json and records: every field there and back. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lines.h"
#include "record_line.h"
#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/reader.h"

static void json_keeps_every_digit_and_every_character(void **state)
{
    static const double doubles[] = {0.1,     1.0 / 3, DBL_MIN, DBL_MAX,           5e-324,
                                     1e22,    -0.0,    31744.0, 0.1 + 0.2,         123456789.125,
                                     -1e-300, 2.5e15,  1e15,    9007199254740993.0};
    struct ttf_json json;
    const char *text;
    json_t *read, *array;
    size_t i;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kint(&json, "max", INT64_MAX);
    ttf_json_kint(&json, "min", INT64_MIN);
    ttf_json_kstring(&json, "odd", "\"\\\x01\n\t\x7f gr\xc3\xbc\xc3\x9f \xf0\x9f\x8c\xb1");
    ttf_json_kstring(&json, "bad",
                     "a\xff"
                     "b\xed\xa0\x80");
    ttf_json_kstring(&json, "none", NULL);
    ttf_json_key(&json, "doubles");
    ttf_json_array(&json);
    for (i = 0; i < TTF_COUNT_OF(doubles); i++)
        ttf_json_double(&json, doubles[i]);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    assert_int_equal(ttf_json_finish(&json, &text, NULL), 0);
    assert_non_null(strstr(text, "[0.1,0.333333333333333"));
    read = json_loads(text, 0, NULL);
    assert_non_null(read);
    assert_true(json_integer_value(json_object_get(read, "max")) == INT64_MAX);
    assert_true(json_integer_value(json_object_get(read, "min")) == INT64_MIN);
    assert_string_equal(json_string_value(json_object_get(read, "odd")),
                        "\"\\\x01\n\t\x7f gr\xc3\xbc\xc3\x9f \xf0\x9f\x8c\xb1");
    assert_string_equal(json_string_value(json_object_get(read, "bad")),
                        "a\xef\xbf\xbd"
                        "b\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");
    array = json_object_get(read, "doubles");
    for (i = 0; i < TTF_COUNT_OF(doubles); i++) {
        double back = json_number_value(json_array_get(array, i));

        assert_true(back == doubles[i] && signbit(back) == signbit(doubles[i]));
    }
    json_decref(read);
    ttf_json_free(&json);
}

static void json_that_cannot_be_is_refused_at_the_end(void **state)
{
    struct ttf_json json;
    int i;

    ttf_json_init(&json, false);
    ttf_json_double(&json, NAN);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EDOM);
    ttf_json_free(&json);
    ttf_json_init(&json, false);
    for (i = 0; i < 17; i++)
        ttf_json_array(&json);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EOVERFLOW);
    ttf_json_free(&json);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EINVAL);
    ttf_json_again(&json, false); /* nothing at all */
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EINVAL);
    ttf_json_again(&json, false); /* two values at the top */
    ttf_json_null(&json);
    ttf_json_null(&json);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EINVAL);
    ttf_json_again(&json, false); /* an end without a beginning */
    ttf_json_array_end(&json);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EINVAL);
    ttf_json_again(&json, false); /* a key without a value, and the object's end */
    ttf_json_object(&json);
    ttf_json_key(&json, "a");
    ttf_json_object_end(&json);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EINVAL);
    ttf_json_again(&json, false); /* two keys on end */
    ttf_json_object(&json);
    ttf_json_key(&json, "a");
    ttf_json_key(&json, "b");
    ttf_json_null(&json);
    ttf_json_object_end(&json);
    assert_int_equal(ttf_json_finish(&json, NULL, NULL), -EINVAL);
    ttf_json_free(&json);
}

static void pretty_json_is_for_people(void **state)
{
    struct ttf_json json;
    const char *text;

    ttf_json_init(&json, true);
    ttf_json_object(&json);
    ttf_json_kint(&json, "a", 1);
    ttf_json_key(&json, "b");
    ttf_json_array(&json);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    assert_int_equal(ttf_json_finish(&json, &text, NULL), 0);
    assert_string_equal(text, "{\n  \"a\": 1,\n  \"b\": []\n}\n");
    ttf_json_free(&json);
}

static void hashes_are_the_ones_everybody_knows(void **state)
{
    struct ttf_sha256 hash;
    char hex[65];

    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, "a", 1);
    ttf_sha256_add(&hash, "bc", 2);
    ttf_sha256_hex(&hash, hex); /* FIPS 180-4's own example */
    assert_string_equal(hex, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_int_equal(ttf_crc32(0, "123456789", 9), 0xcbf43926);
}

static void fill_manifest(struct ttf_manifest *m)
{
    small_manifest(m);
    strcpy(m->box_serial, "TTF-0001");
    strcpy(m->title, "gr\xc3\xbcn \"wächst\"");
    m->simulated = true;
    m->n_cameras = 2;
    strcpy(m->cameras[0].id, "top");
    strcpy(m->cameras[0].model, "IMX477");
    m->cameras[0].raw_width = 4056;
    m->cameras[0].raw_height = 3040;
    strcpy(m->cameras[0].cfa, "BGGR");
    m->cameras[0].raw_bits = 12;
    strcpy(m->cameras[1].id, "side");
    m->n_channels = 1;
    strcpy(m->channels[0].id, "ir-night");
    strcpy(m->channels[0].title, "by night");
    m->n_streams = 2;
    m->streams[0].mm_per_px = 0.0625;
    strcpy(m->streams[0].camera, "top");
    strcpy(m->streams[0].channel, "ir-night");
    m->streams[1] = m->streams[0];
    strcpy(m->streams[1].id, "uncertainty");
    strcpy(m->streams[1].quantity, "uncertainty");
    m->streams[1].primary = false;
    m->streams[1].format = TTF_SAMPLE_F16;
    m->streams[1].encoding.scale = 0.1;
    memcpy(m->group_uuid, m->uuid, sizeof(m->uuid));
    strcpy(m->group_member, "left");
    strcpy(m->source, "IMG_*.png");
    memcpy(m->derived_uuid, m->uuid, sizeof(m->uuid));
    memset(m->derived_digest, 'a', 64);
    strcpy(m->derived_command, "ttfbox synth quilt");
    m->derived_seed = INT64_MIN;
    m->has_derived_seed = true;
}

static void a_manifest_comes_back_whole(void **state)
{
    struct ttf_manifest m, back;
    char *text, *again;

    fill_manifest(&m);
    assert_int_equal(ttf_manifest_write(&m, &text, NULL), 0);
    memset(&back, 0, sizeof(back));
    assert_int_equal(ttf_manifest_read(text, strlen(text), "dataset.json", &back, NULL), 0);
    assert_string_equal(back.title, m.title);
    assert_int_equal(back.derived_seed, INT64_MIN);
    assert_true(back.streams[1].encoding.scale == 0.1);
    assert_int_equal(back.streams[1].format, TTF_SAMPLE_F16);
    assert_string_equal(ttf_manifest_primary(&back)->id, "main");
    assert_int_equal(ttf_manifest_write(&back, &again, NULL), 0);
    assert_string_equal(text, again); /* so no field was lost on the way */
    assert_int_equal(back.cameras[0].raw_bits, 12);
    assert_int_equal(back.streams[0].mm_per_px == 0.0625, 1);
    assert_string_equal(back.group_member, "left");
    free(text);
    free(again);
}

static void a_wrong_manifest_names_its_field(void **state)
{
    static const struct {
        const char *from, *to, *says;
        int code;
    } cases[] = {
        {"\"width\": 4", "\"width\": 0", "streams[0].width", -EINVAL},
        {"\"width\": 4", "\"width\": \"4\"", "streams[0].width must be a whole number", -EINVAL},
        {"\"u16\"", "\"u99\"", "streams[0].sample_format", -EINVAL},
        {"\"name\": \"ttf\"", "\"name\": \"zip\"", "format.name", -EINVAL},
        {"\"major\": 1", "\"major\": 2", "format.major is 2", -ENOTSUP},
        {"\"required\": []", "\"required\": [\"x-ray\"]", "x-ray", -ENOTSUP},
        {"\"scale\": 31744", "\"scale\": 0", "encoding", -EINVAL},
        {"\"id\": \"main\"", "\"id\": \"../main\"", "streams[0].id", -EINVAL},
        {"\"streams\": [", "\"streams\": 7, \"x\": [", "streams must be an array", -EINVAL},
        {"\"encoding\": {", "\"encoding\": 1, \"x\": {", "encoding must be an object", -EINVAL},
        {"\"scale\": 31744", "\"scale\": \"much\"", "scale must be a number", -EINVAL},
        {"\"simulated\": ", "\"simulated\": 1, \"x\": ", "simulated must be true or false",
         -EINVAL},
        {"\"quantity\": \"", "\"quantity\": null, \"x\": \"", "quantity is missing", -EINVAL},
        {"\"quantity\": \"", "\"quantity\": \"\", \"x\": \"", "quantity must not be empty",
         -EINVAL},
        {"\"quantity\": \"", "\"quantity\": [], \"x\": \"", "quantity must be a text", -EINVAL},
        {"\"id\": \"main\"", "\"id\": \"abcdefghijabcdefghijabcdefghijabcdefghij\"",
         "id is longer than 31 bytes", -EINVAL},
        {"{", "", "JSON", -EINVAL},
    };
    struct ttf_manifest m, back;
    char *text, *at, changed[4096];
    size_t i;

    small_manifest(&m);
    assert_int_equal(ttf_manifest_write(&m, &text, NULL), 0);
    for (i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct ttf_err err = {0};
        int r;

        at = strstr(text, cases[i].from);
        assert_non_null(at);
        snprintf(changed, sizeof(changed), "%.*s%s%s", (int)(at - text), text, cases[i].to,
                 at + strlen(cases[i].from));
        r = ttf_manifest_read(changed, strlen(changed), "dataset.json", &back, &err);
        if (r != cases[i].code || !strstr(err.what, cases[i].says))
            fail_msg("%s: %d, %s", cases[i].to, r, err.what);
    }
    free(text);
}

/* Rules between fields, as one who writes a dataset meets them: a struct, refused by ttf_manifest_write. */
static void a_manifest_that_cannot_be_is_not_written(void **state)
{
    struct ttf_manifest good, m;
    struct ttf_err err = {0};
    char *text = NULL;

    fill_manifest(&good);
    assert_int_equal(ttf_manifest_write(&good, &text, &err), 0);
    free(text);
#define REFUSED(change, says)                                           \
    do {                                                                \
        m = good;                                                       \
        change;                                                         \
        assert_int_equal(ttf_manifest_write(&m, &text, &err), -EINVAL); \
        if (!strstr(err.what, says))                                    \
            fail_msg("%s: %s", #change, err.what);                      \
    } while (0)
    REFUSED(m.n_streams = 0, "streams");
    REFUSED(m.n_streams = TTF_STREAMS_MAX + 1, "streams");
    REFUSED(m.n_cameras = TTF_CAMERAS_MAX + 1, "cameras");
    REFUSED(m.n_channels = TTF_CHANNELS_MAX + 1, "channels");
    REFUSED(m.streams[0].quantity[0] = '\0', "quantity is missing");
    REFUSED(m.streams[0].width = 0, "width and height");
    REFUSED(m.streams[0].width = 65536, "width and height");
    REFUSED(m.streams[0].height = 0, "width and height");
    REFUSED(m.streams[0].height = 65536, "width and height");
    REFUSED(m.streams[0].samples = 0, "samples");
    REFUSED(m.streams[0].samples = 256, "samples");
    REFUSED(m.streams[0].format = TTF_SAMPLE_COUNT, "sample_format");
    REFUSED(m.streams[0].encoding.pedestal = NAN, "encoding");
    REFUSED(m.streams[0].encoding.scale = INFINITY, "encoding");
    REFUSED(m.streams[0].mm_per_px = -1, "mm_per_px");
    REFUSED(m.streams[0].mm_per_px = NAN, "mm_per_px");
    REFUSED((m.n_streams = 2, m.streams[1] = m.streams[0]), "id is there twice");
    REFUSED((m.n_streams = 2, m.streams[1] = m.streams[0], m.streams[1].id[0] = 'x',
             m.streams[0].primary = m.streams[1].primary = true),
            "more than one is primary");
    REFUSED((m.n_cameras = 1, strcpy(m.cameras[0].id, "a/b")), "id must be a name");
    REFUSED((m.n_cameras = 2, strcpy(m.cameras[0].id, "a"), strcpy(m.cameras[1].id, "a")),
            "id is there twice");
    REFUSED((m.n_channels = 1, strcpy(m.channels[0].id, "..")), "id must be a name");
    REFUSED((m.n_channels = 2, strcpy(m.channels[0].id, "a"), strcpy(m.channels[1].id, "a")),
            "id is there twice");
    REFUSED(strcpy(m.uuid, "no uuid"), "uuid");
    REFUSED(strcpy(m.group_uuid, "F00DCAFE-0000-4000-8000-000000000099"), "group.uuid");
#undef REFUSED
}

/* A program that names no stream gets the primary one, the first where none is, none of none. */
static void the_primary_stream_is_the_one_marked_else_the_first(void **state)
{
    struct ttf_manifest m = {.n_streams = 2};

    strcpy(m.streams[0].id, "a");
    strcpy(m.streams[1].id, "b");
    assert_ptr_equal(ttf_manifest_primary(&m), &m.streams[0]);
    m.streams[1].primary = true;
    assert_ptr_equal(ttf_manifest_primary(&m), &m.streams[1]);
    assert_ptr_equal(ttf_manifest_stream(&m, "b"), &m.streams[1]);
    assert_null(ttf_manifest_stream(&m, "c"));
    m.n_streams = 0;
    assert_null(ttf_manifest_primary(&m));
}

static void fill_slot(struct ttf_slot_record *record)
{
    struct ttf_image *image;
    struct ttf_shot *shot;

    ttf_slot_record_init(record);
    record->index = 1234567;
    record->segment = 0;
    record->due_ns = INT64_C(1209600000000001);
    record->middle_ns = record->due_ns + 3;
    record->result = TTF_RESULT_PARTIAL;
    strcpy(record->reason, "lamp \"left\" tripped");
    record->n_sensors = 2;
    record->sensors[0] = (struct ttf_slot_sensor){"box", "temp_mdegc", true, -1500};
    record->sensors[1] = (struct ttf_slot_sensor){"hum", "humidity_permille", false, 0};
    assert_int_equal(ttf_slot_record_images(record, 2), 0);
    image = &record->images[0];
    strcpy(image->stream, "main");
    image->bracket = 1;
    image->relative_exposure = 0.25;
    assert_int_equal(ttf_image_shots(image, 2), 0);
    shot = &image->shots[0];
    shot->asked = (struct ttf_exposure){10000000, 1000, 1900, 1500, 3000};
    shot->granted = (struct ttf_exposure){9999984, 1016, 1900, 1500, 3000};
    shot->start_ns = INT64_C(1209599995000000);
    shot->end_ns = shot->start_ns + 9999984;
    shot->n_lamps = 2;
    shot->lamps[0] = (struct ttf_shot_lamp){"left", 1000, 987};
    shot->lamps[1] = (struct ttf_shot_lamp){"right", 0, -1};
    image->shots[1].asked = shot->asked;
    strcpy(image->shots[1].refused, "missing");
    image->n_averaged = 1;
    strcpy(image->calibration, "cal-a");
    image->n_files = 1;
    strcpy(image->files[0].role, "raw");
    strcpy(image->files[0].path, "raw/main/1234567.b1.dng");
    image->files[0].bytes = INT64_C(25000000000);
    memset(image->files[0].sha256, 'c', 64);
    image->mean_level = 0.1 + 0.2;
    image->reference_level = 0.0;
    image->sharpness = 1e-7;
    strcpy(image->flags, "saturated,wrong-settings");
    strcpy(record->images[1].stream, "main");
    strcpy(record->images[1].lacking, "late");
}

static void a_slot_comes_back_whole(void **state)
{
    struct ttf_slot_record record, back;
    struct ttf_json json, again;
    struct ttf_line line = {.where = "test", .type = "slot"};
    const struct ttf_image *image;
    const char *text, *text_again;
    size_t n;

    fill_slot(&record);
    ttf_line_begin(&json, "slot", 7);
    ttf_slot_put(&json, &record);
    assert_int_equal(ttf_line_finish(&json, &text, &n), 0);
    assert_true(ttf_line_holds(text, n));
    assert_false(ttf_line_holds(text, n - 1));
    line.json = json_loadb(text, n, 0, NULL);
    assert_non_null(line.json);
    assert_int_equal(ttf_slot_get(&line, &back, NULL), 0);
    image = &back.images[0];
    assert_int_equal(back.index, 1234567);
    assert_int_equal(back.middle_ns, record.middle_ns);
    assert_int_equal(back.result, TTF_RESULT_PARTIAL);
    assert_string_equal(back.reason, record.reason);
    assert_int_equal(back.sensors[0].value, -1500);
    assert_false(back.sensors[1].ok);
    assert_int_equal(image->bracket, 1);
    assert_memory_equal(&image->shots[0].granted, &record.images[0].shots[0].granted,
                        sizeof(struct ttf_exposure));
    assert_int_equal(image->shots[0].lamps[0].measured_permille, 987);
    assert_int_equal(image->shots[0].lamps[1].measured_permille, -1);
    assert_int_equal(image->shots[1].granted.exposure_ns, 0);
    assert_true(image->shots[1].start_ns == TTF_NS_UNKNOWN);
    assert_string_equal(image->shots[1].refused, "missing");
    assert_int_equal(image->files[0].bytes, INT64_C(25000000000));
    assert_true(image->mean_level == 0.1 + 0.2 && image->reference_level == 0.0);
    assert_true(image->sharpness == 1e-7 && image->relative_exposure == 0.25);
    assert_string_equal(image->stream, "main");
    assert_string_equal(image->calibration, "cal-a");
    assert_string_equal(image->files[0].role, "raw");
    assert_string_equal(image->files[0].path, "raw/main/1234567.b1.dng");
    assert_string_equal(image->files[0].sha256, record.images[0].files[0].sha256);
    assert_int_equal(image->n_averaged, 1);
    assert_int_equal(image->n_shots, 2);
    assert_memory_equal(&image->shots[0].asked, &record.images[0].shots[0].asked,
                        sizeof(struct ttf_exposure));
    assert_int_equal(image->shots[0].start_ns, record.images[0].shots[0].start_ns);
    assert_int_equal(image->shots[0].end_ns, record.images[0].shots[0].end_ns);
    assert_int_equal(image->shots[0].n_lamps, 2);
    assert_string_equal(image->shots[0].lamps[0].name, "left");
    assert_int_equal(image->shots[0].lamps[0].commanded_permille, 1000);
    assert_string_equal(back.sensors[1].name, "hum");
    assert_string_equal(back.sensors[0].kind, "temp_mdegc");
    assert_int_equal(back.due_ns, record.due_ns);
    assert_string_equal(image->flags, "saturated,wrong-settings");
    assert_int_equal(back.images[1].bracket, -1);
    assert_true(isnan(back.images[1].mean_level));
    assert_string_equal(back.images[1].lacking, "late");
    ttf_line_begin(&again, "slot", 7);
    ttf_slot_put(&again, &back);
    assert_int_equal(ttf_line_finish(&again, &text_again, NULL), 0);
    assert_string_equal(text, text_again);
    json_decref(line.json);
    ttf_json_free(&json);
    ttf_json_free(&again);
    ttf_slot_record_free(&record);
    ttf_slot_record_free(&back);
}

static void a_segment_comes_back_whole(void **state)
{
    const struct ttf_segment s = {.segment = 2,
                                  .first_index = 77,
                                  .boot_id = "0a0b0c0d-0000-4000-8000-000000000001",
                                  .origin_ns = 123,
                                  .origin_utc_ns = INT64_C(1790000000123456789),
                                  .trust = "ntp",
                                  .uncertainty_ns = 5,
                                  .interval_ns = 600 * TTF_NS_PER_S,
                                  .plan = 1,
                                  .zone = "Europe/Berlin",
                                  .zone_offset_s = 7200,
                                  .gap_ns = TTF_NS_UNKNOWN,
                                  .corrects = true};
    struct ttf_segment back;
    struct ttf_line line = {.where = "test", .type = "segment"};
    struct ttf_json json;
    const char *text;
    size_t n;

    memset(&back, 0, sizeof(back));
    ttf_line_begin(&json, "segment", 0);
    ttf_segment_put(&json, &s);
    assert_int_equal(ttf_line_finish(&json, &text, &n), 0);
    line.json = json_loadb(text, n, 0, NULL);
    assert_int_equal(ttf_segment_get(&line, &back, NULL), 0);
    assert_true(back.gap_ns == TTF_NS_UNKNOWN && back.corrects && back.plan == 1);
    assert_int_equal(back.origin_utc_ns, s.origin_utc_ns);
    assert_int_equal(back.uncertainty_ns, 5);
    assert_int_equal(back.interval_ns, s.interval_ns);
    assert_string_equal(back.zone, s.zone);
    assert_string_equal(back.boot_id, s.boot_id);
    assert_string_equal(back.trust, "ntp");
    assert_int_equal(back.zone_offset_s, 7200);
    json_decref(line.json);
    ttf_json_free(&json);
}

static void paths_cannot_lead_out_of_the_dataset(void **state)
{
    struct ttf_slot_record record;

    fill_slot(&record);
    strcpy(record.images[0].files[0].path, "raw/../../etc/passwd");
    assert_int_equal(ttf_slot_check(&record, NULL), -EINVAL);
    strcpy(record.images[0].files[0].path, "/etc/passwd");
    assert_int_equal(ttf_slot_check(&record, NULL), -EINVAL);
    strcpy(record.images[0].files[0].path, "raw/a b");
    assert_int_equal(ttf_slot_check(&record, NULL), -EINVAL);
    ttf_slot_record_free(&record);
}

static void whole_files_are_replaced_or_left_alone(void **state)
{
    struct cue cue = {.at = 1, .error = EIO, .op = "sync"};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    const char *path = in(*state, "x");
    char *text;

    assert_int_equal(ttf_io_write_file(quick_io(), path, "old", 3, NULL), 0);
    assert_int_equal(ttf_io_write_file(io, path, "new", 3, NULL), -EIO);
    text = file_text(path, NULL);
    assert_string_equal(text, "old");
    free(text);
    assert_false(exists(in(*state, "x.tmp")));
    assert_int_equal(ttf_io_write_file(io, path, "new", 3, NULL), 0);
    text = file_text(path, NULL);
    assert_string_equal(text, "new");
    free(text);
    assert_int_equal(ttf_io_slurp(io, path, 2, &text, NULL, NULL), -EFBIG);
    assert_int_equal(ttf_io_slurp(io, in(*state, "none"), 2, &text, NULL, NULL), -ENOENT);
    assert_int_equal(ttf_io_mkdirs(io, in(*state, "a//b/c/"), NULL), 0);
    assert_int_equal(ttf_io_mkdirs(io, in(*state, "a/b/c"), NULL), 0);
    assert_int_equal(ttf_io_mkdirs(io, in(*state, "x/y"), NULL), -ENOTDIR);
    assert_true(exists(in(*state, "a/b/c")));
    ttf_io_faulty_destroy(io);
}

static void only_one_holds_a_lock(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    int a = io->ops->open(io, *state, TTF_IO_READ), b = io->ops->open(io, *state, TTF_IO_READ);

    assert_int_equal(io->ops->lock(io, a), 0);
    assert_int_equal(io->ops->lock(io, b), -EAGAIN);
    assert_int_equal(io->ops->close(io, a), 0);
    assert_int_equal(io->ops->lock(io, b), 0);
    assert_int_equal(io->ops->close(io, b), 0);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(json_keeps_every_digit_and_every_character),
        cmocka_unit_test(json_that_cannot_be_is_refused_at_the_end),
        cmocka_unit_test(pretty_json_is_for_people),
        cmocka_unit_test(hashes_are_the_ones_everybody_knows),
        cmocka_unit_test(a_manifest_comes_back_whole),
        cmocka_unit_test(a_wrong_manifest_names_its_field),
        cmocka_unit_test(a_manifest_that_cannot_be_is_not_written),
        cmocka_unit_test(the_primary_stream_is_the_one_marked_else_the_first),
        cmocka_unit_test(a_slot_comes_back_whole),
        cmocka_unit_test(a_segment_comes_back_whole),
        cmocka_unit_test(paths_cannot_lead_out_of_the_dataset),
        T(whole_files_are_replaced_or_left_alone),
        T(only_one_holds_a_lock),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
