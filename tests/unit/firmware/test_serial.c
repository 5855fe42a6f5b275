/* SPDX-License-Identifier: Apache-2.0 */
/* test_serial.c: a box has one serial: its programs and the gadget, which is a shell script, make it by the same rule. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "devices.h"

static char root[64];

static void put(const char *name, const char *text)
{
    char path[256];
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/%s", root, name);
    if (!text) {
        (void)unlink(path);
        return;
    }
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        (void)mkdir(path, 0755);
        *slash = '/';
    }
    file = fopen(path, "we");
    assert_non_null(file);
    if (file) {
        (void)fputs(text, file);
        (void)fclose(file);
    }
}

/* What the gadget says: "serial X, network ...". */
static void of_gadget(char ret[64])
{
    char command[512], line[256] = "";
    FILE *out;

    (void)snprintf(command, sizeof command, "sh %s --into %s show", GADGET, root);
    out = popen(command, "re"); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a script of ours */
    assert_non_null(out);
    if (out) {
        (void)!fgets(line, sizeof line, out);
        (void)pclose(out);
    }
    assert_int_equal(sscanf(line, "serial %63[^,],", ret), 1);
}

static void the_gadget_and_the_programs_call_a_box_the_same(void **state)
{
    static const struct {
        const char *person, *board, *expected; /* expected: NULL: made from the machine's id */
    } CASES[] = {
        {NULL, NULL, NULL},
        {"0007\n", NULL, "0007"},
        {"0007\n", "10000000abcdef01", "0007"},
        {NULL, "10000000abcdef01", "10000000abcdef01"},
        {NULL, "0000000000000000", NULL},
        {"", "0000000000000000", NULL},
        {"\n0007\n", "RPI5", "RPI5"},
        {"Box 7\r\n", "RPI5", "Box7"},
        {"--\n", "12-ab_3 4", "12ab34"},
        {"\xc3\xa4\n", NULL, NULL},
        {"0\n", "1", "1"},
        {"00000000000000000000000000000000000001", NULL, NULL},
        {"123456789012345678901234567890123456789", NULL, "12345678901234567890123456789012"},
        {"no end of line", NULL, "noendofline"},
    };
    char sys[80], etc[80], ours[64], gadgets[64], made[64] = "";
    const struct box_host host = {.sys = sys, .etc = etc};

    (void)state;
    (void)snprintf(sys, sizeof sys, "%s/sys", root);
    (void)snprintf(etc, sizeof etc, "%s/etc", root);
    put("etc/machine-id", "0123456789abcdef0123456789abcdef\n");
    for (unsigned i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        put("etc/ttfbox/usb-serial", CASES[i].person);
        put("sys/firmware/devicetree/base/serial-number", CASES[i].board);
        box_host_serial(&host, ours);
        of_gadget(gadgets);
        assert_string_equal(ours, gadgets);
        if (CASES[i].expected) {
            assert_string_equal(ours, CASES[i].expected);
            continue;
        }
        assert_int_equal(strlen(ours), 12);
        if (*made)
            assert_string_equal(ours, made);
        memcpy(made, ours, sizeof made);
        assert_null(strstr("0123456789abcdef0123456789abcdef", ours)); /* the id is told nobody */
    }
}

static int make(void **state)
{
    (void)state;
    (void)snprintf(root, sizeof root, "/tmp/ttf-serial.XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}

static int remove_it(void **state)
{
    static const char *const NAMES[] = {"etc/machine-id",
                                        "etc/ttfbox/usb-serial",
                                        "sys/firmware/devicetree/base/serial-number",
                                        "etc/ttfbox",
                                        "etc",
                                        "sys/firmware/devicetree/base",
                                        "sys/firmware/devicetree",
                                        "sys/firmware",
                                        "sys",
                                        ""};
    char path[256];

    (void)state;
    for (unsigned i = 0; i < sizeof NAMES / sizeof *NAMES; i++) {
        (void)snprintf(path, sizeof path, "%s/%s", root, NAMES[i]);
        (void)remove(path);
    }
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_gadget_and_the_programs_call_a_box_the_same, make,
                                        remove_it),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
