/* SPDX-License-Identifier: Apache-2.0 */
/* wire_v1.c: libgpiod 1.6 (Debian 12). */
#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>

#include "wire.h"

struct wire {
    struct gpiod_chip *chip;
    struct gpiod_line *line;
};

#define MAY "who runs this must be in the group that /dev/gpiochip* has"

const char *wire_version(void)
{
    return gpiod_version_string();
}

static int no_chip(const struct ttf_line_spec *spec, int code, struct ttf_err *err)
{
    ttf_err_set(err, code, spec->label, "GPIO chip '%s' cannot be opened", spec->chip);
    ttf_err_hint(err, code == -EACCES ? MAY : "gpiodetect lists the chips that there are");
    return code;
}

static int no_line(const struct ttf_line_spec *spec, struct ttf_err *err)
{
    if (errno == EACCES || errno == EPERM) {
        ttf_err_set(err, -EACCES, spec->label, "GPIO chips may not be looked at");
        return ttf_err_hint(err, MAY), -EACCES;
    }
    ttf_err_set(err, -ENOENT, spec->label, "no GPIO line is called '%s'%s%s", spec->line,
                spec->chip[0] ? " on chip " : "", spec->chip);
    ttf_err_hint(err, "gpioinfo lists the lines that there are");
    return -ENOENT;
}

/* The line and its chip, both open. */
static int find(const struct ttf_line_spec *spec, struct wire *wire, struct ttf_err *err)
{
    int number = wire_number(spec->line);

    if (spec->chip[0] == '\0') {
        wire->line = number < 0 ? gpiod_line_find(spec->line) : NULL;
        if (!wire->line)
            return no_line(spec, err);
        wire->chip = gpiod_line_get_chip(wire->line);
        return 0;
    }
    wire->chip = gpiod_chip_open_lookup(spec->chip);
    if (!wire->chip)
        return no_chip(spec, errno ? -errno : -ENOENT, err);
    wire->line = number < 0 ? gpiod_chip_find_line(wire->chip, spec->line)
                            : gpiod_chip_get_line(wire->chip, (unsigned)number);
    return wire->line ? 0 : no_line(spec, err);
}

static int flags_of(const struct ttf_line_spec *spec)
{
    return (spec->active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0) |
           (spec->input && spec->pull_up ? GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP : 0);
}

static int refused(const struct ttf_line_spec *spec, struct wire *wire, int code,
                   struct ttf_err *err)
{
    const char *who = NULL;

    if (code == -EBUSY && gpiod_line_update(wire->line) == 0)
        who = gpiod_line_consumer(wire->line);
    if (code == -EBUSY)
        ttf_err_set(err, code, spec->label, "GPIO line '%s' is held by %s%s", spec->line,
                    who ? who : "the kernel or another process", who ? "" : " without a name");
    else
        ttf_err_set(err, code, spec->label, "GPIO line '%s' cannot be had", spec->line);
    return code;
}

int wire_request(const struct ttf_line_spec *spec, struct wire **ret, struct ttf_err *err)
{
    struct wire *wire = calloc(1, sizeof(*wire));
    int r;

    if (!wire)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    errno = 0;
    r = find(spec, wire, err);
    if (r == 0) {
        r = spec->input
                ? gpiod_line_request_both_edges_events_flags(wire->line, spec->label,
                                                             flags_of(spec))
                : gpiod_line_request_output_flags(wire->line, spec->label, flags_of(spec), 0);
        if (r < 0)
            r = refused(spec, wire, errno ? -errno : -EIO, err);
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
    struct wire wire = {0};
    int r;

    errno = 0;
    r = find(spec, &wire, err);
    if (r == 0 && gpiod_line_is_used(wire.line)) {
        const char *who = gpiod_line_consumer(wire.line);

        (void)snprintf(ret_holder, 64, "%s", who ? who : "");
        r = 1;
    }
    if (wire.chip)
        gpiod_chip_close(wire.chip);
    return r;
}

int wire_set(struct wire *wire, bool active)
{
    return gpiod_line_set_value(wire->line, active) < 0 ? -errno : 0;
}

int wire_get(struct wire *wire)
{
    int value = gpiod_line_get_value(wire->line);

    return value < 0 ? -errno : value;
}

int wire_fd(const struct wire *wire)
{
    return gpiod_line_event_get_fd(wire->line);
}

int wire_event(struct wire *wire, bool *ret_active)
{
    struct pollfd fd = {.fd = wire_fd(wire), .events = POLLIN};
    struct gpiod_line_event event;

    if (poll(&fd, 1, 0) <= 0)
        return 0;
    if (gpiod_line_event_read(wire->line, &event) < 0)
        return -errno;
    *ret_active = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
    return 1;
}

void wire_release(struct wire *wire)
{
    if (!wire)
        return;
    if (wire->line)
        gpiod_line_release(wire->line);
    if (wire->chip)
        gpiod_chip_close(wire->chip);
    free(wire);
}
