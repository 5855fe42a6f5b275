/* SPDX-License-Identifier: Apache-2.0 */
/* wire_v2.c: libgpiod 2.x (Debian 13). */
#include <dirent.h>
#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "wire.h"

struct wire {
    struct gpiod_line_request *request;
    struct gpiod_edge_event_buffer *events; /* of an input */
    unsigned offset;
};

const char *wire_version(void)
{
    return gpiod_api_version();
}

/* ---- finding ---- */

static bool is_called(struct gpiod_chip *chip, const char *name)
{
    struct gpiod_chip_info *info = gpiod_chip_get_info(chip);
    bool yes = info && (strcmp(gpiod_chip_info_get_name(info), name) == 0 ||
                        strcmp(gpiod_chip_info_get_label(info), name) == 0);

    gpiod_chip_info_free(info);
    return yes;
}

static int offset_of(struct gpiod_chip *chip, const char *line)
{
    int number = wire_number(line);

    return number >= 0 ? number : gpiod_chip_get_line_offset_from_name(chip, line);
}

/*
 * The chip that the line is on, open; NULL and what was the matter: -ENOENT, there is no such line; -ENODEV, the chip
 * that is named was not seen; else what opening the last one said.
 */
static struct gpiod_chip *find(const struct ttf_line_spec *spec, unsigned *ret_offset,
                               int *ret_code)
{
    struct gpiod_chip *chip = NULL;
    struct dirent *entry;
    DIR *dir = opendir("/dev");
    bool seen = false; /* the one that is named */
    int offset = -1;

    *ret_code = spec->chip[0] ? -ENODEV : -ENOENT;
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): of a stream of its own */
    while (dir && !chip && (entry = readdir(dir)) != NULL) {
        char path[280];

        (void)snprintf(path, sizeof(path), "/dev/%s", entry->d_name);
        if (strncmp(entry->d_name, "gpiochip", 8) != 0 || !gpiod_is_gpiochip_device(path))
            continue;
        chip = gpiod_chip_open(path);
        if (!chip) {
            if (!seen)
                *ret_code = -errno;
            continue;
        }
        if (!spec->chip[0] || is_called(chip, spec->chip)) {
            offset = offset_of(chip, spec->line);
            if ((seen = spec->chip[0] != '\0'))
                *ret_code = -ENOENT;
        }
        if (offset < 0) {
            gpiod_chip_close(chip);
            chip = NULL;
        }
    }
    if (dir)
        (void)closedir(dir);
    *ret_offset = offset < 0 ? 0 : (unsigned)offset;
    return chip;
}

/* ---- requesting ---- */

static int held(const struct ttf_line_spec *spec, struct gpiod_chip *chip, unsigned offset,
                struct ttf_err *err)
{
    struct gpiod_line_info *info = gpiod_chip_get_line_info(chip, offset);
    const char *who = info ? gpiod_line_info_get_consumer(info) : NULL;

    ttf_err_set(err, -EBUSY, spec->label, "GPIO line '%s' is held by %s", spec->line,
                who ? who : "the kernel or another process");
    gpiod_line_info_free(info);
    return -EBUSY;
}

static int configure(const struct ttf_line_spec *spec, struct gpiod_line_settings *settings)
{
    gpiod_line_settings_set_active_low(settings, spec->active_low);
    if (!spec->input)
        return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT) < 0 ||
                       gpiod_line_settings_set_output_value(settings, GPIOD_LINE_VALUE_INACTIVE) < 0
                   ? -EINVAL
                   : 0;
    if (spec->pull_up && gpiod_line_settings_set_bias(settings, GPIOD_LINE_BIAS_PULL_UP) < 0)
        return -EINVAL;
    return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT) < 0 ||
                   gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH) < 0
               ? -EINVAL
               : 0;
}

static int request(const struct ttf_line_spec *spec, struct gpiod_chip *chip, struct wire *wire,
                   struct ttf_err *err)
{
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    struct gpiod_line_config *lines = gpiod_line_config_new();
    struct gpiod_request_config *as = gpiod_request_config_new();
    int r = settings && lines && as ? configure(spec, settings) : -ENOMEM;

