/* SPDX-License-Identifier: Apache-2.0 */
/* machine.c: clock, storage, supply, watchdog. */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <mntent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"
#include "ttf/base/time.h"

#define DATED_S     1704067200 /* 2024, as hal/real has it: no ttfbox is that old */
#define SPEED_BYTES (8 << 20)
#define SPEED_LEAST (10 * 1000 * 1000) /* bytes a second: a raw frame of 12 megapixels every 2 s */

const char *probe_model(const struct probe_machine *machine, char ret[96])
{
    if (!probe_line(machine, "proc/device-tree/model", ret, 96))
        (void)probe_line(machine, "sys/class/dmi/id/product_name", ret, 96);
    return ret;
}

void probe_is_meant(const struct probe_machine *machine, const struct ttf_board *board,
                    struct probe_findings *findings)
{
    char model[96];

    if (!*board->machine.model || strncmp(probe_model(machine, model), board->machine.model,
                                          strlen(board->machine.model)) == 0)
        return;
    probe_add(findings, PROBE_PROBLEM, "machine", "is it the right --board?",
              "the board '%s' is for a %s; this is %s", board->name, board->machine.model,
              *model ? model : "a machine without a name");
}

struct rtc {
    char name[96]; /* "rtc0 (rtc-ds1307 1-0068)" */
    bool sets;     /* the kernel set its time by it at boot */
    bool dated;    /* it knows a date itself */
};

static struct rtc look_at_rtc(const struct probe_machine *m, const char *name)
{
    char path[320], driver[64], text[32];
    struct rtc rtc = {0};

    (void)snprintf(path, sizeof path, "sys/class/rtc/%.64s/name", name);
    (void)probe_line(m, path, driver, sizeof driver);
    (void)snprintf(rtc.name, sizeof rtc.name, "%.16s (%.60s)", name, *driver ? driver : "no name");
    (void)snprintf(path, sizeof path, "sys/class/rtc/%.64s/hctosys", name);
    rtc.sets = probe_line(m, path, text, sizeof text) && strcmp(text, "1") == 0;
    (void)snprintf(path, sizeof path, "sys/class/rtc/%.64s/since_epoch", name);
    rtc.dated = probe_line(m, path, text, sizeof text) && strtoll(text, NULL, 10) >= DATED_S;
    return rtc;
}

#define FIRST                                                                                \
    "the kernel asks the first alone (rtc0): on a Raspberry Pi 5, whose own has no battery " \
    "unless one was bought, dtparam=rtc=off in config.txt lets another be the first"

/* Of all battery-backed clocks the one that set the time, and whether it knows it. */
static void look_at_rtcs(const struct probe_machine *m, char **names,
                         struct probe_findings *findings)
{
    struct rtc setter = {0}, other = {0};

    for (char **name = names; *name; name++) {
        struct rtc rtc = look_at_rtc(m, *name);

        if (rtc.sets && !setter.sets)
            setter = rtc;
        else
            other = rtc;
    }
    if (!setter.sets)
        probe_add(findings, PROBE_NOTE, "clock", FIRST,
                  "%s is there, but did not set this machine's time at boot", other.name);
    else if (!setter.dated)
        probe_add(findings, PROBE_NOTE, "clock",
                  *other.name ? FIRST : "put a battery in, or a new one; then set it: hwclock -w",
                  "the clock %s has lost its date: it has no battery, or an empty one%s%s",
                  setter.name, *other.name ? "; and nobody asks " : "", other.name);
    else if (*other.name)
        probe_add(findings, PROBE_NOTE, "clock", FIRST,
                  "of two clocks it is %s that sets the time at boot, not %s", setter.name,
                  other.name);
}

void probe_clock(const struct probe_machine *machine, enum ttf_trust trust,
                 struct probe_findings *findings)
{
    char **names = probe_names(machine, "sys/class/rtc");

