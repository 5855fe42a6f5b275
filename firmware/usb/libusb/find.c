/* SPDX-License-Identifier: Apache-2.0 */
#include "find.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "ttf/usb/identity.h"

int usb_errno(int error)
{
    switch (error) {
    case LIBUSB_SUCCESS:
        return 0;
    case LIBUSB_ERROR_ACCESS:
        return -EACCES;
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
        return -ENODEV;
    case LIBUSB_ERROR_BUSY:
        return -EBUSY;
    case LIBUSB_ERROR_NO_MEM:
        return -ENOMEM;
    case LIBUSB_ERROR_TIMEOUT:
        return -ETIMEDOUT;
    default:
        return -EIO;
    }
}

static bool has_number(libusb_device *device, struct libusb_device_descriptor *ret)
{
    return libusb_get_device_descriptor(device, ret) == 0 && ret->idVendor == TTF_USB_VENDOR &&
           ret->idProduct == TTF_USB_PRODUCT;
}

/* Opens what has a box's numbers and name. The numbers are shared by others. -ENOENT: it is another's. */
static int open_box(libusb_device *device, libusb_device_handle **ret, char *serial, size_t size)
{
    struct libusb_device_descriptor d;
    unsigned char name[128] = "", text[TTF_USB_SERIAL_SIZE] = "";
    int r;

    if (!has_number(device, &d))
        return -ENOENT;
    r = libusb_open(device, ret);
    if (r < 0)
        return usb_errno(r);
    (void)libusb_get_string_descriptor_ascii(*ret, d.iProduct, name, (int)sizeof name);
    if (strcmp((const char *)name, TTF_USB_PRODUCT_NAME) != 0) {
        libusb_close(*ret);
        return -ENOENT;
    }
    (void)libusb_get_string_descriptor_ascii(*ret, d.iSerialNumber, text, (int)sizeof text);
    (void)snprintf(serial, size, "%s", (const char *)text);
    return 0;
}

static int list_devices(libusb_context *context, libusb_device ***ret, struct ttf_err *err)
{
    ssize_t n = libusb_get_device_list(context, ret);

    if (n < 0)
        return ttf_err_set(err, usb_errno((int)n), "USB", "devices cannot be listed: %s",
                           libusb_strerror((int)n));
    return (int)n;
}

int ttf_usb_libusb_list(struct ttf_usb_box *ret, unsigned max, struct ttf_err *err)
{
    libusb_context *context = NULL;
    libusb_device **devices = NULL;
    int r = libusb_init(&context), n, found = 0;

    if (r < 0)
        return ttf_err_set(err, usb_errno(r), "USB", "libusb: %s", libusb_strerror(r));
    n = list_devices(context, &devices, err);
    for (int i = 0; i < n; i++) {
        libusb_device_handle *handle = NULL;
        struct ttf_usb_box box = {.bus = libusb_get_bus_number(devices[i]),
                                  .address = libusb_get_device_address(devices[i])};

        box.error = open_box(devices[i], &handle, box.serial, sizeof box.serial);
        if (box.error == 0)
            libusb_close(handle);
        if (box.error == -ENOENT)
            continue;
        if ((unsigned)found < max)
            ret[found] = box;
        found++;
    }
    if (devices)
        libusb_free_device_list(devices, 1);
    libusb_exit(context);
    return n < 0 ? n : found;
}

struct choice {
    libusb_device_handle *handle;
    unsigned n; /* that it may be */
    int error;  /* of one that could not be opened */
    char serials[200];
};

static void add_serial(struct choice *c, const char *serial)
{
    size_t n = strlen(c->serials);

    (void)snprintf(c->serials + n, sizeof c->serials - n, "%s%s", n > 0 ? ", " : "",
                   *serial ? serial : "(none)");
}

static void consider(struct choice *c, libusb_device *device, const char *wanted)
{
    char serial[TTF_USB_SERIAL_SIZE];
    libusb_device_handle *handle = NULL;
    int r = open_box(device, &handle, serial, sizeof serial);

    if (r < 0) {
        if (r != -ENOENT)
            c->error = r;
        return;
    }
    if (wanted && strcmp(wanted, serial) != 0) {
        libusb_close(handle);
        return;
    }
    add_serial(c, serial);
    if (c->n++ == 0)
        c->handle = handle;
    else
        libusb_close(handle);
}

int usb_find_open(libusb_context *context, const char *serial, libusb_device_handle **ret,
                  struct ttf_err *err)
{
    struct choice c = {.error = -ENODEV};
    libusb_device **devices = NULL;
    int n = list_devices(context, &devices, err);

    if (n < 0)
        return n;
    for (int i = 0; i < n; i++)
        consider(&c, devices[i], serial);
    libusb_free_device_list(devices, 1);
    if (c.n == 1) {
        *ret = c.handle;
        return 0;
    }
    if (c.n > 1) {
        libusb_close(c.handle);
        ttf_err_set(err, -ENOTUNIQ, "USB", "there are %u boxes: %s", c.n, c.serials);
        ttf_err_hint(
            err,
            serial
                ? "give one another serial: /etc/ttfbox/usb-serial, of an image settings/usb-serial"
                : "name one by its serial, as usb:SERIAL");
        return -ENOTUNIQ;
    }
    if (c.error == -EACCES) {
        ttf_err_set(err, -EACCES, "USB", "there is a box that you may not use");
        ttf_err_hint(err, "the rule 70-ttfbox-usb.rules lets whoever sits at this machine: is it "
                          "in /usr/lib/udev/rules.d? Plug the box in again");
        return -EACCES;
    }
    ttf_err_set(err, c.error, "USB", serial ? "no box of serial '%s' is here" : "no box is here%s",
                serial ? serial : "");
    return c.error;
}

int usb_find_endpoints(libusb_device_handle *handle, struct usb_endpoints *ret)
{
    struct libusb_config_descriptor *config = NULL;
    int r = libusb_get_active_config_descriptor(libusb_get_device(handle), &config);
    bool found = false;

    if (r < 0)
        return usb_errno(r);
    for (unsigned i = 0; i < config->bNumInterfaces && !found; i++) {
        const struct libusb_interface_descriptor *d = config->interface[i].altsetting;

        if (config->interface[i].num_altsetting < 1 || d->bInterfaceClass != TTF_USB_CLASS)
            continue;
        *ret = (struct usb_endpoints){.interface = d->bInterfaceNumber};
        for (unsigned k = 0; k < d->bNumEndpoints; k++) {
            uint8_t address = d->endpoint[k].bEndpointAddress;

            if (address & LIBUSB_ENDPOINT_IN)
                ret->in = address;
            else
                ret->out = address;
        }
        found = ret->in != 0 && ret->out != 0;
    }
    libusb_free_config_descriptor(config);
    return found ? 0 : -ENODEV;
}
