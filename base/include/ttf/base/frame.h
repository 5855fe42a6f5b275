/* SPDX-License-Identifier: Apache-2.0 */
/*
 * frame.h: a camera's buffer, described.
 *
 * A camera (hal) hands out bytes with this description beside them; `develop`
 * (dataset) turns them into pixels. Neither room knows the other: this header is
 * all they share.
 */
#ifndef TTF_BASE_FRAME_H
#define TTF_BASE_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How samples lie in memory. */
enum ttf_packing {
    TTF_PACKING_NONE = 0,
    TTF_PACKING_RAW16, /* one CFA sample per pixel, 16-bit words of the machine, value in the low `bits` */
    TTF_PACKING_GREY8,  /* one byte per pixel */
    TTF_PACKING_GREY16, /* one 16-bit word per pixel, value in the low `bits` */
    TTF_PACKING_RGB8,   /* R, G, B bytes */
    TTF_PACKING_YUYV8,  /* Y0 Cb Y1 Cr bytes, BT.601 limited range */
    TTF_PACKING_RAW8, /* one linear sample per byte: a mosaic, or a linear grey camera (cfa NONE) */
    TTF_PACKING_RAW10P, /* MIPI RAW10: 4 samples in 5 bytes, high 8 bits each, then the low 2 of all, first lowest */
    TTF_PACKING_RAW12P, /* MIPI RAW12: 2 samples in 3 bytes, high 8 bits each, then the low 4 of both */
    TTF_PACKING_NV12, /* as YUYV8: a plane of Y bytes, then one of Cb Cr, half as wide and high, of one stride */
    TTF_PACKING_COUNT
};

/* Colour filter array: the colours of the first row, then of the second. */
enum ttf_cfa {
    TTF_CFA_NONE = 0, /* no mosaic */
    TTF_CFA_RGGB,
    TTF_CFA_GRBG,
    TTF_CFA_GBRG,
    TTF_CFA_BGGR,
    TTF_CFA_COUNT
};

/* Geometry and levels of a buffer. Constant from `configure` until the next one. */
struct ttf_frame_format {
    uint32_t width;  /* pixels, 1..65535 */
    uint32_t height; /* pixels, 1..65535 */
    size_t stride;   /* bytes from one row to the next, >= the row's own bytes */
    enum ttf_packing packing;
    enum ttf_cfa cfa;
    uint8_t bits;         /* significant bits per sample, 1..16 */
    uint16_t black_level; /* code of no light at all (all CFA positions alike) */
    uint16_t white_level; /* code at which the sensor saturates, > black_level */
};

/* True if all fields but the stride are equal: the same pixels. */
static inline bool ttf_frame_format_equal(const struct ttf_frame_format *a,
                                          const struct ttf_frame_format *b)
{
    return a->width == b->width && a->height == b->height && a->packing == b->packing &&
           a->cfa == b->cfa && a->bits == b->bits && a->black_level == b->black_level &&
           a->white_level == b->white_level;
}

/* Bytes that the samples of a row take (of NV12: of a row of either plane); 0 for no packing that is known. */
static inline size_t ttf_row_bytes(enum ttf_packing packing, uint32_t width)
{
    switch (packing) {
    case TTF_PACKING_RAW16:
    case TTF_PACKING_GREY16:
        return (size_t)width * 2;
    case TTF_PACKING_GREY8:
    case TTF_PACKING_RAW8:
        return width;
    case TTF_PACKING_RGB8:
        return (size_t)width * 3;
    case TTF_PACKING_YUYV8:
        return ((size_t)width + 1) / 2 * 4;
    case TTF_PACKING_RAW10P:
        return ((size_t)width + 3) / 4 * 5;
    case TTF_PACKING_RAW12P:
        return ((size_t)width + 1) / 2 * 3;
    case TTF_PACKING_NV12:
        return ((size_t)width + 1) / 2 * 2;
    default:
        return 0;
    }
}

/* Rows of stride bytes that a whole frame has. */
static inline size_t ttf_frame_rows(const struct ttf_frame_format *format)
{
    return format->packing == TTF_PACKING_NV12
               ? (size_t)format->height + ((size_t)format->height + 1) / 2
               : format->height;
}

/*
 * What one exposure is taken with: as asked, or as the driver granted it and
 * read it back. Two exposures are of equal settings if all fields are equal.
 * A camera without some control leaves that field 0 in what it reads back.
 */
struct ttf_exposure {
    int64_t exposure_ns; /* duration of one row's exposure, > 0; read back 0: it is not known */
    uint32_t gain_milli; /* analogue gain, 1000 = unity */
    uint32_t wb_r_milli; /* red gain relative to green applied by the camera; 1000 for raw */
    uint32_t wb_b_milli; /* blue gain relative to green; 1000 for raw */
    uint32_t lens_mdpt;  /* lens position in milli-dioptres, 0 = infinity or fixed lens */
};

static inline bool ttf_exposure_equal(const struct ttf_exposure *a, const struct ttf_exposure *b)
{
    return a->exposure_ns == b->exposure_ns && a->gain_milli == b->gain_milli &&
           a->wb_r_milli == b->wb_r_milli && a->wb_b_milli == b->wb_b_milli &&
           a->lens_mdpt == b->lens_mdpt;
}

/* Marks on a frame. */
enum {
    TTF_FRAME_ERROR = 1u << 0,         /* the driver says that the data are bad */
    TTF_FRAME_SHORT = 1u << 1,         /* fewer bytes arrived than the format needs */
    TTF_FRAME_SEQUENCE_GAP = 1u << 2,  /* frames were lost before this one */
    TTF_FRAME_SIMULATED = 1u << 3,     /* made by the simulated box */
    TTF_FRAME_NO_SENSOR_TIME = 1u << 4 /* timestamps are of arrival, not of the sensor */
};

/*
 * One buffer with what is known about it. `data` belongs to the camera and is
 * valid until the frame is released.
 */
struct ttf_frame {
    struct ttf_frame_format format;
    const void *data;
    size_t bytes; /* valid bytes at data */
    /*
     * Of the whole frame, on the boot clock: the first row's exposure begins at
     * start_ns, the last row's ends at end_ns (rolling shutter: end - start is
     * exposure + readout). Their mean is the middle of the exposure.
     */
    int64_t start_ns;
    int64_t end_ns;
    uint32_t sequence;            /* the driver's own frame counter */
    uint32_t flags;               /* TTF_FRAME_* */
    struct ttf_exposure settings; /* as read back for this very frame */
    uint32_t set_index;           /* which of the set's settings this buffer answers */
    void *backend;                /* the camera's own; not for the caller */
};

#endif
