/* SPDX-License-Identifier: Apache-2.0 */
/* cameras.c: no camera, and why. */
#include <grp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "video.h"

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

#define RIBBON                                                                       \
    "power off, then look at both ends of the ribbon cable (contacts to contacts); " \
    "camera_auto_detect=1, or the sensor's dtoverlay, stands in config.txt"

/* Of v4l2; nodes: what there is besides. */
static void none_at_all(const struct probe_machine *m, const struct probe_nodes *nodes,
                        struct probe_findings *findings)
{
    char model[96], orphan[96];
    bool pi = strncmp(probe_model(m, model), "Raspberry Pi", 12) == 0;

    if (orphan_usb_camera(m, orphan)) {
        probe_add(findings, PROBE_PROBLEM, "camera",
                  "load it: modprobe uvcvideo; if there is no such module, this kernel was built "
                  "without it",
                  "a USB camera is plugged in (%s), but its driver uvcvideo is missing", orphan);
        return;
    }
    probe_add(findings, PROBE_PROBLEM, "camera",
              pi ? RIBBON "; a USB camera is listed by lsusb"
                 : "is it plugged in, and into a port that has power? lsusb lists what is",
              "the kernel knows no camera: %s%s",
              *nodes->processors ? "each /dev/video* only processes pictures: "
                                 : "there is no /dev/video*",
              nodes->processors);
}

/* Of libcamera: what it looks for cameras in. */
static void no_pipeline(const struct probe_machine *m, const struct probe_nodes *nodes,
                        struct probe_findings *findings)
{
    char model[96];
    bool pi = strncmp(probe_model(m, model), "Raspberry Pi", 12) == 0;

    probe_add(findings, PROBE_PROBLEM, "camera",
              pi ? RIBBON "; a kernel without a driver for the camera port (Debian 12's) has none, "
                          "either"
                 : "a USB camera is better served by back-end v4l2",
              "the kernel knows no camera of libcamera's: %s%s",
              *nodes->processors ? "each /dev/media* only processes pictures: "
                                 : "there is no /dev/media*",
              nodes->processors);
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
    for (char **name = names; name && *name; name++)
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
    char **names = probe_names(machine, "dev"), called[64];
    struct probe_nodes nodes;
    bool any;

    probe_nodes_count(machine, names, "video", &nodes);
    any = nodes.n[PROBE_VIDEO_CAMERA] + nodes.n[PROBE_VIDEO_RECEIVER] > 0;
    for (char **name = names; name && *name; name++)
        if (strncmp(*name, "video", 5) == 0 &&
            probe_video_kind(machine, *name, called) != PROBE_VIDEO_PROCESSOR)
            one_device(machine, *name, findings);
    if (!any)
        none_at_all(machine, &nodes, findings);
    for (unsigned i = 0; any && i < board->n_cameras; i++)
        if (board->cameras[i].v4l2.device[0])
            missing_device(machine, board->cameras[i].v4l2.device, names, findings);
    probe_names_free(names);
}

static void libcamera_cameras(const struct probe_machine *machine, struct probe_findings *findings)
{
    char **names = probe_names(machine, "dev"), sensor[64];
    struct probe_nodes nodes;
    struct stat st;

    probe_nodes_count(machine, names, "media", &nodes);
    for (char **name = names; name && *name; name++)
        if (strncmp(*name, "media", 5) == 0)
            one_device(machine, *name, findings);
    if (nodes.n[PROBE_VIDEO_CAMERA] + nodes.n[PROBE_VIDEO_RECEIVER] == 0)
        no_pipeline(machine, &nodes, findings);
    else if (nodes.n[PROBE_VIDEO_CAMERA] == 0 && !probe_sensor(machine, sensor))
        probe_add(findings, PROBE_PROBLEM, "camera",
                  RIBBON "; it must be this very sensor's. dmesg says what failed",
                  "the camera port is on (%s), but no sensor answers behind it", nodes.receiver);
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

void probe_silent_camera(const struct probe_machine *machine, const struct ttf_board *board,
                         struct probe_findings *findings)
{
    bool libcamera = false;
    char sensor[64];

    for (unsigned i = 0; i < findings->n; i++)
        if (strcmp(findings->finding[i].about, "camera") == 0)
            return;
    for (unsigned i = 0; i < board->n_cameras; i++)
        libcamera |= strcmp(board->cameras[i].backend->name, "libcamera") == 0;
    if (!libcamera)
        return; /* v4l2 says itself what there is */
    probe_add(
        findings, PROBE_PROBLEM, "camera",
        "do its own tools see it? `rpicam-hello --list-cameras` or `cam -l` (libcamera-tools); "
        "LIBCAMERA_LOG_LEVELS=*:DEBUG before either says why not. One older than the kernel "
        "may not know its drivers",
        "the kernel has a camera%s%s, and yet libcamera does not give the one asked for",
        probe_sensor(machine, sensor) ? ": " : "", sensor);
}
