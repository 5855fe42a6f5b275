/* SPDX-License-Identifier: Apache-2.0 */
/*
 * video.c: a Raspberry Pi has video and media nodes without any camera: those of its codecs and image processors. So
 * what counts is what a node is called. Names: of the drivers in Raspberry Pi's kernel, bcm2835-codec, bcm2835-isp,
 * pispbe, rpi-hevc-dec (before 6.12 rpivid), bcm2835-unicam and rp1-cfe. The last two register their video nodes when
 * a sensor has answered, their media device before that.
 */
#include "video.h"

#include <stdio.h>
#include <string.h>

#include "files.h"

static bool begins_with_any(const char *text, const char *const *beginnings)
{
    for (; *beginnings; beginnings++)
        if (strncmp(text, *beginnings, strlen(*beginnings)) == 0)
            return true;
    return false;
}

enum probe_video probe_video_kind(const struct probe_machine *machine, const char *node,
                                  char ret_name[64])
{
    static const char *const PROCESSORS[] = {"bcm2835-codec", "bcm2835-isp", "pispbe", "pisp_be",
                                             "rpi-hevc-dec",  "rpivid",      NULL};
    static const char *const RECEIVERS[] = {"unicam", "rp1-cfe", NULL};
    bool media = strncmp(node, "media", 5) == 0;
    char path[320];

    (void)snprintf(
        path, sizeof path,
        media ? "sys/bus/media/devices/%.200s/model" : "sys/class/video4linux/%.200s/name", node);
    (void)probe_line(machine, path, ret_name, 64);
    if (begins_with_any(ret_name, PROCESSORS))
        return PROBE_VIDEO_PROCESSOR;
    return begins_with_any(ret_name, RECEIVERS) ? PROBE_VIDEO_RECEIVER : PROBE_VIDEO_CAMERA;
}

/* One node of many is named: an image processor has a dozen. */
static void add_name(char *list, size_t size, const char *name)
{
    size_t used = strlen(list);
    int n =
        strstr(list, name) ? 0 : snprintf(list + used, size - used, "%s%s", used ? ", " : "", name);

    if (n < 0 || (size_t)n >= size - used)
        list[used] = '\0'; /* only whole ones */
}

void probe_nodes_count(const struct probe_machine *machine, char **names, const char *prefix,
                       struct probe_nodes *ret)
{
    memset(ret, 0, sizeof *ret);
    for (char **name = names; name && *name; name++) {
        char called[64];
        enum probe_video kind;

        if (strncmp(*name, prefix, strlen(prefix)) != 0)
            continue;
        kind = probe_video_kind(machine, *name, called);
        ret->n[kind]++;
        if (kind == PROBE_VIDEO_PROCESSOR)
            add_name(ret->processors, sizeof ret->processors, called);
        if (kind == PROBE_VIDEO_RECEIVER)
            (void)snprintf(ret->receiver, sizeof ret->receiver, "%.39s", called);
    }
}

bool probe_sensor(const struct probe_machine *machine, char ret_name[64])
{
    /* Subdevices that are the receiver's own, or an image processor's. */
    static const char *const OTHERS[] = {"csi2",        "pisp-fe", "unicam",  "bcm2835-isp",
                                         "bcm2835_isp", "pispbe",  "pisp_be", NULL};
    char **names = probe_names(machine, "sys/class/video4linux");
    bool found = false;

    *ret_name = '\0';
    for (char **name = names; name && *name && !found; name++) {
        char path[320];

        (void)snprintf(path, sizeof path, "sys/class/video4linux/%.200s/name", *name);
        if (strncmp(*name, "v4l-subdev", 10) == 0 && probe_line(machine, path, ret_name, 64))
            found = !begins_with_any(ret_name, OTHERS);
        else if (strncmp(*name, "video", 5) == 0)
            found = probe_video_kind(machine, *name, ret_name) == PROBE_VIDEO_RECEIVER;
    }
    probe_names_free(names);
    return found;
}
