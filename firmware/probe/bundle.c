/* SPDX-License-Identifier: Apache-2.0 */
/*
 * bundle.c: an archive to attach to a report. What goes in is a list of what is known to hold no secrets, never a
 * folder: no networks, names of people, keys, passwords, addresses, environment, and of mounts only what and where.
 */
#include <archive.h>
#include <archive_entry.h>
#include <errno.h>
#include <mntent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"

#define FILE_MOST (256 << 10)

static const struct {
    const char *path, *about;
} FILES[] = {
    {"proc/version", "the kernel"},
    {"proc/device-tree/model", "the machine"},
    {"proc/device-tree/hat/product", "a HAT that is plugged on"},
    {"proc/modules", "drivers that are loaded"},
    {"proc/meminfo", "memory"},
    {"etc/os-release", "the system"},
    {"sys/kernel/debug/gpio", "lines and who has them"},
};

/* Names in these folders. */
static const char *const FOLDERS[] = {"dev",
                                      "sys/class/video4linux",
                                      "sys/class/gpio",
                                      "sys/class/hwmon",
                                      "sys/bus/iio/devices",
                                      "sys/class/rtc",
                                      "sys/class/udc",
                                      "sys/class/watchdog",
                                      "sys/kernel/config/usb_gadget"};

/* A text that grows. */
struct text {
    char *bytes;
    size_t n, room;
};

static int add_text(struct text *text, const char *bytes, size_t n)
{
    if (text->n + n + 1 > text->room) {
        size_t room = (text->n + n + 1) * 2;
        char *grown = realloc(text->bytes, room);

        if (!grown)
            return -ENOMEM;
        text->bytes = grown;
        text->room = room;
    }
    memcpy(text->bytes + text->n, bytes, n);
    text->n += n;
    text->bytes[text->n] = '\0';
    return 0;
}

static int add_line(struct text *text, const char *a, const char *b, const char *c)
{
    char line[1024];
    int n = snprintf(line, sizeof line, "%s%s%s\n", a, b, c);

    return add_text(text, line, (size_t)n < sizeof line ? (size_t)n : sizeof line - 1);
}

static int put(struct archive *archive, const char *name, const char *bytes, size_t n,
               struct ttf_err *err)
{
    struct archive_entry *entry = archive_entry_new();
    char member[300];
    int r = 0;

    if (!entry)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)snprintf(member, sizeof member, "ttfbox-report/%s", name);
    archive_entry_set_pathname(entry, member);
    archive_entry_set_size(entry, (la_int64_t)n);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    if (archive_write_header(archive, entry) != ARCHIVE_OK ||
        archive_write_data(archive, bytes, n) != (la_ssize_t)n)
        r = ttf_err_set(err, -EIO, name, "cannot be put into the bundle: %s",
                        archive_error_string(archive));
    archive_entry_free(entry);
    return r;
}

/* A file that is not there is no error: machines differ. */
static int put_file(struct archive *archive, const char *from, const char *name,
                    struct ttf_err *err)
{
    char *bytes = malloc(FILE_MOST);
    FILE *file = fopen(from, "re");
    size_t n = file && bytes ? fread(bytes, 1, FILE_MOST, file) : 0;
    int r = file && bytes ? put(archive, name, bytes, n, err) : 0;

    if (file)
        (void)fclose(file);
    free(bytes);
    return r;
}

static int put_folders(const struct probe_machine *m, struct archive *archive, struct ttf_err *err)
{
    struct text text = {0};
    int r = 0;

    for (unsigned i = 0; i < TTF_COUNT_OF(FOLDERS) && r == 0; i++) {
        char **names = probe_names(m, FOLDERS[i]);

        r = add_line(&text, FOLDERS[i], "/", "");
        for (char **name = names; name && *name && r == 0; name++)
            r = add_line(&text, "    ", *name, "");
        probe_names_free(names);
    }
    r = r < 0 ? ttf_err_set(err, r, NULL, "no memory")
              : put(archive, "devices.txt", text.bytes, text.n, err);
    free(text.bytes);
    return r;
}

