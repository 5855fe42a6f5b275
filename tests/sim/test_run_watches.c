/* SPDX-License-Identifier: Apache-2.0 */
/* What creeps up over many slots while each by itself is well: the run goes on, and the dataset says so. */
#include "cmocka_includes.h"

#include <stdio.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/hal/camera_backend.h"
#include "ttf/hal/sensors.h"

#define SLOTS 24

static const struct sim_run *running; /* what strange devices ask how far it is */

/* ---- a lens that lets go ---- */

static const struct ttf_camera_ops *camera_ops;
static struct ttf_camera_ops soft_camera;
static int64_t soft_from;

/* Half way between each pixel and the next of its colour. */
static void soften(const struct ttf_frame *frame)
{
    for (uint32_t y = 0; y < frame->format.height; y++) {
        uint16_t *row = (uint16_t *)((char *)frame->data + y * frame->format.stride);

        for (uint32_t x = 0; x + 2 < frame->format.width; x++)
            row[x] = (uint16_t)((row[x] + row[x + 2]) / 2);
    }
}

static int soft_next(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret,
                     struct ttf_err *err)
{
    int r = camera_ops->next(camera, deadline_ns, ret, err);

    if (r == 0 && running->committed >= soft_from)
        soften(*ret);
    return r;
}

static void loosen(struct sim_run *run)
{
    struct ttf_camera *camera = run->box->cameras[0].camera;

    camera_ops = camera->ops;
    soft_camera = *camera_ops;
    soft_camera.next = soft_next;
    camera->ops = &soft_camera;
}

static void begin(struct sim_run *run)
{
    sim_run_init(run);
    run->plan.count = SLOTS;
    running = run;
    soft_from = INT64_MAX;
}

static void a_lens_that_lets_go_is_told_once(void **state)
{
    struct sim_run run;

    (void)state;
    begin(&run);
    run.on_box = loosen;
    soft_from = SLOTS / 2;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(sim_run_events(&run, "focus", "stream main has lost"), 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_lens_that_holds_is_not_told_of(void **state)
{
    struct sim_run run;

    (void)state;
    begin(&run);
    run.on_box = loosen;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(sim_run_events(&run, "focus", NULL), 0);
    sim_run_finish(&run);
}

/* ---- air and supply ---- */

static const struct ttf_sensors_ops *sensors_ops;
static struct ttf_sensors_ops strange_sensors;
static const struct {
    int64_t humidity_mpct, low;
} weather[SLOTS] = {[6] = {97000, 0}, [7] = {97000, 0}, [9] = {0, 1}, [10] = {0, 1}};

static int strange_read(struct ttf_sensors *sensors, struct ttf_reading ret[TTF_SENSORS_MAX],
                        struct ttf_err *err)
{
    int n = sensors_ops->read(sensors, ret, err);
    int64_t k = running->committed < SLOTS ? running->committed : SLOTS - 1;

    if (n < 0)
        return n;
    for (int i = 0; i < n; i++)
        if (ret[i].kind == TTF_SENSOR_HUMIDITY_MPCT)
            ret[i].value = weather[k].humidity_mpct ? weather[k].humidity_mpct : 40000;
    ret[n] =
        (struct ttf_reading){.kind = TTF_SENSOR_UNDERVOLTAGE, .ok = true, .value = weather[k].low};
    snprintf(ret[n].name, sizeof(ret[n].name), "supply");
    return n + 1;
}

static void make_weather(struct sim_run *run)
{
    sensors_ops = run->box->sensors->ops;
    strange_sensors = *sensors_ops;
    strange_sensors.read = strange_read;
    run->box->sensors->ops = &strange_sensors;
}

static void fog_and_a_sagging_supply_are_events_readings_and_flags(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    begin(&run);
    run.on_box = make_weather;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(sim_run_events(&run, "dew", "may fog"), 1);
    assert_int_equal(sim_run_events(&run, "dew", "no fog"), 1);
    assert_int_equal(sim_run_events(&run, "supply", "too low"), 1);
    assert_int_equal(sim_run_events(&run, "supply", "right again"), 1);
    for (int64_t k = 0; k < SLOTS; k++) {
        bool low = false;

        sim_run_record(&run, k, &record);
        for (unsigned i = 0; i < record.n_sensors; i++)
            low |=
                strcmp(record.sensors[i].kind, "undervoltage") == 0 && record.sensors[i].value == 1;
        assert_int_equal(low, weather[k].low);
        assert_true(record.n_images > 0);
        for (unsigned i = 0; i < record.n_images; i++)
            assert_int_equal(strstr(record.images[i].flags, "under-voltage") != NULL, low);
        ttf_slot_record_free(&record);
    }
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lens_that_lets_go_is_told_once),
        cmocka_unit_test(a_lens_that_holds_is_not_told_of),
        cmocka_unit_test(fog_and_a_sagging_supply_are_events_readings_and_flags),
    };

    return cmocka_run_group_tests_name("watches", tests, NULL, NULL);
}
