/* SPDX-License-Identifier: Apache-2.0 */
/* test_find.c: which box is meant, of several at one PC: libusb's table of devices is the test's own. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "find.h"
#include "ttf/usb/identity.h"

struct libusb_device {
    uint16_t vendor, product;
    const char *name, *serial; /* name NULL: it says none */
    int open_error;            /* of libusb */
    int handles;               /* that are open */
};

static struct libusb_device bus[8];
static unsigned n_bus;

static void plug(const char *name, const char *serial, int open_error)
{
    bus[n_bus++] =
        (struct libusb_device){TTF_USB_VENDOR, TTF_USB_PRODUCT, name, serial, open_error, 0};
}

static void box(const char *serial)
{
    plug(TTF_USB_PRODUCT_NAME, serial, 0);
}

static int empty(void **state)
{
    (void)state;
    n_bus = 0;
    return 0;
}

/* A handle is the device. */
static struct libusb_device *device_of(libusb_device_handle *handle)
{
    return (struct libusb_device *)(void *)handle;
}

static unsigned open_handles(void)
{
    unsigned n = 0;

    for (unsigned i = 0; i < n_bus; i++)
        n += (unsigned)bus[i].handles;
    return n;
}

/* ---- libusb's, of which find.c knows no more ---- */

/* NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): libusb has names of its own */

int libusb_init(libusb_context **context)
{
    *context = NULL;
    return 0;
}

void libusb_exit(libusb_context *context)
{
    (void)context;
}

const char *libusb_strerror(int code)
{
    (void)code;
    return "";
}

ssize_t libusb_get_device_list(libusb_context *context, libusb_device ***list)
{
    static libusb_device *devices[sizeof bus / sizeof *bus + 1];

    (void)context;
    for (unsigned i = 0; i < n_bus; i++)
        devices[i] = &bus[i];
    *list = devices;
    return (ssize_t)n_bus;
}

void libusb_free_device_list(libusb_device **list, int unref)
{
    (void)list;
    (void)unref;
}

int libusb_get_device_descriptor(libusb_device *device, struct libusb_device_descriptor *ret)
{
    *ret = (struct libusb_device_descriptor){.idVendor = device->vendor,
                                             .idProduct = device->product,
                                             .iProduct = 2,
                                             .iSerialNumber = 3};
    return 0;
}

uint8_t libusb_get_bus_number(libusb_device *device)
{
    (void)device;
    return 1;
}

uint8_t libusb_get_device_address(libusb_device *device)
{
    return (uint8_t)(device - bus + 1);
}

int libusb_open(libusb_device *device, libusb_device_handle **ret)
{
    if (device->open_error)
        return device->open_error;
    device->handles++;
    *ret = (libusb_device_handle *)(void *)device;
    return 0;
}

void libusb_close(libusb_device_handle *handle)
{
    device_of(handle)->handles--;
}

libusb_device *libusb_get_device(libusb_device_handle *handle)
{
    return device_of(handle);
}

int libusb_get_string_descriptor_ascii(libusb_device_handle *handle, uint8_t index,
                                       unsigned char *data, int length)
{
    const char *text = index == 2 ? device_of(handle)->name : device_of(handle)->serial;

    if (!text)
        return LIBUSB_ERROR_PIPE;
    return snprintf((char *)data, (size_t)length, "%s", text);
}

int libusb_get_active_config_descriptor(libusb_device *device,
                                        struct libusb_config_descriptor **ret)
{
    (void)device;
    (void)ret;
    return LIBUSB_ERROR_NOT_FOUND;
}

void libusb_free_config_descriptor(struct libusb_config_descriptor *config)
{
    (void)config;
}

/* NOLINTEND(readability-inconsistent-declaration-parameter-name) */

/* ---- what must hold ---- */

static const char *opened(const char *serial)
{
    libusb_device_handle *handle = NULL;
    struct ttf_err err = {0};

    assert_int_equal(usb_find_open(NULL, serial, &handle, &err), 0);
    assert_non_null(handle);
    assert_int_equal(open_handles(), 1);
    libusb_close(handle);
    return device_of(handle)->serial;
}

static void refused(const char *serial, int code, const char *words)
{
    libusb_device_handle *handle = NULL;
    struct ttf_err err = {0};

    assert_int_equal(usb_find_open(NULL, serial, &handle, &err), code);
    assert_null(handle);
    assert_int_equal(open_handles(), 0);
    if (!strstr(err.what, words))
        fail_msg("'%s' does not say '%s'", err.what, words);
}

static void two_boxes_are_told_apart_by_their_serials(void **state)
{
    struct ttf_usb_box boxes[4];

    (void)state;
    box("0007");
    box("0008");
    assert_string_equal(opened("0007"), "0007");
    assert_string_equal(opened("0008"), "0008");
    refused("000", -ENODEV, "no box of serial '000'");
    refused("00071", -ENODEV, "no box of serial '00071'");
    assert_int_equal(ttf_usb_libusb_list(boxes, 4, NULL), 2);
    assert_string_equal(boxes[0].serial, "0007");
    assert_string_equal(boxes[1].serial, "0008");
    assert_int_not_equal(boxes[0].address, boxes[1].address);
    assert_int_equal(open_handles(), 0);
}

static void which_of_several_is_not_guessed_and_all_are_named(void **state)
{
    (void)state;
    box("0007");
    assert_string_equal(opened(NULL), "0007");
    box("0008");
    box("");
    refused(NULL, -ENOTUNIQ, "there are 3 boxes: 0007, 0008, (none)");
    /* As two cards that were copied would have it. */
    box("0008");
    refused("0008", -ENOTUNIQ, "there are 2 boxes: 0008, 0008");
    assert_string_equal(opened("0007"), "0007");
}

static void what_shares_a_boxs_numbers_is_none(void **state)
{
    struct ttf_usb_box boxes[4];

    (void)state;
    plug("somebody's keyboard", "0007", 0);
    plug(NULL, "0008", 0);
    bus[n_bus++] = (struct libusb_device){0x1209, 0x0002, TTF_USB_PRODUCT_NAME, "0009", 0, 0};
    refused(NULL, -ENODEV, "no box is here");
    refused("0007", -ENODEV, "no box of serial");
    assert_int_equal(ttf_usb_libusb_list(boxes, 4, NULL), 0);
    box("0010");
    assert_string_equal(opened(NULL), "0010");
}

static void one_that_may_not_be_used_hides_no_other(void **state)
{
    struct ttf_usb_box boxes[1];

    (void)state;
    plug(TTF_USB_PRODUCT_NAME, "0007", LIBUSB_ERROR_ACCESS);
    refused(NULL, -EACCES, "you may not use");
    box("0008");
    assert_string_equal(opened("0008"), "0008");
    refused("0007", -EACCES, "you may not use");
    /* There is room for one, and there are two. */
    assert_int_equal(ttf_usb_libusb_list(boxes, 1, NULL), 2);
    assert_int_equal(boxes[0].error, -EACCES);
}

static void more_boxes_than_fit_are_named_as_far_as_there_is_room(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 8; i++)
        box("0123456789012345678901234567890");
    refused(NULL, -ENOTUNIQ, "there are 8 boxes: 0123456789");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(two_boxes_are_told_apart_by_their_serials, empty),
        cmocka_unit_test_setup(which_of_several_is_not_guessed_and_all_are_named, empty),
        cmocka_unit_test_setup(what_shares_a_boxs_numbers_is_none, empty),
        cmocka_unit_test_setup(one_that_may_not_be_used_hides_no_other, empty),
        cmocka_unit_test_setup(more_boxes_than_fit_are_named_as_far_as_there_is_room, empty),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
