/* SPDX-License-Identifier: Apache-2.0 */
/*
 * probe.h: what is wrong with a box, in words for whoever built it. Looks at the machine's files (/sys, /dev, /proc),
 * and asks the kernel who has its GPIO lines; asks no device and changes nothing. The folder is a parameter.
 */
#ifndef FIRMWARE_PROBE_H
#define FIRMWARE_PROBE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/config/board_file.h"
#include "ttf/hal/clock.h"

#define PROBE_GROUPS_MAX   64
#define PROBE_FINDINGS_MAX 64

/* Where to look, and as whom. */
struct probe_machine {
    char root[256]; /* "": this machine; else a folder with sys, dev and proc in it */
    uid_t uid;
    unsigned n_groups;
    gid_t groups[PROBE_GROUPS_MAX];
    /*
     * Who holds a line, as ttf_lines_gpiod_holder (hal/gpiod.h); NULL: the kernel is not asked, as of another
     * machine's files.
     */
    int (*line_holder)(const struct ttf_line_spec *spec, char ret_holder[64], struct ttf_err *err);
};

/* This process, on this machine or on what lies below root. */
void probe_machine_here(struct probe_machine *machine, const char *root);

enum probe_weight {
    PROBE_NOTE = 0, /* good to know */
    PROBE_PROBLEM   /* a capture will not do, or not do well */
};

struct probe_finding {
    enum probe_weight weight;
    char about[32]; /* "camera", "line left", "storage" */
    char text[256]; /* a sentence without a full stop */
    char hint[256]; /* what to do; may be empty */
};

struct probe_findings {
    unsigned n;
    struct probe_finding finding[PROBE_FINDINGS_MAX]; /* beyond that they are dropped */
};

/* hint: may be NULL. */
void probe_add(struct probe_findings *findings, enum probe_weight weight, const char *about,
               const char *hint, const char *fmt, ...) TTF_PRINTF(5, 6);

/* Cameras of back-ends v4l2 and libcamera: none and why, another one than meant, not allowed, in somebody's hands. */
void probe_cameras(const struct probe_machine *machine, const struct ttf_board *board,
                   struct probe_findings *findings);

/* A camera of libcamera's does not answer: if nothing else is said of cameras, that and where to look on. */
void probe_silent_camera(const struct probe_machine *machine, const struct ttf_board *board,
                         struct probe_findings *findings);

/* Wires of lamps, door, button and light: of what else they are on this machine, who has them, hats. */
void probe_lines(const struct probe_machine *machine, const struct ttf_board *board,
                 struct probe_findings *findings);

/* Who holds the USB device controller, and whether that is what the board's machine.usb_role wants. */
void probe_usb(const struct probe_machine *machine, const struct ttf_board *board,
               struct probe_findings *findings);

/* Another machine than the board is for. */
void probe_is_meant(const struct probe_machine *machine, const struct ttf_board *board,
                    struct probe_findings *findings);

/* A clock that forgets, a date that nobody vouches for. */
void probe_clock(const struct probe_machine *machine, enum ttf_trust trust,
                 struct probe_findings *findings);

/* File systems that have found errors in themselves: a card that wears out. */
void probe_fs_errors(const struct probe_machine *machine, struct probe_findings *findings);

/* The disk below a folder, by the machine's mounts. */
void probe_storage(const struct probe_machine *machine, const char *folder,
                   struct probe_findings *findings);

/* How fast the disk below that folder takes and syncs 8 MiB, a file that is removed again. Bytes a second; errors of the disk. */
TTF_MUST_USE int64_t probe_write_speed(const char *folder, struct ttf_clock *clock,
                                       struct probe_findings *findings);

/* A supply that sags, a watchdog that another holds. */
void probe_power(const struct probe_machine *machine, const struct ttf_board *board,
                 struct probe_findings *findings);

/* What the machine calls itself, as "Raspberry Pi 4 Model B Rev 1.4"; "" if it does not say. Returns ret. */
const char *probe_model(const struct probe_machine *machine, char ret[96]);

/*
 * An archive (tar.gz) to attach to a report: `report` (JSON, as probe prints it), the board's file, and facts of the
 * machine that hold no secrets; BUNDLE.txt in it says what each is. Nothing is overwritten: -EEXIST.
 */
TTF_MUST_USE int probe_bundle(const struct probe_machine *machine, const char *path,
                              const char *board_path, const char *report, struct ttf_err *err);

#endif
