/* SPDX-License-Identifier: Apache-2.0 */
/* sensors.c: readings of hwmon and IIO drivers. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/base/attr.h"
#include "ttf/hal/sysfs.h"

#define PATH_BYTES   384
#define FOLDER_BYTES 448

/* Counts that nobody tells the unit of: no errno that reading a file gives. */
#define NO_SCALE (-ENOMSG)

struct sysfs_sensors {
    struct ttf_sensors base; /* first: downcast by address */
    struct ttf_clock *clock;
    char root[128];
    unsigned n;
    struct ttf_sysfs_sensor spec[TTF_SENSORS_MAX];
    char folder[TTF_SENSORS_MAX][FOLDER_BYTES]; /* of the device; empty: to be looked for */
};

static const struct {
    const char *folder, *prefix;
} buses[] = {[TTF_SYSFS_HWMON] = {"class/hwmon", "hwmon"},
             [TTF_SYSFS_IIO] = {"bus/iio/devices", "iio:device"}};

/* What a kind is called where nothing else is said; NULL: there is no usual one. */
static const char *const usual[][TTF_SENSOR_KIND_COUNT] = {
    [TTF_SYSFS_HWMON] = {[TTF_SENSOR_TEMP_MDEGC] = "temp1",
                         [TTF_SENSOR_HUMIDITY_MPCT] = "humidity1",
                         [TTF_SENSOR_UNDERVOLTAGE] = "in0"},
    [TTF_SYSFS_IIO] = {[TTF_SENSOR_TEMP_MDEGC] = "in_temp",
                       [TTF_SENSOR_HUMIDITY_MPCT] = "in_humidityrelative",
                       [TTF_SENSOR_LIGHT_PERMILLE] = "in_illuminance",
                       [TTF_SENSOR_PRESSURE_PA] = "in_pressure"},
};

/* The first line of a file. 0, or a negative errno: also of a driver that cannot measure now. */
static int read_line(const char *path, char *ret, size_t size)
{
    int file = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t n;

    if (file < 0)
        return -errno;
    n = read(file, ret, size - 1);
    if (n < 0)
        n = -errno;
    (void)close(file);
    if (n <= 0)
        return n < 0 ? (int)n : -ENODATA;
    ret[n] = '\0';
    ret[strcspn(ret, "\n")] = '\0';
    return 0;
}

static int read_number(const char *folder, const char *channel, const char *suffix, double *ret)
{
    char path[FOLDER_BYTES + 80], text[64];
    char *end;
    double number;
    int r;

    (void)snprintf(path, sizeof(path), "%s/%s_%s", folder, channel, suffix);
    r = read_line(path, text, sizeof(text));
    if (r < 0)
        return r;
    number = strtod(text, &end);
    if (end == text || !isfinite(number))
        return -EINVAL;
    *ret = number;
    return 0;
}

/* A channel's type, without modifier and indices: "in_temp" of "in_temp_object" and "in_temp1". */
static void type_of(const char *channel, char *ret)
{
    unsigned parts = 0;

    for (; *channel && parts < 2; channel++) {
        parts += *channel == '_';
        if (parts < 2 && (*channel < '0' || *channel > '9'))
            *ret++ = *channel;
    }
    *ret = '\0';
}

/* Of the channel alone; or, as the kernel names what all channels of a type share, of its type. */
static int read_shared(const struct ttf_sysfs_sensor *spec, const char *folder, const char *suffix,
                       double *ret)
{
    char type[sizeof(spec->channel)];
    int r = read_number(folder, spec->channel, suffix, ret);

    if (r != -ENOENT || spec->bus != TTF_SYSFS_IIO)
        return r;
    type_of(spec->channel, type);
    return read_number(folder, type, suffix, ret);
}

/* As the driver counts: processed where it does that, else (raw + offset) * scale. */
static int read_driver(const struct ttf_sysfs_sensor *spec, const char *folder, double *ret)
{
    double raw, offset = 0.0, scale = 1.0;
    int r = read_number(folder, spec->channel, "input", ret);

    if (r != -ENOENT)
        return r;
    r = read_number(folder, spec->channel, "raw", &raw);
    if (r < 0)
        return r;
    r = read_shared(spec, folder, "offset", &offset);
    if (r < 0 && r != -ENOENT)
        return r;
    r = read_shared(spec, folder, "scale", &scale);
    /* Light is told as a share of the board's own number, which may as well be of counts. */
    if (r == -ENOENT)
        r = spec->kind == TTF_SENSOR_LIGHT_PERMILLE ? 0 : NO_SCALE;
    *ret = (raw + offset) * scale;
    return r;
}

