/* SPDX-License-Identifier: Apache-2.0 */
/* video.h: what the kernel's video and media nodes are, by the names that their drivers gave them. */
#ifndef FIRMWARE_PROBE_VIDEO_H
#define FIRMWARE_PROBE_VIDEO_H

#include "probe.h"

enum probe_video {
    PROBE_VIDEO_CAMERA = 0, /* or of a driver that is not known here */
    PROBE_VIDEO_RECEIVER, /* of a Raspberry Pi's camera port: a camera if a sensor answers behind it */
    PROBE_VIDEO_PROCESSOR /* codec or image processor: there with and without a camera */
};

struct probe_nodes {
    unsigned n[3];        /* of each enum probe_video */
    char processors[120]; /* their names, "bcm2835-codec-decode, ...", as many as fit */
    char receiver[40];
};

/* Of a node in /dev, "video0" or "media0". ret_name: what its driver calls it; "" if that is not told. */
enum probe_video probe_video_kind(const struct probe_machine *machine, const char *node,
                                  char ret_name[64]);

/* All that begin with `prefix` ("video", "media"). */
void probe_nodes_count(const struct probe_machine *machine, char **names, const char *prefix,
                       struct probe_nodes *ret);

/* The sensor behind a camera port, "imx477 10-001a"; false: none answers. */
bool probe_sensor(const struct probe_machine *machine, char ret_name[64]);

#endif