    if (names && *names)
        look_at_rtcs(machine, names, findings);
    else
        probe_add(
            findings, PROBE_NOTE, "clock",
            "a DS3231 module keeps the time for years; without, the time must come by network",
            "no battery-backed clock: after a power cut this machine does not know how long it "
            "was off, and a capture goes on at once in a new segment with an unknown gap");
    probe_names_free(names);
    if (trust == TTF_TRUST_NONE)
        probe_add(findings, PROBE_NOTE, "clock",
                  "connect it to a network with a time server (timedatectl says if it is in step)",
                  "nobody vouches for this machine's date: a plan's 'start' is not checked against "
                  "it, and a capture's times are marked as unsure");
}

/* The mount that a folder lies in. */
static bool find_mount(const struct probe_machine *m, const char *folder, struct mntent *ret,
                       char buf[1024])
{
    char path[512], room[1024];
    FILE *file = setmntent(probe_path(m, "proc/self/mounts", path), "re");
    struct mntent entry;
    size_t best = 0;

    if (!file)
        return false;
    while (getmntent_r(file, &entry, room, sizeof room)) {
        size_t n = strlen(entry.mnt_dir);
        bool root = strcmp(entry.mnt_dir, "/") == 0;

        if (n < best || strncmp(folder, entry.mnt_dir, n) != 0 ||
            (!root && folder[n] != '/' && folder[n] != '\0'))
            continue;
        best = n;
        memcpy(buf, room, sizeof room);
        *ret = entry;
        ret->mnt_fsname = buf + (entry.mnt_fsname - room);
        ret->mnt_dir = buf + (entry.mnt_dir - room);
        ret->mnt_type = buf + (entry.mnt_type - room);
        ret->mnt_opts = buf + (entry.mnt_opts - room);
    }
    (void)endmntent(file);
    return best > 0;
}

static bool is_one_of(const char *word, const char *const *words)
{
    for (; *words; words++)
        if (strcmp(word, *words) == 0)
            return true;
    return false;
}

void probe_storage(const struct probe_machine *machine, const char *folder,
                   struct probe_findings *findings)
{
    static const char *const FORGETFUL[] = {"tmpfs", "ramfs", NULL};
    static const char *const UNSAFE[] = {"vfat", "exfat", "ntfs", "ntfs3", "fuseblk", NULL};
    struct mntent mount;
    char buf[1024];

    if (!find_mount(machine, folder, &mount, buf))
        return;
    if (hasmntopt(&mount, "ro"))
        probe_add(findings, PROBE_PROBLEM, "storage",
                  "after a fault a file system turns read-only: look at dmesg, check it with fsck",
                  "%s (%s) can only be read", mount.mnt_dir, mount.mnt_type);
    if (is_one_of(mount.mnt_type, FORGETFUL))
        probe_add(findings, PROBE_PROBLEM, "storage", "name a folder on a disk",
                  "%s lies in memory (%s): a power cut loses everything", mount.mnt_dir,
                  mount.mnt_type);
    else if (is_one_of(mount.mnt_type, UNSAFE))
        probe_add(findings, PROBE_PROBLEM, "storage", "make it ext4, or f2fs on a card",
                  "%s is %s, which a power cut may leave broken beyond what ttfbox can mend",
                  mount.mnt_dir, mount.mnt_type);
    if (strncmp(mount.mnt_fsname, "/dev/mmcblk", 11) == 0)
        probe_add(
            findings, PROBE_NOTE, "storage",
            "for weeks of frames a USB disk of its own lasts longer; 'storage.second' of a plan "
            "names one to go on with",
            "%s lies on a memory card (%s)", mount.mnt_dir, mount.mnt_fsname);
}