/* The number behind the prefix; -1: it is no device of that bus. */
static long device_number(const char *entry, const char *prefix)
{
    size_t n = strlen(prefix);
    char *end;
    long number;

    if (strncmp(entry, prefix, n) != 0 || entry[n] < '0' || entry[n] > '9')
        return -1;
    number = strtol(entry + n, &end, 10);
    return *end ? -1 : number;
}

static void look_for(struct sysfs_sensors *s, unsigned i)
{
    const struct ttf_sysfs_sensor *spec = &s->spec[i];
    char bus[PATH_BYTES], path[PATH_BYTES * 2 + 32], name[64];
    long best = -1;
    struct dirent *entry;
    DIR *dir;

    s->folder[i][0] = '\0';
    (void)snprintf(bus, sizeof(bus), "%s/%s", s->root, buses[spec->bus].folder);
    dir = opendir(bus);
    if (!dir)
        return;
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): of a stream of its own */
    while ((entry = readdir(dir)) != NULL) {
        long number = device_number(entry->d_name, buses[spec->bus].prefix);

        (void)snprintf(path, sizeof(path), "%s/%s/name", bus, entry->d_name);
        if (number < 0 || (best >= 0 && number > best) || read_line(path, name, sizeof(name)) < 0 ||
            strcmp(name, spec->device) != 0)
            continue;
        best = number;
        (void)snprintf(s->folder[i], sizeof(s->folder[i]), "%s/%s%ld", bus, buses[spec->bus].prefix,
                       number);
    }
    (void)closedir(dir);
}

/* In the kind's unit. Pressure is in kilopascal in IIO; the rest in thousandths, as here. */
static int64_t in_unit(const struct ttf_sysfs_sensor *spec, double value)
{
    if (spec->kind == TTF_SENSOR_PRESSURE_PA && spec->bus == TTF_SYSFS_IIO)
        value *= 1000.0;
    if (spec->kind == TTF_SENSOR_LIGHT_PERMILLE)
        value *= 1000.0 / spec->full;
    return llround(value);
}

static bool is_possible(enum ttf_sensor_kind kind, int64_t value)
{
    switch (kind) {
    case TTF_SENSOR_TEMP_MDEGC: /* -127 and 85 degrees and the like are what broken wires give: the former is out */
        return value > -60000 && value < 150000;
    case TTF_SENSOR_HUMIDITY_MPCT:
        return value >= 0 && value <= 100000;
    case TTF_SENSOR_PRESSURE_PA:
        return value >= 30000 && value <= 120000;
    case TTF_SENSOR_UNDERVOLTAGE:
        return value == 0 || value == 1;
    default:
        return value >= 0;
    }
}

/* ret_at_ns: before the driver is asked, which may hang: no value is younger than it is said to be. */
static int read_one(struct sysfs_sensors *s, unsigned i, double *ret, int64_t *ret_at_ns)
{
    const struct ttf_sysfs_sensor *spec = &s->spec[i];

    *ret_at_ns = ttf_clock_now_ns(s->clock);
    if (!s->folder[i][0])
        return -ENODEV;
    if (spec->kind == TTF_SENSOR_UNDERVOLTAGE) /* an alarm: raspberrypi-hwmon has nothing else */
        return read_number(s->folder[i], spec->channel, "lcrit_alarm", ret);
    return read_driver(spec, s->folder[i], ret);
}

static bool is_its(const struct sysfs_sensors *s, unsigned i)
{
    char path[PATH_BYTES * 2 + 32], name[64];

    (void)snprintf(path, sizeof(path), "%s/name", s->folder[i]);
    return read_line(path, name, sizeof(name)) >= 0 && strcmp(name, s->spec[i].device) == 0;
}

/*
 * It is not where it was: nothing is, or another one has its number now, whatever that one says. A bus that hangs or fails is another thing: asked
 * twice, it takes its driver's patience twice.
 */
static bool is_away(const struct sysfs_sensors *s, unsigned i, int r)
{
    return r == -ENOENT || r == -ENODEV || r == -ENXIO || (r < 0 && !is_its(s, i));
}

