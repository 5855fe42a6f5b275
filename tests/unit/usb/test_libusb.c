/* SPDX-License-Identifier: Apache-2.0 */
/* test_libusb.c: a PC's end of the cable where libusb does not give back what was cancelled: libusb is the test's own. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdlib.h>

#include "find.h"
#include "ttf/usb/link.h"

#define OUT_MAX 256

static struct libusb_transfer *out[OUT_MAX]; /* submitted, and not given back */
static unsigned n_out;
static unsigned n_kept; /* of them, the first: of a device that was let go with them */
static bool keeps;      /* nothing comes back */

/* ---- libusb's and find.c's ---- */

int usb_errno(int error)
{
    return error < 0 ? -EIO : 0;
}

int usb_find_open(libusb_context *context, const char *serial, libusb_device_handle **ret,
                  struct ttf_err *err)
{
    (void)context;
    (void)serial;
    (void)err;
    *ret = (libusb_device_handle *)(void *)out;
    return 0;
}

int usb_find_endpoints(libusb_device_handle *handle, struct usb_endpoints *ret)
{
    (void)handle;
    *ret = (struct usb_endpoints){.in = 0x81, .out = 1};
    return 0;
}

int libusb_init(libusb_context **ctx)
{
    *ctx = NULL;
    return 0;
}

void libusb_exit(libusb_context *ctx)
{
    (void)ctx;
}

struct libusb_transfer *libusb_alloc_transfer(int iso_packets)
{
    (void)iso_packets;
    return calloc(1, sizeof(struct libusb_transfer));
}

void libusb_free_transfer(struct libusb_transfer *transfer)
{
    free(transfer);
}

int libusb_submit_transfer(struct libusb_transfer *transfer)
{
    for (unsigned i = 0; i < n_out; i++)
        assert_ptr_not_equal(out[i], transfer); /* it was not given away twice */
    assert_true(n_out < OUT_MAX);
    out[n_out++] = transfer;
    return 0;
}

int libusb_cancel_transfer(struct libusb_transfer *transfer)
{
    transfer->status = LIBUSB_TRANSFER_CANCELLED;
    return 0;
}

static void give_back(struct libusb_transfer *transfer)
{
    transfer->callback(transfer);
}

/* NOLINTNEXTLINE(readability-non-const-parameter): libusb's own */
int libusb_handle_events_timeout_completed(libusb_context *ctx, struct timeval *tv, int *completed)
{
    unsigned kept = n_kept;

    (void)ctx;
    (void)tv;
    (void)completed;
    for (unsigned i = kept; i < n_out; i++)
        if (keeps || out[i]->status != LIBUSB_TRANSFER_CANCELLED)
            out[kept++] = out[i];
        else
            give_back(out[i]);
    n_out = kept;
    return 0;
}

int libusb_claim_interface(libusb_device_handle *handle, int interface)
{
    (void)handle;
    (void)interface;
    return 0;
}

int libusb_release_interface(libusb_device_handle *handle, int interface)
{
    (void)handle;
    (void)interface;
    return 0;
}

void libusb_close(libusb_device_handle *handle)
{
    (void)handle;
    n_kept = n_out;
}

const struct libusb_pollfd **libusb_get_pollfds(libusb_context *ctx)
{
    (void)ctx;
    return NULL;
}

void libusb_free_pollfds(const struct libusb_pollfd **pollfds)
{
    (void)pollfds;
}

const char *libusb_strerror(int errcode)
{
    (void)errcode;
    return "";
}

/* ---- tests ---- */

static struct ttf_usb_link *make(void)
{
    struct ttf_usb_link *link = NULL;
    struct ttf_err err = {0};

    n_out = n_kept = 0;
    keeps = false;
    if (ttf_usb_libusb_create(NULL, &link, &err) < 0)
        fail();
    return link;
}

/* All that was kept comes back, whatever is open by then. */
static void all_come_back(void)
{
    for (unsigned i = 0; i < n_kept; i++)
        give_back(out[i]);
    n_out -= n_kept;
    for (unsigned i = 0; i < n_out; i++)
        out[i] = out[n_kept + i];
    n_kept = 0;
}

static void a_box_is_taken_again_though_transfers_of_before_stay_away(void **state)
{
    struct ttf_usb_link *link = make();
    struct ttf_usb_event event;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(link->ops->open(link, &err), 0);
    assert_non_null(link->ops->buffer(link));
    link->ops->send(link, 100);
    assert_int_equal(link->ops->reset(link, 7), 0);
    keeps = true;
    link->ops->close(link);
    keeps = false;
    assert_int_equal(n_kept, TTF_USB_DEPTH + 2);
    assert_int_equal(link->ops->open(link, &err), 0);
    assert_int_equal(n_out - n_kept, TTF_USB_DEPTH);
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++) { /* as many may be sent as ever */
        assert_non_null(link->ops->buffer(link));
        link->ops->send(link, 100);
    }
    assert_int_equal(link->ops->reset(link, 8), 0);
    /* What comes back now says nothing of what is under way. */
    all_come_back();
    link->ops->next(link, &event);
    assert_int_equal(event.kind, TTF_USB_NOTHING);
    assert_null(link->ops->buffer(link));
    assert_int_equal(link->ops->reset(link, 9), -EALREADY);
    ttf_usb_link_destroy(link);
    assert_int_equal(n_out, 0);
}

static void what_stays_away_is_bounded(void **state)
{
    struct ttf_usb_link *link = make();
    struct ttf_err err = {0};
    int r = 0;

    (void)state;
    for (unsigned opened = 0; r == 0; opened++) {
        assert_in_range(opened, 0, 20);
        keeps = false;
        r = link->ops->open(link, &err);
        keeps = true;
        link->ops->close(link);
    }
    assert_int_equal(r, -EIO);
    all_come_back();
    assert_int_equal(link->ops->open(link, &err), 0);
    keeps = false;
    ttf_usb_link_destroy(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_is_taken_again_though_transfers_of_before_stay_away),
        cmocka_unit_test(what_stays_away_is_bounded),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