void probe_fs_errors(const struct probe_machine *machine, struct probe_findings *findings)
{
    char **devices = probe_names(machine, "sys/fs/ext4");

    for (char **device = devices; device && *device; device++) {
        char path[384], text[32];

        (void)snprintf(path, sizeof path, "sys/fs/ext4/%.200s/errors_count", *device);
        if (!probe_line(machine, path, text, sizeof text) || strtol(text, NULL, 10) <= 0)
            continue;
        probe_add(
            findings, PROBE_PROBLEM, "storage",
            "dmesg says which; copy what matters, then check it unmounted (fsck -f). A card or "
            "disk that wears out does this, a supply that sags, too",
            "the file system on %.60s has found errors in itself: %s since it was last checked",
            *device, text);
    }
    probe_names_free(devices);
}

static int write_and_sync(int fd)
{
    static const char block[1 << 16];

    for (int64_t done = 0; done < SPEED_BYTES; done += (int64_t)sizeof block)
        if (write(fd, block, sizeof block) != (ssize_t)sizeof block)
            return errno ? -errno : -EIO;
    return fsync(fd) < 0 ? -errno : 0;
}

int64_t probe_write_speed(const char *folder, struct ttf_clock *clock,
                          struct probe_findings *findings)
{
    char path[512];
    int64_t begun_ns = ttf_clock_now_ns(clock), took_ns, speed;
    int fd, r;

    (void)snprintf(path, sizeof path, "%.480s/.ttfbox-speed", folder);
    fd = open(path, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
    r = fd < 0 ? -errno : write_and_sync(fd);
    if (fd >= 0) {
        (void)close(fd);
        (void)unlink(path);
    }
    if (r < 0) {
        probe_add(findings, PROBE_PROBLEM, "storage", NULL, "%.150s cannot be written: %s", folder,
                  strerrordesc_np(-r));
        return r;
    }
    took_ns = ttf_clock_now_ns(clock) - begun_ns;
    speed = (int64_t)((double)SPEED_BYTES / ((double)(took_ns > 0 ? took_ns : 1) / 1e9));
    if (speed < SPEED_LEAST)
        probe_add(findings, PROBE_PROBLEM, "storage",
                  "'ttfbox plan check PLAN -o FOLDER' says which interval it sustains",
                  "%.150s takes %.1f MB/s only: slow storage makes slots be missed", folder,
                  (double)speed / 1e6);
    return speed;
}

/* The Pi's voltage monitor shows as a hwmon of this name. */
static void look_at_voltage(const struct probe_machine *m, struct probe_findings *findings)
{
    char **names = probe_names(m, "sys/class/hwmon");

    for (char **name = names; name && *name; name++) {
        char path[384], text[32];

        (void)snprintf(path, sizeof path, "sys/class/hwmon/%.200s/name", *name);
        if (!probe_line(m, path, text, sizeof text) || strcmp(text, "rpi_volt") != 0)
            continue;
        (void)snprintf(path, sizeof path, "sys/class/hwmon/%.200s/in0_lcrit_alarm", *name);
        if (probe_line(m, path, text, sizeof text) && strcmp(text, "1") == 0)
            probe_add(
                findings, PROBE_PROBLEM, "power",
                "a supply of 5.1 V and 3 A (Pi 5: 5 A), and a short thick cable",
                "the supply's voltage has been too low: cards and cameras fail of that first");
    }
    probe_names_free(names);
}

void probe_power(const struct probe_machine *machine, const struct ttf_board *board,
                 struct probe_findings *findings)
{
    const struct ttf_backend_entry *watchdog = board->device[TTF_DEVICE_WATCHDOG];
    char holder[64];
    long process;

    look_at_voltage(machine, findings);
    if (!watchdog || strcmp(watchdog->name, "device") != 0)
        return;
    process = probe_holder(machine, board->watchdog_path, holder);
    if (process)
        probe_add(findings, PROBE_PROBLEM, "watchdog",
                  "if that is systemd (RuntimeWatchdogSec), let the board say backend: systemd",
                  "%s is held by %s (process %ld)", board->watchdog_path, holder, process);
}
