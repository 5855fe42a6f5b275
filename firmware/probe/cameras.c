/* SPDX-License-Identifier: Apache-2.0 */
/* cameras.c: no camera, and why. */
#include <grp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"

/* A USB camera without a driver: interfaces of class 0e are video. */
static bool orphan_usb_camera(const struct probe_machine *m, char ret_name[96])
{
    char **names = probe_names(m, "sys/bus/usb/devices");
    bool found = false;

    for (char **name = names; name && *name && !found; name++) {
        char path[512], text[96];
        const char *colon = strchr(*name, ':');
        struct stat st;

        (void)snprintf(path, sizeof path, "sys/bus/usb/devices/%.200s/bInterfaceClass", *name);
        if (!colon || !probe_line(m, path, text, sizeof text) || strcmp(text, "0e") != 0)
            continue;
        (void)snprintf(path, sizeof path, "sys/bus/usb/devices/%.200s/driver", *name);
        if (probe_stat(m, path, &st))
            continue;
        found = true;
        (void)snprintf(path, sizeof path, "sys/bus/usb/devices/%.*s/product", (int)(colon - *name),
                       *name);
        if (!probe_line(m, path, ret_name, 96))
            (void)snprintf(ret_name, 96, "no name");
    }
    probe_names_free(names);
    return found;
}

static void none_at_all(const struct probe_machine *m, struct probe_findings *findings)
{
    char model[96], orphan[96];

    if (orphan_usb_camera(m, orphan)) {
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "load it: modprobe uvcvideo; if there is no such module, this kernel was built "
                  "without it",
                  "a USB camera is plugged in (%s), but its driver uvcvideo is missing", orphan);
        return;
    }
    probe_model(m, model);
    if (strncmp(model, "Raspberry Pi", 12) == 0)
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "power off, then look at both ends of the ribbon cable (contacts to contacts); "
                  "camera_auto_detect=1, or the sensor's dtoverlay, stands in config.txt",
                  "the kernel knows no camera: there is no /dev/video*");
    else
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "is it plugged in, and into a port that has power? lsusb lists what is",
                  "the kernel knows no camera: there is no /dev/video*");
}

/* Of libcamera: what it looks for cameras in. */
static void no_pipeline(const struct probe_machine *m, struct probe_findings *findings)
{
    char model[96];

    probe_model(m, model);
    if (strncmp(model, "Raspberry Pi", 12) == 0)
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "power off, then look at both ends of the ribbon cable (contacts to contacts); "
                  "camera_auto_detect=1, or the sensor's dtoverlay, stands in config.txt; a kernel "
                  "without a driver for the camera port (Debian 12's) has none, either",
                  "the kernel knows no camera of libcamera's: there is no /dev/media*");
    else
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "a USB camera is better served by back-end v4l2",
                  "the kernel knows no camera of libcamera's: there is no /dev/media*");
}

static void one_device(const struct probe_machine *m, const char *name,
                       struct probe_findings *findings)
{
    char path[300], holder[64], hint[200];
    struct group *group;
    struct stat st;
    long process;

    (void)snprintf(path, sizeof path, "dev/%s", name);
    if (!probe_stat(m, path, &st))
        return;
    if (!probe_may_use(m, &st)) {
        group = getgrgid(st.st_gid); /* NOLINT(concurrency-mt-unsafe): one thread runs */
        (void)snprintf(hint, sizeof hint,
                       "join its group: usermod -aG %.60s NAME, then log in again",
                       group ? group->gr_name : "video");
        probe_add(findings, PROBE_PROBLEM, "camera", hint,
                  "/dev/%s may not be used by whoever runs this: no permission", name);
        return;
    }
    (void)snprintf(path, sizeof path, "/dev/%s", name);
    process = probe_holder(m, path, holder);
    if (process)
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "one program has a camera at a time: end that one",
                  "/dev/%s is held by %s (process %ld)", name, holder, process);
}

/* The device that a board names, but that is not there. */
static void missing_device(const struct probe_machine *m, const char *device, char **names,
                           struct probe_findings *findings)
{
    char list[160] = "";
    struct stat st;

    if (probe_stat(m, device[0] == '/' ? device + 1 : device, &st))
        return;
    for (char **name = names; *name; name++)
        if (strncmp(*name, "video", 5) == 0)
            (void)snprintf(list + strlen(list), sizeof list - strlen(list), "%s/dev/%s",
                           *list ? ", " : "", *name);
    probe_add(findings, PROBE_PROBLEM, "camera",
              "numbers change with each plugging: 'name' or 'bus', or a link below /dev/v4l/by-id, "
              "is surer",
              "%s is not there; there is %s", device, list);
}

static void v4l2_cameras(const struct probe_machine *machine, const struct ttf_board *board,
                         struct probe_findings *findings)
{
    char **names;
    bool any = false;

    names = probe_names(machine, "dev");
    for (char **name = names; name && *name; name++) {
        if (strncmp(*name, "video", 5) != 0)
            continue;
        any = true;
        one_device(machine, *name, findings);
    }
    if (!any)
        none_at_all(machine, findings);
    for (unsigned i = 0; any && i < board->n_cameras; i++)
        if (board->cameras[i].v4l2.device[0])
            missing_device(machine, board->cameras[i].v4l2.device, names, findings);
    probe_names_free(names);
}

static void libcamera_cameras(const struct probe_machine *machine, struct probe_findings *findings)
{
    char **names = probe_names(machine, "dev");
    struct stat st;
    bool any = false;

    for (char **name = names; name && *name; name++) {
        if (strncmp(*name, "media", 5) != 0)
            continue;
        any = true;
        one_device(machine, *name, findings);
    }
    if (!any)
        no_pipeline(machine, findings);
    else if (!probe_stat(machine, "run/udev/data", &st))
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "start it: systemctl start systemd-udevd systemd-udev-trigger",
                  "libcamera is told of cameras by udev, which does not run here");
    probe_names_free(names);
}

void probe_cameras(const struct probe_machine *machine, const struct ttf_board *board,
                   struct probe_findings *findings)
{
    bool v4l2 = false, libcamera = false;

    for (unsigned i = 0; i < board->n_cameras; i++) {
        v4l2 |= strcmp(board->cameras[i].backend->name, "v4l2") == 0;
        libcamera |= strcmp(board->cameras[i].backend->name, "libcamera") == 0;
    }
    if (v4l2)
        v4l2_cameras(machine, board, findings);
    if (libcamera)
        libcamera_cameras(machine, findings);
}
