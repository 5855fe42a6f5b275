/* SPDX-License-Identifier: Apache-2.0 */
/*
 * boundary.h: what is asked of libcamera, as a table in plain C. The module ttfbox-libcamera.so has one that stands on
 * libcamera itself, tests have one of their own. No policy is behind it: it translates.
 * Private to hal/libcamera.
 *
 * A process without memory ends in the module (libcamera itself and C++ have no other way out: what they throw meets
 * noexcept), as it does where libcamera's own assertions fail. So it is a process of its own (host.c, remote.h): the camera is lost
 * with it, is found again by another, and the run goes on.
 *
 * All functions return a negative errno on failure. One thread calls them, but for queue and take, which any may.
 */
#ifndef TTF_HAL_LIBCAMERA_BOUNDARY_H
#define TTF_HAL_LIBCAMERA_BOUNDARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Grows with any change below: a module of another one is not used. */
#define LC_ABI 2u

/* Which stream: as the sensor gives it, or as the image processor makes it. */
enum lc_role {
    LC_RAW = 0,
    LC_PROCESSED
};

/* Controls by their meaning. Numbers are libcamera's units, exact in a double. */
enum lc_control {
    LC_EXPOSURE = 0,   /* us */
    LC_GAIN,           /* analogue, 1 = unity */
    LC_COLOUR_GAINS,   /* two: red, blue */
    LC_LENS,           /* dioptres */
    LC_FRAME_DURATION, /* us; asked as the least and the most, told as one */
    LC_DIGITAL_GAIN,
    LC_AUTO_EXPOSURE, /* 0 off, 1 on; exposure and gain */
    LC_AUTO_BALANCE,
    LC_AUTO_FOCUS, /* 0: by hand */
    LC_NOISE_REDUCTION,
    LC_HDR,
    LC_FLICKER,
    LC_SHARPNESS, /* 0: none */
    LC_BRIGHTNESS,
    LC_CONTRAST,
    LC_SATURATION,
    LC_CONTROL_COUNT
};

/* Of a request, or what is told of a frame. */
struct lc_settings {
    uint32_t set; /* bit c: value[c] counts */
    double value[LC_CONTROL_COUNT][2];
};

/* What a camera has; known after configure. */
struct lc_limits {
    uint32_t has; /* bit c */
    double min[LC_CONTROL_COUNT], max[LC_CONTROL_COUNT];
};

struct lc_identity {
    char id[128];   /* libcamera's own, unique and the same after each start */
    char model[64]; /* of the sensor; empty if it does not say */
};

/* How colours are coded. */
enum lc_colour {
    LC_COLOUR_UNKNOWN = 0,
    LC_COLOUR_RAW,
    LC_COLOUR_RGB_FULL,
    LC_COLOUR_BT601_LIMITED,
    LC_COLOUR_OTHER
};

/* A pixel format is a DRM code with a modifier (0: plain; packed and compressed ones have others). */
struct lc_offer {
    uint32_t fourcc;
    uint64_t modifier;
    uint32_t width, height; /* largest; 0: it does not say */
};

struct lc_ask {
    enum lc_role role;
    uint32_t fourcc;
    uint64_t modifier;
    uint32_t width, height; /* 0: the camera's own */
    enum lc_colour colour;  /* wanted */
    unsigned buffers;
};

struct lc_granted {
    uint32_t fourcc;
    uint64_t modifier;
    uint32_t width, height, stride;
    size_t bytes; /* of a buffer */
    enum lc_colour colour;
    char colour_text[48];
};

enum lc_status {
    LC_GOOD = 0,
    LC_BAD,      /* the driver says that the data are */
    LC_CANCELLED /* never exposed: the stream ended */
};

/* A request that came back. */
struct lc_done {
    unsigned buffer;
    enum lc_status status;
    uint32_t sequence; /* of the driver's frame */
    size_t bytes;      /* used */
    int64_t driver_ns; /* the kernel driver's stamp, monotonic clock; 0: none */
    int64_t sensor_ns; /* SensorTimestamp; 0: not told */
    struct lc_settings told;
};

/* A camera that is held. */
struct lc_handle;

struct lc_ops {
    unsigned abi;
    /* "0.0.3". */
    const char *(*version)(void *ctx);
    /* libcamera itself: looks for cameras. Each begin takes an end. */
    int (*begin)(void *ctx);
    void (*end)(void *ctx);
    /* What libcamera last complained of, cut to fit; empty if of nothing. */
    void (*complaint)(void *ctx, char *ret, size_t size);
    /* The i-th camera: 1, or 0 when there are no more. */
    int (*list)(void *ctx, unsigned i, struct lc_identity *ret);
    /* -ENODEV: none of that id; -EBUSY: another program has it. */
    int (*hold)(void *ctx, const char *id, struct lc_handle **ret);
    void (*let_go)(struct lc_handle *handle); /* stops it; its buffers go */
    /* The i-th format of a role: 1 or 0. */
    int (*offer)(struct lc_handle *handle, enum lc_role role, unsigned i, struct lc_offer *ret);
    int (*configure)(struct lc_handle *handle, const struct lc_ask *ask, struct lc_granted *ret);
    int (*limits)(struct lc_handle *handle, struct lc_limits *ret);
    /* Buffers of the configured stream, ret_n of them; configure and let_go give them up. */
    int (*allocate)(struct lc_handle *handle, unsigned n, unsigned *ret_n);
    int (*buffer)(struct lc_handle *handle, unsigned i, const void **ret_at, size_t *ret_length);
    /* The descriptor of such a buffer's memory, from its beginning; the module's own. What a process asks that lends it to another. */
    int (*shared)(struct lc_handle *handle, unsigned i);
    int (*start)(struct lc_handle *handle, const struct lc_settings *settings);
    /* Whatever was queued is over; nothing of it can be taken afterwards. */
    int (*stop)(struct lc_handle *handle);
    int (*queue)(struct lc_handle *handle, unsigned buffer, const struct lc_settings *settings);
    /* -EAGAIN: none came back; -ENODEV: the camera is gone. */
    int (*take)(struct lc_handle *handle, struct lc_done *ret);
    /* A descriptor that can be read while take has something to say. */
    int (*descriptor)(struct lc_handle *handle);
};

/* What the module exports, by this name. */
#define LC_MODULE_SYMBOL "ttf_libcamera_ops"
extern const struct lc_ops ttf_libcamera_ops;

#ifdef __cplusplus
}
#endif

#endif
