/* SPDX-License-Identifier: Apache-2.0 */
/* test_descriptors.c: what FunctionFS is given, byte by byte, written down here from the specifications alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ttf/usb/functionfs.h"

/* USB 2.0, tables 9-12 and 9-13; USB 3.2, table 9-26 (endpoint companion). */
#define INTERFACE            9, 4, 0, 0, 2, 0xff, 0, 0, 1
#define ENDPOINTS(low, high) 7, 5, 0x81, 2, low, high, 0, 7, 5, 0x02, 2, low, high, 0
#define ENDPOINTS_SUPER                                                                          \
    7, 5, 0x81, 2, 0x00, 0x04, 0, 6, 0x30, 0, 0, 0, 0, 7, 5, 0x02, 2, 0x00, 0x04, 0, 6, 0x30, 0, \
        0, 0, 0

static void descriptors_are_those_of_the_specifications(void **state)
{
    const uint8_t expected[] = {
        /* linux/usb/functionfs.h: magic 3, length, flags (full, high, super speed, Microsoft), counts */
        3, 0, 0, 0, 0xe4, 0, 0, 0, 0x0f, 0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0, 5, 0, 0, 0, 2, 0, 0, 0,
        INTERFACE, ENDPOINTS(0x40, 0x00), INTERFACE, ENDPOINTS(0x00, 0x02), INTERFACE,
        ENDPOINTS_SUPER,
        /* Microsoft OS 1.0, Extended Compat ID: interface, length, version 1.00, index 4, one function */
        0, 35, 0, 0, 0, 0x00, 0x01, 4, 0, 1, 0, 0, 1, 'W', 'I', 'N', 'U', 'S', 'B', 0, 0, 0, 0, 0,
        0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
        /* Extended Properties: interface, length, version, index 5, one property */
        0, 84, 0, 0, 0, 0x00, 0x01, 5, 0, 1, 0, 73, 0, 0, 0, 1, 0, 0, 0, 20, 0, 'D', 'e', 'v', 'i',
        'c', 'e', 'I', 'n', 't', 'e', 'r', 'f', 'a', 'c', 'e', 'G', 'U', 'I', 'D', 0, 39, 0, 0, 0,
        '{', '8', 'F', 'E', '6', 'D', '4', 'D', '7', '-', '4', '9', 'D', 'D', '-', '4', '1', 'E',
        '7', '-', '9', '4', '8', '6', '-', '4', '9', 'A', 'F', 'C', '6', 'B', 'F', 'E', '4', '7',
        '5', '}', 0};
    uint8_t made[TTF_USB_DESCRIPTORS_MAX];
    size_t n = ttf_usb_functionfs_descriptors(made, 0x0100);

    (void)state;
    assert_int_equal(n, sizeof expected);
    assert_int_equal(made[4] | made[5] << 8, sizeof expected);
    assert_memory_equal(made, expected, sizeof expected);
}

static void older_kernels_get_the_version_that_they_take(void **state)
{
    uint8_t made[TTF_USB_DESCRIPTORS_MAX], older[TTF_USB_DESCRIPTORS_MAX];
    size_t n = ttf_usb_functionfs_descriptors(made, 0x0100), differ = 0;

    (void)state;
    assert_int_equal(ttf_usb_functionfs_descriptors(older, 1), n);
    for (size_t i = 0; i < n; i++)
        differ += made[i] != older[i];
    assert_int_equal(differ, 4); /* two versions of two bytes */
}

static void the_string_is_english(void **state)
{
    const uint8_t expected[] = {2,   0,   0,   0,   33,  0,    0,    0,   1,   0,   0,
                                0,   1,   0,   0,   0,   0x09, 0x04, 't', 't', 'f', 'b',
                                'o', 'x', ' ', 's', 't', 'r',  'e',  'a', 'm', 's', 0};
    uint8_t made[TTF_USB_DESCRIPTORS_MAX];

    (void)state;
    assert_int_equal(ttf_usb_functionfs_strings(made), sizeof expected);
    assert_memory_equal(made, expected, sizeof expected);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descriptors_are_those_of_the_specifications),
        cmocka_unit_test(older_kernels_get_the_version_that_they_take),
        cmocka_unit_test(the_string_is_english),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
