/* SPDX-License-Identifier: Apache-2.0 */
/* channel.c: the files of one PWM channel (Documentation/ABI/testing/sysfs-class-pwm). */
#include "channel.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "ttf/hal/pwm.h"

/* ---- one attribute ---- */

/* A folder whose chip is gone has no files any more, in whatever way that is said. */
static int gone(int code)
{
    return code == -ENOENT || code == -ENXIO ? -ENODEV : code;
}

static int put(int folder, const char *name, const char *text)
{
    int file = openat(folder, name, O_WRONLY | O_TRUNC | O_CLOEXEC);
    size_t bytes = strlen(text);
    ssize_t n = file < 0 ? -1 : write(file, text, bytes);
    int r = n < 0 ? gone(-errno) : (size_t)n < bytes ? -EIO : 0;

    if (file >= 0)
        (void)close(file);
    return r;
}

static int put_number(int folder, const char *name, int64_t value)
{
    char text[24];

    (void)snprintf(text, sizeof text, "%" PRId64, value);
    return put(folder, name, text);
}

static int take(int folder, const char *name, char *ret, size_t size)
{
    int file = openat(folder, name, O_RDONLY | O_CLOEXEC);
    ssize_t n = file < 0 ? -1 : read(file, ret, size - 1);
    int r = n < 0 ? gone(-errno) : 0;

    if (file >= 0)
        (void)close(file);
    ret[n > 0 ? n : 0] = '\0';
    ret[strcspn(ret, "\n")] = '\0';
    return r;
}

static int take_number(int folder, const char *name, int64_t *ret)
{
    char text[32], *end;
    int r = take(folder, name, text, sizeof text);

    if (r < 0)
        return r;
    *ret = strtoll(text, &end, 10);
    return end == text ? -EIO : 0;
}

/* ---- finding ---- */

/* A chip by its own name, or by its device's, which does not change with the order of drivers. */
static bool is_called(int class_folder, const char *entry, const char *name)
{
    char link[64], target[PATH_MAX];
    const char *slash;
    ssize_t n;

    if (strncmp(entry, "pwmchip", 7) != 0)
        return false;
    if (strcmp(entry, name) == 0)
        return true;
    (void)snprintf(link, sizeof link, "%.40s/device", entry);
    n = readlinkat(class_folder, link, target, sizeof target - 1);
    if (n <= 0)
        return false;
    target[n] = '\0';
    slash = strrchr(target, '/');
    return strcmp(slash ? slash + 1 : target, name) == 0;
}

/* The chip's folder, open; -ENOENT. */
static int open_chip(const char *root, const char *name)
{
    char path[256];
    int class_folder, chip = -ENOENT;
    const struct dirent *entry;
    DIR *dir;

    (void)snprintf(path, sizeof path, "%.200s/class/pwm", root);
    dir = opendir(path);
    if (!dir)
        return -ENOENT;
    class_folder = dirfd(dir);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): of a stream of its own */
    while (chip == -ENOENT && (entry = readdir(dir)) != NULL)
        if (is_called(class_folder, entry->d_name, name)) {
            chip = openat(class_folder, entry->d_name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
            if (chip < 0)
                chip = -errno;
        }
    (void)closedir(dir);
    return chip;
}

static int failed(const struct ttf_line_spec *spec, int code, const char *what, const char *hint,
                  struct ttf_err *err)
{
    ttf_err_set(err, code, spec->label, "channel %s of PWM chip '%s' %s", spec->line, spec->chip,
                what);
    if (hint)
        ttf_err_hint(err, "%s", hint);
    return code;
}