    if (r == 0 && gpiod_line_config_add_line_settings(lines, &wire->offset, 1, settings) < 0)
        r = -errno;
    if (r == 0) {
        gpiod_request_config_set_consumer(as, spec->label);
        wire->request = gpiod_chip_request_lines(chip, as, lines);
        r = wire->request ? 0 : -errno;
    }
    if (r == -EBUSY)
        held(spec, chip, wire->offset, err);
    else if (r < 0)
        ttf_err_set(err, r, spec->label, "GPIO line '%s' cannot be had", spec->line);
    gpiod_request_config_free(as);
    gpiod_line_config_free(lines);
    gpiod_line_settings_free(settings);
    return r;
}

static int not_found(const struct ttf_line_spec *spec, int code, struct ttf_err *err)
{
    bool no_chip = spec->chip[0] && code != -ENOENT;

    if (code == -ENODEV)
        code = -ENOENT;
    if (no_chip)
        ttf_err_set(err, code, spec->label, "GPIO chip '%s' cannot be opened", spec->chip);
    else
        ttf_err_set(err, code, spec->label, "no GPIO line is called '%s'%s%s", spec->line,
                    spec->chip[0] ? " on chip " : "", spec->chip);
    if (code == -EACCES)
        ttf_err_hint(err, "who runs this must be in the group that /dev/gpiochip* has");
    else
        ttf_err_hint(err, no_chip ? "gpiodetect lists the chips that there are"
                                  : "gpioinfo lists the lines that there are");
    return code;
}

int wire_request(const struct ttf_line_spec *spec, struct wire **ret, struct ttf_err *err)
{
    struct wire *wire = calloc(1, sizeof(*wire));
    struct gpiod_chip *chip;
    int r = 0;

    if (!wire)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (spec->chip[0] == '\0' && wire_number(spec->line) >= 0)
        r = -ENOENT; /* a number is of a chip */
    chip = r == 0 ? find(spec, &wire->offset, &r) : NULL;
    r = chip ? request(spec, chip, wire, err) : not_found(spec, r, err);
    if (chip)
        gpiod_chip_close(chip);
    if (r == 0 && spec->input) {
        wire->events = gpiod_edge_event_buffer_new(1);
        if (!wire->events)
            r = ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    if (r < 0) {
        wire_release(wire);
        return r;
    }
    *ret = wire;
    return 0;
}

int wire_holder(const struct ttf_line_spec *spec, char ret_holder[64], struct ttf_err *err)
{
    unsigned offset;
    int r = -ENOENT;
    struct gpiod_chip *chip =
        spec->chip[0] || wire_number(spec->line) < 0 ? find(spec, &offset, &r) : NULL;
    struct gpiod_line_info *info = chip ? gpiod_chip_get_line_info(chip, offset) : NULL;

    if (info) {
        const char *who = gpiod_line_info_get_consumer(info);

        r = gpiod_line_info_is_used(info);
        if (r)
            (void)snprintf(ret_holder, 64, "%s", who ? who : "");
        gpiod_line_info_free(info);
    } else {
        r = not_found(spec, chip ? -ENOENT : r, err); /* of a chip: it has fewer lines */
    }
    if (chip)
        gpiod_chip_close(chip);
    return r;
}

/* ---- using ---- */

int wire_set(struct wire *wire, bool active)
{
    return gpiod_line_request_set_value(wire->request, wire->offset,
                                        active ? GPIOD_LINE_VALUE_ACTIVE
                                               : GPIOD_LINE_VALUE_INACTIVE) < 0
               ? -errno
               : 0;
}

int wire_get(struct wire *wire)
{
    enum gpiod_line_value value = gpiod_line_request_get_value(wire->request, wire->offset);

    return value == GPIOD_LINE_VALUE_ERROR ? -errno : value == GPIOD_LINE_VALUE_ACTIVE;
}

int wire_fd(const struct wire *wire)
{
    return gpiod_line_request_get_fd(wire->request);
}

int wire_event(struct wire *wire, bool *ret_active)
{
    struct pollfd fd = {.fd = wire_fd(wire), .events = POLLIN};
    struct gpiod_edge_event *event;

    if (poll(&fd, 1, 0) <= 0)
        return 0;
    if (gpiod_line_request_read_edge_events(wire->request, wire->events, 1) < 0)
        return -errno;
    event = gpiod_edge_event_buffer_get_event(wire->events, 0);
    *ret_active = event && gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE;
    return 1;
}

void wire_release(struct wire *wire)
{
    if (!wire)
        return;
    gpiod_edge_event_buffer_free(wire->events);
    gpiod_line_request_release(wire->request);
    free(wire);
}