/* Why a reading is not ok. The first reason stays. */
static void complain(const struct ttf_sysfs_sensor *spec, int r, double value, struct ttf_err *err)
{
    if (!err || err->code)
        return;
    if (r == 0)
        (void)ttf_err_set(err, -ERANGE, spec->name, "%s of %s tells %g, which cannot be",
                          spec->channel, spec->device, value);
    else if (r == NO_SCALE)
        (void)ttf_err_set(err, r, spec->name,
                          "%s has neither %s_input nor a scale for %s_raw: its counts have no unit",
                          spec->device, spec->channel, spec->channel);
    else
        (void)ttf_err_set(err, r, spec->name, "%s of %s: %s", spec->channel, spec->device,
                          strerrordesc_np(-r));
}

static int sysfs_read(struct ttf_sensors *base, struct ttf_reading ret[TTF_SENSORS_MAX],
                      struct ttf_err *err)
{
    struct sysfs_sensors *s = (struct sysfs_sensors *)base;

    if (err)
        err->code = 0;
    for (unsigned i = 0; i < s->n; i++) {
        struct ttf_reading *reading = &ret[i];
        double value = 0.0;
        int64_t at_ns;
        int r = read_one(s, i, &value, &at_ns);

        if (is_away(s, i, r)) {
            look_for(s, i); /* numbers change when a module is loaded anew */
            r = read_one(s, i, &value, &at_ns);
        }
        memset(reading, 0, sizeof(*reading));
        memcpy(reading->name, s->spec[i].name, sizeof(reading->name));
        reading->kind = s->spec[i].kind;
        reading->at_ns = at_ns;
        reading->ok = r == 0 && is_possible(reading->kind, in_unit(&s->spec[i], value));
        reading->value = reading->ok ? in_unit(&s->spec[i], value) : 0;
        if (!reading->ok)
            complain(&s->spec[i], r, value, err);
    }
    return (int)s->n;
}

static void sysfs_destroy(struct ttf_sensors *base)
{
    free(base);
}

static const struct ttf_sensors_ops OPS = {
    .name = "sysfs", .read = sysfs_read, .destroy = sysfs_destroy};

static int take(struct sysfs_sensors *s, const struct ttf_sysfs_sensor *spec, struct ttf_err *err)
{
    struct ttf_sysfs_sensor *mine = &s->spec[s->n];
    const char *channel;

    if (spec->name[0] == '\0' ||
        spec->name[strspn(spec->name, "abcdefghijklmnopqrstuvwxyz0123456789-")] != '\0')
        return ttf_err_set(err, -EINVAL, "sensors", "'%s' is no name for a sensor", spec->name);
    for (unsigned i = 0; i < s->n; i++)
        if (strcmp(s->spec[i].name, spec->name) == 0)
            return ttf_err_set(err, -EINVAL, spec->name, "two sensors have this name");
    if (spec->device[0] == '\0')
        return ttf_err_set(err, -EINVAL, spec->name, "no device is named");
    if (spec->kind == TTF_SENSOR_LIGHT_PERMILLE && !(spec->full > 0.0))
        return ttf_err_set(err, -EINVAL, spec->name, "what is full light is not said");
    channel = spec->channel[0] ? spec->channel : usual[spec->bus][spec->kind];
    if (!channel)
        return ttf_err_set(err, -EINVAL, spec->name, "no channel is named");
    *mine = *spec;
    memmove(mine->channel, channel, strlen(channel) + 1);
    s->n++;
    return 0;
}

int ttf_sensors_sysfs_create(const char *root, const struct ttf_sysfs_sensor *specs, unsigned n,
                             struct ttf_clock *clock, struct ttf_sensors **ret, struct ttf_err *err)
{
    struct sysfs_sensors *s;
    int r = 0;

    if (n == 0 || n > TTF_SENSORS_MAX || strlen(root) >= sizeof(s->root))
        return ttf_err_set(err, -EINVAL, "sensors", "%u sensors under %s", n, root);
    s = calloc(1, sizeof(*s));
    if (!s)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    s->base.ops = &OPS;
    s->clock = clock;
    memcpy(s->root, root, strlen(root) + 1);
    for (unsigned i = 0; i < n && r == 0; i++)
        r = take(s, &specs[i], err);
    if (r < 0) {
        free(s);
        return r;
    }
    *ret = &s->base;
    return 0;
}
