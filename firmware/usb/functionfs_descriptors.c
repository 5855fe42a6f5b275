/* SPDX-License-Identifier: Apache-2.0 */
/*
 * functionfs_descriptors.c: one vendor interface with a bulk endpoint in each direction, as bytes: USB 2.0, section 9.6; USB 3.2,
 * 9.6.7; Microsoft OS Descriptors 1.0, in the form that FunctionFS takes them (linux/usb/functionfs.h).
 */
#include <linux/usb/functionfs.h>
#include <string.h>

#include "frames.h"
#include "ttf/usb/functionfs.h"
#include "ttf/usb/identity.h"

#define BULK       2 /* bmAttributes of an endpoint */
#define IN_FIRST   0x81
#define OUT_SECOND 0x02
#define PROPERTY   "DeviceInterfaceGUID"
#define REG_SZ     1
#define ENGLISH    0x0409
#define HEAD       11 /* bytes of a head of Microsoft's; dwLength counts it too */

struct bytes {
    uint8_t *at;
    size_t n;
};

static void put8(struct bytes *b, unsigned v)
{
    b->at[b->n++] = (uint8_t)v;
}

static void put16(struct bytes *b, unsigned v)
{
    usb_put16(b->at + b->n, (uint16_t)v);
    b->n += 2;
}

static void put32(struct bytes *b, size_t v)
{
    usb_put32(b->at + b->n, (uint32_t)v);
    b->n += 4;
}

static void put(struct bytes *b, const void *data, size_t n)
{
    memcpy(b->at + b->n, data, n);
    b->n += n;
}

static void interface(struct bytes *b)
{
    put8(b, USB_DT_INTERFACE_SIZE);
    put8(b, USB_DT_INTERFACE);
    put8(b, 0); /* bInterfaceNumber: the kernel gives another */
    put8(b, 0); /* bAlternateSetting */
    put8(b, 2); /* bNumEndpoints */
    put8(b, TTF_USB_CLASS);
    put8(b, 0); /* bInterfaceSubClass */
    put8(b, 0); /* bInterfaceProtocol */
    put8(b, 1); /* iInterface: the first of our strings */
}

static void endpoint(struct bytes *b, unsigned address, unsigned packet)
{
    put8(b, USB_DT_ENDPOINT_SIZE);
    put8(b, USB_DT_ENDPOINT);
    put8(b, address);
    put8(b, BULK);
    put16(b, packet);
    put8(b, 0); /* bInterval */
}

static void companion(struct bytes *b)
{
    put8(b, USB_DT_SS_EP_COMP_SIZE);
    put8(b, USB_DT_SS_ENDPOINT_COMP);
    put8(b, 0);  /* bMaxBurst */
    put8(b, 0);  /* bmAttributes: no streams */
    put16(b, 0); /* wBytesPerInterval */
}

static void speed(struct bytes *b, unsigned packet)
{
    interface(b);
    endpoint(b, IN_FIRST, packet);
    if (packet == 1024)
        companion(b);
    endpoint(b, OUT_SECOND, packet);
    if (packet == 1024)
        companion(b);
}

/* Windows takes its own driver WinUSB for the interface, ... */
static void compatible(struct bytes *b, unsigned bcd_version)
{
    put8(b, 0); /* interface */
    put32(b, HEAD + 24);
    put16(b, bcd_version);
    put16(b, 4); /* wIndex: compatible IDs */
    put8(b, 1);  /* bCount */
    put8(b, 0);  /* Reserved */
    put8(b, 0);  /* bFirstInterfaceNumber */
    put8(b, 1);  /* Reserved1 */
    put(b, "WINUSB\0\0", 8);
    put(b, "\0\0\0\0\0\0\0\0", 8); /* SubCompatibleID */
    put(b, "\0\0\0\0\0\0", 6);
}

/* ... and programs find it there by this GUID. */
static void property(struct bytes *b, unsigned bcd_version)
{
    const size_t size = 4 + 4 + 2 + sizeof PROPERTY + 4 + sizeof TTF_USB_GUID;

    put8(b, 0); /* interface */
    put32(b, HEAD + size);
    put16(b, bcd_version);
    put16(b, 5); /* wIndex: properties */
    put16(b, 1); /* wCount */
    put32(b, size);
    put32(b, REG_SZ);
    put16(b, sizeof PROPERTY);
    put(b, PROPERTY, sizeof PROPERTY);
    put32(b, sizeof TTF_USB_GUID);
    put(b, TTF_USB_GUID, sizeof TTF_USB_GUID);
}

size_t ttf_usb_functionfs_descriptors(uint8_t *ret, unsigned bcd_version)
{
    struct bytes b = {.at = ret};

    put32(&b, FUNCTIONFS_DESCRIPTORS_MAGIC_V2);
    put32(&b, 0); /* length: at the end */
    put32(&b, FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC | FUNCTIONFS_HAS_SS_DESC |
                  FUNCTIONFS_HAS_MS_OS_DESC);
    put32(&b, 3); /* descriptors of full speed, high speed, super speed; of Microsoft's */
    put32(&b, 3);
    put32(&b, 5);
    put32(&b, 2);
    speed(&b, 64);
    speed(&b, 512);
    speed(&b, 1024);
    compatible(&b, bcd_version);
    property(&b, bcd_version);
    usb_put32(ret + 4, (uint32_t)b.n);
    return b.n;
}

size_t ttf_usb_functionfs_strings(uint8_t *ret)
{
    struct bytes b = {.at = ret};

    put32(&b, FUNCTIONFS_STRINGS_MAGIC);
    put32(&b, 0);
    put32(&b, 1); /* strings */
    put32(&b, 1); /* languages */
    put16(&b, ENGLISH);
    put(&b, "ttfbox streams", sizeof "ttfbox streams");
    usb_put32(ret + 4, (uint32_t)b.n);
    return b.n;
}
