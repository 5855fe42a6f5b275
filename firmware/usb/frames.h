/* SPDX-License-Identifier: Apache-2.0 */
/* frames.h: frames as bytes (PROTOCOL.md, "Frames"). */
#ifndef USB_FRAMES_H
#define USB_FRAMES_H

#include <endian.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define USB_VERSION     1u
#define USB_HEADER      8u
#define USB_DATA_MAX    16384u
#define USB_SHORTEST    64u /* of all speeds' packets: a transfer is never a multiple of it */
#define USB_HELLO_SIZE  16u
#define USB_NUMBER_SIZE 4u
#define USB_WINDOW_MAX  (16u << 20)

enum usb_frame_type {
    USB_FRAME_HELLO = 1,
    USB_FRAME_OPEN = 2,
    USB_FRAME_DATA = 3,
    USB_FRAME_CREDIT = 4,
    USB_FRAME_CLOSE = 5,
    USB_FRAME_PAD = 6
};

struct usb_frame {
    uint16_t stream;
    uint8_t type, flags;
    uint32_t length;
};

struct usb_hello {
    uint16_t version, streams;
    uint32_t window;
    uint64_t nonce;
};

static inline uint16_t usb_get16(const uint8_t *at)
{
    uint16_t v;

    memcpy(&v, at, sizeof v);
    return le16toh(v);
}

static inline uint32_t usb_get32(const uint8_t *at)
{
    uint32_t v;

    memcpy(&v, at, sizeof v);
    return le32toh(v);
}

static inline uint64_t usb_get64(const uint8_t *at)
{
    uint64_t v;

    memcpy(&v, at, sizeof v);
    return le64toh(v);
}

static inline void usb_put16(uint8_t *at, uint16_t v)
{
    v = htole16(v);
    memcpy(at, &v, sizeof v);
}

static inline void usb_put32(uint8_t *at, uint32_t v)
{
    v = htole32(v);
    memcpy(at, &v, sizeof v);
}

static inline void usb_put64(uint8_t *at, uint64_t v)
{
    v = htole64(v);
    memcpy(at, &v, sizeof v);
}

static inline struct usb_frame usb_frame_read(const uint8_t *at)
{
    return (struct usb_frame){usb_get16(at), at[2], at[3], usb_get32(at + 4)};
}

static inline void usb_frame_write(uint8_t *at, unsigned stream, enum usb_frame_type type,
                                   size_t length)
{
    usb_put16(at, (uint16_t)stream);
    at[2] = (uint8_t)type;
    at[3] = 0;
    usb_put32(at + 4, (uint32_t)length);
}

static inline struct usb_hello usb_hello_read(const uint8_t *at)
{
    return (struct usb_hello){usb_get16(at), usb_get16(at + 2), usb_get32(at + 4),
                              usb_get64(at + 8)};
}

#endif