/* The channel's folder, open; exported if nobody did that yet. */
static int open_channel(const struct ttf_line_spec *spec, int chip, struct ttf_err *err)
{
    char name[16];
    int64_t channels = 0;
    int folder, r = take_number(chip, "npwm", &channels);

    if (r == 0 && strtol(spec->line, NULL, 10) >= channels)
        return failed(spec, -ENOENT, "is not there", "'npwm' in its folder says how many it has",
                      err);
    (void)snprintf(name, sizeof name, "pwm%.8s", spec->line);
    folder = openat(chip, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0)
        return folder;
    r = put(chip, "export", spec->line);
    if (r == -EBUSY)
        return failed(spec, r, "is in use by the kernel itself",
                      "a fan or a backlight of the device tree holds it", err);
    if (r < 0)
        return failed(
            spec, r, "cannot be exported",
            r == -EACCES ? "who runs this must be in the group that owns its files" : NULL, err);
    folder = openat(chip, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    return folder >= 0 ? folder : failed(spec, gone(-errno), "did not appear", NULL, err);
}

/* ---- dark and lit ---- */

/* Both, whatever one of them says: some drivers leave a disabled channel as it was. */
static int darken(struct pwm_channel *channel)
{
    int duty = put(channel->folder, "duty_cycle", "0");
    int enable = put(channel->folder, "enable", "0");

    channel->permille = 0;
    return duty < 0 ? duty : enable;
}

/*
 * The kernel takes nothing at all of a channel without a period, so one that has one is made dark first and one
 * that has none is given it first.
 */
static int prepare(struct pwm_channel *channel, const struct ttf_line_spec *spec,
                   struct ttf_err *err)
{
    static const char *const IN_A_MOMENT =
        "udev gives a channel to its group a moment after it appeared: try again; if that does "
        "not help, who runs this must be in that group";
    int64_t period_ns = 0;
    char polarity[16];
    bool fresh = take_number(channel->folder, "period", &period_ns) == 0 && period_ns == 0;
    int r = fresh ? 0 : darken(channel);

    /* A driver may refuse everything as long as the period is one that its chip was left with; the end decides. */
    if (r == -EACCES || r == -ENODEV)
        return failed(spec, r, "cannot be made dark", r == -EACCES ? IN_A_MOMENT : NULL, err);
    r = put_number(channel->folder, "period", spec->period_ns);
    if (r < 0)
        return failed(spec, r, "does not take its period",
                      r == -EACCES ? IN_A_MOMENT : "another 'period': the driver refuses this one",
                      err);
    if (take(channel->folder, "polarity", polarity, sizeof polarity) == 0 &&
        strcmp(polarity, "normal") != 0 && (r = put(channel->folder, "polarity", "normal")) < 0)
        return failed(spec, r, "is of inverse polarity, and stays so", NULL, err);
    r = darken(channel);
    return r < 0 ? failed(spec, r, "cannot be made dark", NULL, err) : 0;
}

int pwm_channel_hold(const char *root, const struct ttf_line_spec *spec, struct pwm_channel *ret,
                     struct ttf_err *err)
{
    struct pwm_channel channel = {.folder = -1, .period_ns = spec->period_ns};
    int chip = open_chip(root, spec->chip);
    int r;

    if (chip < 0) {
        ttf_err_set(err, chip, spec->label, "there is no PWM chip '%s'", spec->chip);
        ttf_err_hint(err, "ls /sys/class/pwm lists them; on a Raspberry Pi an overlay makes one");
        return chip;
    }
    r = channel.folder = open_channel(spec, chip, err);
    (void)close(chip);
    if (r < 0)
        return r;
    if (flock(channel.folder, LOCK_EX | LOCK_NB) < 0)
        r = failed(spec, -EBUSY, "is held by another process", "a channel has one holder", err);
    else
        r = prepare(&channel, spec, err);
    if (r < 0) {
        pwm_channel_drop(&channel);
        return r;
    }
    *ret = channel;
    return 0;
}

int pwm_channel_set(struct pwm_channel *channel, unsigned permille)
{
    int r, dark;

    if (channel->folder < 0)
        return -ENODEV;
    if (permille == 0)
        return darken(channel);
    r = put_number(channel->folder, "duty_cycle", channel->period_ns * permille / 1000);
    if (r == 0 && channel->permille == 0)
        r = put(channel->folder, "enable", "1");
    if (r == 0) {
        channel->permille = permille;
        return 0;
    }
    dark = darken(channel);
    return dark == -ENODEV ? dark : r;
}

int pwm_channel_get(const struct pwm_channel *channel)
{
    int64_t enabled, duty;
    int r = channel->folder < 0 ? -ENODEV : take_number(channel->folder, "enable", &enabled);

    if (r == 0)
        r = take_number(channel->folder, "duty_cycle", &duty);
    return r < 0 ? r : enabled != 0 && duty > 0;
}

void pwm_channel_drop(struct pwm_channel *channel)
{
    if (channel->folder >= 0)
        (void)close(channel->folder);
    channel->folder = -1;
}
