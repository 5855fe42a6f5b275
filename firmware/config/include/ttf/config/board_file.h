/* SPDX-License-Identifier: Apache-2.0 */
/*
 * board_file.h: a board's description from YAML: which back-end drives each
 * device, with which parameters. The language: firmware/config/README.md.
 */
#ifndef TTF_CONFIG_BOARD_FILE_H
#define TTF_CONFIG_BOARD_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/box.h"
#include "ttf/hal/libcamera.h"
#include "ttf/hal/lines.h"
#include "ttf/hal/sim.h"
#include "ttf/hal/sysfs.h"
#include "ttf/hal/v4l2.h"

/* Who owns a box with real devices, unless its board names another file. */
#define TTF_BOARD_LOCK "/run/ttfbox/box.lock"

/* The kinds of device that a back-end may drive. */
enum ttf_device_kind {
    TTF_DEVICE_CAMERA = 0,
    TTF_DEVICE_CLOCK,
    TTF_DEVICE_LAMPS,
    TTF_DEVICE_SENSORS,
    TTF_DEVICE_PANEL,
    TTF_DEVICE_WATCHDOG,
    TTF_DEVICE_KIND_COUNT
};

/* Back-ends by name: one line each in registry.c. */
struct ttf_backend_entry {
    const char *name;  /* as a board writes it */
    unsigned devices;  /* bit per enum ttf_device_kind */
    const char *about; /* a line for people */
};

/* The i-th entry, or NULL; and by name, NULL if there is none. */
const struct ttf_backend_entry *ttf_backend_entry(unsigned i);
const struct ttf_backend_entry *ttf_backend_find(const char *name);

/* What the simulated camera looks at. Exactly one of name, images, dataset is set. */
struct ttf_board_scene {
    char name[32];     /* procedural; "white" is an even target */
    char images[512];  /* a folder of pictures, in natural order of their names */
    char dataset[512]; /* a TTF dataset */
    int64_t span_ns;   /* the time from its first to its last state */
};

struct ttf_board_camera {
    char name[32];
    const struct ttf_backend_entry *backend;
    struct ttf_camera_mode mode;           /* asked for; 0: native */
    struct ttf_v4l2_config v4l2;           /* of that back-end */
    struct ttf_libcamera_config libcamera; /* of that one */
};

/* What the lamp guardian of a real box needs: ttfbox-lampd reads it, and its clients where to find it. */
struct ttf_board_guardian {
    char socket[108];
    char file[512];   /* of lamps with back-end "file": where the wires are */
    unsigned n_wires; /* the lamps' outputs in their order, then the door's input if there is one */
    struct ttf_line_spec wires[TTF_LINES_MAX];
    int door; /* index of its wire; -1: no door switch */
    char temp_sensor
        [32]; /* whose temperature lamps with max_temp are watched by; empty: the first */
};

/* A panel on wires. */
struct ttf_board_panel {
    char file[512];   /* of back-end "file": where the wires are */
    unsigned n_wires; /* 0: the door alone, which is the guardian's */
    struct ttf_line_spec wires[2];
    int button, led; /* indices of wires; -1: none */
};

enum ttf_header_kind {
    TTF_HEADER_NONE = 0,
    TTF_HEADER_RASPBERRY_PI
};

/* Of the port that may be either. */
enum ttf_usb_role {
    TTF_USB_NONE = 0,
    TTF_USB_HOST,
    TTF_USB_DEVICE
};

/* By what the computer is fed. */
enum ttf_power_input {
    TTF_POWER_UNSAID = 0,
    TTF_POWER_USB,    /* the port that usb_role is of */
    TTF_POWER_HEADER, /* 5 V at its pin header */
    TTF_POWER_POE,
    TTF_POWER_SOCKET /* one of its own */
};

#define TTF_USB_DEVICES_MAX 8

/* What the computer in the box is. */
struct ttf_board_machine {
    char model[64]; /* how its own name for itself begins; empty: any */
    int header;     /* enum ttf_header_kind */
    int usb_role;   /* enum ttf_usb_role */
    bool usb_single, usb_powers;
    int power; /* enum ttf_power_input */
    /* What is plugged into its USB ports: cameras and chips by their names, "disk", "network". */
    unsigned n_usb_devices;
    char usb_devices[TTF_USB_DEVICES_MAX][64];
};

/* Services of a box (firmware/units/), and functions of its gadget (firmware/gadget/): bits. */
enum ttf_board_unit_bit {
    TTF_UNIT_LAMPD = 1,
    TTF_UNIT_DAEMON = 2,
    TTF_UNIT_PREVIEW = 4,
    TTF_UNIT_ALERTS = 8,
    TTF_UNIT_GADGET = 16,
    TTF_UNIT_CABLE = 32
};
enum ttf_gadget_function_bit {
    TTF_GADGET_STREAMS = 1,
    TTF_GADGET_NETWORK = 2
};

/* Lines of a header that are something else, too. */
struct ttf_header_use {
    int first, last;
    const char *what;
    const char *
        uses; /* a file that is there while the line is in use so, without its first slash; NULL: always */
};

/* Of a Raspberry Pi's header; NULL: a free line, or none of the header. Constant. */
const struct ttf_header_use *ttf_board_header_use(const struct ttf_line_spec *wire);

struct ttf_board {
    char path[512]; /* of the file */
    char name[64];
    char title[128];
    char serial[64];
    unsigned n_cameras;
    struct ttf_board_camera cameras[TTF_BOX_CAMERAS_MAX];
    const struct ttf_backend_entry *device[TTF_DEVICE_KIND_COUNT]; /* NULL: the board has none */
    /* Facts of lamps and sensors lie in sim.lamps[].info and sim.sensors[], whatever drives them. */
    struct ttf_board_guardian guardian;
    struct ttf_board_panel panel; /* of other back-ends than "sim" */
    struct ttf_board_machine machine;
    unsigned units,
        gadget; /* what an image of it runs, what it is on the bus; 0: it does not say */
    char watchdog_path[64]; /* of back-end "device" */
    char lock[512];         /* the file that says who owns the box; empty: nobody asks */
    unsigned n_sysfs;
    struct ttf_sysfs_sensor sysfs[TTF_SENSORS_MAX];
    bool simulated; /* some device is: then sim and scene hold, and all that it yields says so */
    bool real;      /* some device is real (its clock apart) */
    struct ttf_sim_config sim;
    struct ttf_board_scene scene;
};

/* An override from a command line: `path` of keys ("sim.optics.blur") and its value's YAML. */
struct ttf_board_set {
    const char *path, *value;
};

/* The i-th service that the board names, without ".service"; the i-th function of its gadget. NULL: no more. */
const char *ttf_board_unit(const struct ttf_board *board, unsigned i);
const char *ttf_board_function(const struct ttf_board *board, unsigned i);

/*
 * Where the board called `name` lies: a path to a file or folder as it is, else
 * NAME/board.yaml below the first of the folders (NULL-ended) that has it.
 * -ENOENT naming what was tried.
 */
TTF_MUST_USE int ttf_board_locate(const char *name, const char *const *folders, char *ret_path,
                                  size_t size, struct ttf_err *err);

/* Reads, applies the overrides, decodes. Errors as ttf_plan_file_load. */
TTF_MUST_USE int ttf_board_load(const char *path, const struct ttf_board_set *sets, unsigned n_sets,
                                struct ttf_board *ret, struct ttf_err *err);
TTF_MUST_USE int ttf_board_parse(const char *name, const char *text, size_t bytes,
                                 const struct ttf_board_set *sets, unsigned n_sets,
                                 struct ttf_board *ret, struct ttf_err *err);

#endif