/* What and where; a network's share names its server and, at times, its user: "nfs" has to do. */
static int put_mounts(const struct probe_machine *m, struct archive *archive, struct ttf_err *err)
{
    char path[512], room[1024];
    FILE *file = setmntent(probe_path(m, "proc/self/mounts", path), "re");
    struct text text = {0};
    struct mntent e;
    int r = 0;

    while (file && r == 0 && getmntent_r(file, &e, room, sizeof room)) {
        bool local = strncmp(e.mnt_fsname, "/dev/", 5) == 0;
        char line[400];

        (void)snprintf(line, sizeof line, "%.120s %.40s %s", local ? e.mnt_dir : "-", e.mnt_type,
                       hasmntopt(&e, "ro") ? "ro" : "rw");
        r = add_line(&text, local ? e.mnt_fsname : "-", " ", line);
    }
    if (file)
        (void)endmntent(file);
    r = r < 0 ? ttf_err_set(err, r, NULL, "no memory")
              : put(archive, "mounts.txt", text.bytes ? text.bytes : "", text.n, err);
    free(text.bytes);
    return r;
}

static int put_index(struct archive *archive, struct ttf_err *err)
{
    struct text text = {0};
    int r = add_line(&text,
                     "What 'ttfbox board probe' saw (report.json), the board's file, and:", "", "");

    for (unsigned i = 0; i < TTF_COUNT_OF(FILES) && r == 0; i++)
        r = add_line(&text, FILES[i].path, ": ", FILES[i].about);
    if (r == 0)
        r = add_line(&text, "devices.txt: which devices there are, by name\n",
                     "mounts.txt: file systems of local disks, where, and whether they can be "
                     "written\n\n",
                     "Nothing else is in here: look for yourself before you send it.");
    r = r < 0 ? ttf_err_set(err, r, NULL, "no memory")
              : put(archive, "BUNDLE.txt", text.bytes, text.n, err);
    free(text.bytes);
    return r;
}

static int put_all(const struct probe_machine *m, struct archive *archive, const char *board_path,
                   const char *report, struct ttf_err *err)
{
    int r = put_index(archive, err);

    if (r == 0)
        r = put(archive, "report.json", report, strlen(report), err);
    if (r == 0)
        r = put_file(archive, board_path, "board.yaml", err);
    for (unsigned i = 0; i < TTF_COUNT_OF(FILES) && r == 0; i++) {
        char path[512];

        r = put_file(archive, probe_path(m, FILES[i].path, path), FILES[i].path, err);
    }
    if (r == 0)
        r = put_mounts(m, archive, err);
    return r == 0 ? put_folders(m, archive, err) : r;
}

int probe_bundle(const struct probe_machine *machine, const char *path, const char *board_path,
                 const char *report, struct ttf_err *err)
{
    struct archive *archive;
    int r;

    if (access(path, F_OK) == 0) {
        ttf_err_set(err, -EEXIST, path, "exists already");
        ttf_err_hint(err, "nothing is overwritten: give another name");
        return -EEXIST;
    }
    archive = archive_write_new();
    if (!archive)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)archive_write_add_filter_gzip(archive);
    (void)archive_write_set_format_pax_restricted(archive);
    r = archive_write_open_filename(archive, path) == ARCHIVE_OK
            ? put_all(machine, archive, board_path, report, err)
            : ttf_err_set(err, -EIO, path, "cannot be written: %s", archive_error_string(archive));
    if (archive_write_close(archive) != ARCHIVE_OK && r == 0)
        r = ttf_err_set(err, -EIO, path, "cannot be written: %s", archive_error_string(archive));
    (void)archive_write_free(archive);
    if (r < 0)
        (void)unlink(path);
    return r;
}
