/* SPDX-License-Identifier: Apache-2.0 */
/* test_boards.c: every board that comes with the program, held to the rules of boards/README.md. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/base/attr.h"
#include "ttf/config/board_file.h"

#include "boards/readme.h"

#define BOARDS_MAX 32

static struct board {
    char folder[256];
    struct ttf_board b;
} boards[BOARDS_MAX];
static unsigned n_boards;

static int load_all(void **state)
{
    DIR *dir = opendir(BOARDS);
    const struct dirent *entry;

    (void)state;
    if (!dir)
        return -1;
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
    while ((entry = readdir(dir)) != NULL && n_boards < BOARDS_MAX) {
        struct board *b = &boards[n_boards];
        struct ttf_err err = {0};
        char path[300];

        (void)snprintf(b->folder, sizeof b->folder, "%s/%.100s", BOARDS, entry->d_name);
        (void)snprintf(path, sizeof path, "%s/board.yaml", b->folder);
        if (entry->d_name[0] == '.' || access(path, R_OK) < 0)
            continue;
        if (ttf_board_load(path, NULL, 0, &b->b, &err) < 0) {
            print_error("%s: %s; %s\n", err.where, err.what, err.hint);
            return -1;
        }
        if (strcmp(b->b.name, entry->d_name) != 0) {
            print_error("%s calls itself %s\n", path, b->b.name);
            return -1;
        }
        n_boards++;
    }
    (void)closedir(dir);
    return 0;
}

static void the_boards_that_the_documents_name_are_there(void **state)
{
    static const char *const NAMES[] = {"sim",  "sim-small", "qemu-virt-arm64", "pc-uvc",
                                        "rpi4", "rpi5",      "rpi-zero2w"};

    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(NAMES); i++) {
        bool there = false;

        for (unsigned k = 0; k < n_boards; k++)
            there |= strcmp(boards[k].b.name, NAMES[i]) == 0;
        if (!there)
            fail_msg("there is no board %s", NAMES[i]);
    }
}

static void a_board_is_simulated_or_real_and_not_both(void **state)
{
    (void)state;
    for (unsigned k = 0; k < n_boards; k++)
        if (boards[k].b.simulated == boards[k].b.real)
            fail_msg("%s is %s", boards[k].b.name, boards[k].b.real ? "both" : "neither");
}

static void every_real_lamp_has_a_limit_and_every_real_box_an_owner(void **state)
{
    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        const struct ttf_board *b = &boards[k].b;

        if (!b->real)
            continue;
        if (!*b->lock)
            fail_msg("%s has no lock", b->name);
        if (!b->device[TTF_DEVICE_WATCHDOG])
            fail_msg("%s has no watchdog", b->name);
        for (unsigned i = 0; i < b->sim.n_lamps; i++)
            if (b->sim.lamps[i].info.max_on_ns == 0)
                fail_msg("%s: lamp %s may burn for ever", b->name, b->sim.lamps[i].info.name);
    }
}

static void a_raspberry_pi_says_that_it_is_one(void **state)
{
    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        const struct ttf_board_machine *m = &boards[k].b.machine;

        if (strncmp(boards[k].b.name, "rpi", 3) == 0 &&
            (m->header != TTF_HEADER_RASPBERRY_PI || strncmp(m->model, "Raspberry Pi", 12) != 0))
            fail_msg("%s: lines that are something else are not refused", boards[k].b.name);
    }
}

/* Its lamps are more than a chip in an emulator. */
static bool burns(const struct ttf_board *b)
{
    return strcmp(b->name, "qemu-virt-arm64") != 0;
}

/* The whole text of FOLDER/NAME, to be freed. */
static char *text_of(const struct board *b, const char *name)
{
    char path[400];
    char *text = calloc(1, 65536);
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/%s", b->folder, name);
    file = fopen(path, "r");
    if (!file || !text || fread(text, 1, 65535, file) == 0)
        fail_msg("%s has no %s", b->b.name, name);
    if (file)
        (void)fclose(file);
    return text;
}

/* All of its lamps', its door's and its panel's. */
static unsigned wires_of(const struct ttf_board *b, struct readme_wire ret[2 * TTF_LINES_MAX])
{
    unsigned n = 0;

    for (unsigned i = 0; i < b->guardian.n_wires; i++)
        ret[n++] = (struct readme_wire){b->guardian.wires[i].label, b->guardian.wires[i].line};
    for (unsigned i = 0; i < b->panel.n_wires; i++)
        ret[n++] = (struct readme_wire){b->panel.wires[i].label, b->panel.wires[i].line};
    for (unsigned i = 0; i < n; i++) /* "GPIO17" is 17 to who looks at a header */
        ret[i].line += strcspn(ret[i].line, "0123456789");
    return n;
}

static void every_real_board_can_be_built_by_its_readme(void **state)
{
    struct readme_wire wires[2 * TTF_LINES_MAX];
    char fault[160];

    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        unsigned n = wires_of(&boards[k].b, wires);
        char *text;

        if (!boards[k].b.real)
            continue;
        text = text_of(&boards[k], "README.md");
        if (readme_draws(text, wires, n, fault))
            fail_msg("%s: %s", boards[k].b.name, fault);
        if (burns(&boards[k].b) &&
            (readme_counts(text, "## Parts", 5, fault) || readme_checks(text, wires, n, fault)))
            fail_msg("%s: %s", boards[k].b.name, fault);
        free(text);
    }
}

static void a_port_that_also_feeds_the_board_is_wired_without_vbus(void **state)
{
    unsigned n = 0;

    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        const struct ttf_board_machine *m = &boards[k].b.machine;
        char *text;

        if (!m->usb_powers || m->usb_role != TTF_USB_DEVICE)
            continue;
        n++;
        text = text_of(&boards[k], "README.md");
        if (!strstr(text, "VBUS wire is cut") || !strstr(text, "VBUS contact"))
            fail_msg("%s: two supplies may meet", boards[k].b.name);
        free(text);
    }
    assert_int_equal(n, 3); /* every Raspberry Pi */
}

static void every_real_board_says_what_it_runs_and_what_it_is_on_the_bus(void **state)
{
    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        const struct ttf_board *b = &boards[k].b;

        if (!b->real)
            continue;
        if (!b->units)
            fail_msg("%s names no services: its image would run none", b->name);
        if ((b->machine.usb_role == TTF_USB_DEVICE) != (b->gadget != 0))
            fail_msg("%s: its port and its gadget are not of one mind", b->name);
    }
}

static void every_real_boards_port_can_be_set_to_be_another(void **state)
{
    static const char *const ROLES[] = {"host", "none"};

    (void)state;
    for (unsigned k = 0; k < 2 * n_boards; k++) {
        const struct ttf_board_set set = {"machine.usb_role", ROLES[k % 2]};
        static struct ttf_board other;
        struct ttf_err err = {0};
        char path[300];

        (void)snprintf(path, sizeof path, "%s/board.yaml", boards[k / 2].folder);
        if (boards[k / 2].b.real && ttf_board_load(path, &set, 1, &other, &err) < 0)
            fail_msg("%s as %s: %s: %s; %s", path, set.value, err.where, err.what, err.hint);
    }
}

static void the_lamps_circuit_says_how_many_of_each_part(void **state)
{
    struct board lamps = {.folder = BOARDS};
    char *text = text_of(&lamps, "LAMPS.md"), fault[160];

    (void)state;
    if (readme_counts(text, "## Parts", 8, fault))
        fail_msg("LAMPS.md: %s", fault);
    free(text);
}

#define STEPS                                                                                     \
    "## Wiring, step by step\n\nAll off.\n\n1. **Left**. **Check:** 10 kohm\n   at 17.\n2. b. "   \
    "**Check:** c\n3. d\n   **Check:** e\n\n## First power, step by step\n\n1. **Check:** a\n2. " \
    "**Check:** b\n3. **Check:** c\n"
#define WIRING "## Wiring\n\n```\nleft 17 - R1\n```\n"
#define PARTS  "## Parts\n\n| how many | part |\n|---|---|\n| 2 | lamp |\n| 1, if wished | disk |\n"

/* The rules themselves: what a README may not be. */
static void a_readme_without_a_check_a_number_or_a_wire_is_refused(void **state)
{
    static const struct readme_wire WIRE = {"left", "17"}, OTHER = {"left", "7"},
                                    DOOR = {"door", "17"};
    char fault[160];

    (void)state;
    assert_false(readme_draws("# B\n" WIRING STEPS, &WIRE, 1, fault));
    assert_true(readme_draws("# B\n" WIRING STEPS, &OTHER, 1, fault));
    assert_true(readme_draws("# B\n" WIRING STEPS, &DOOR, 1, fault));
    assert_true(readme_draws("# B\n## Wiring\n\n| left | 17 |\n" STEPS, &WIRE, 1, fault));
    assert_false(readme_counts("# B\n" PARTS STEPS, "## Parts", 2, fault));
    assert_true(readme_counts("# B\n" PARTS STEPS, "## Parts", 3, fault));
    assert_true(readme_counts("# B\n" PARTS "| LED | one |\n" STEPS, "## Parts", 2, fault));
    assert_true(readme_counts("# B\n## Parts\n\nA lamp; a disk.\n" STEPS, "## Parts", 1, fault));
    assert_false(readme_checks("# B\n" WIRING STEPS, &WIRE, 1, fault));
    assert_true(readme_checks("# B\n" WIRING STEPS, &DOOR, 1, fault));
    assert_true(readme_checks("# B\n" WIRING STEPS "4. e\n", &WIRE, 1, fault));
    assert_true(readme_checks("# B\n" WIRING, &WIRE, 1, fault));
}

static void every_real_board_says_what_was_tried_and_how_its_lamps_are_safe(void **state)
{
    static const char *const WORDS[] = {"described", "built for it", "booted", "on real hardware"};

    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        char *text;

        if (!boards[k].b.real)
            continue;
        text = text_of(&boards[k], "README.md");
        for (unsigned i = 0; i < TTF_COUNT_OF(WORDS); i++)
            if (!strstr(text, WORDS[i]))
                fail_msg("%s: its README does not say '%s'", boards[k].b.name, WORDS[i]);
        if (burns(&boards[k].b) && !strstr(text, "(../LAMPS.md)"))
            fail_msg("%s: its README does not say where the lamps' circuit is", boards[k].b.name);
        free(text);
    }
}

/* Whether "gpio=17,27=op,dl" drives a line to that level from the firmware on. */
static bool driven_at_boot(const char *config, const char *line, bool high)
{
    const char *number = line + strcspn(line, "0123456789");
    const size_t n = strlen(number);
    const char *at = config;

    while ((at = strstr(at, "\ngpio=")) != NULL) {
        const char *p = at + 6, *level = strstr(at + 6, high ? "=op,dh\n" : "=op,dl\n");

        at = p;
        if (!level || memchr(p, '\n', (size_t)(level - p)))
            continue;
        for (; p < level; p += strcspn(p, ",=") + 1)
            if (strncmp(p, number, n) == 0 && (p[n] == ',' || p[n] == '='))
                return true;
    }
    return false;
}

static void an_image_says_what_it_is_made_of(void **state)
{
    static const char *const KEYS[] = {
        "\narch=", "\nfirmware=", "\nkernel=", "\npackages=", "\ncmdline=", "\nmissing="};
    char path[400];

    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        char *text;

        if (!boards[k].b.real)
            continue;
        (void)snprintf(path, sizeof path, "%.255s/image/image.conf", boards[k].folder);
        if (access(path, R_OK) < 0)
            fail_msg("%s: nothing says how its image is made", boards[k].b.name);
        text = text_of(&boards[k], "image/image.conf");
        for (unsigned i = 0; i < TTF_COUNT_OF(KEYS); i++)
            if (!strstr(text, KEYS[i]))
                fail_msg("%s: its image has no '%s'", boards[k].b.name, KEYS[i] + 1);
        free(text);
    }
}

static void a_raspberry_pi_s_lamps_are_dark_from_its_firmware_on(void **state)
{
    static const char *const WORDS[] = {"\ndtoverlay=i2c-rtc,ds3231\n", "\ndtparam=i2c_arm=on\n",
                                        "\ndtoverlay=i2c-sensor,bme280\n",
                                        "\ndtparam=watchdog=on\n"};

    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        const struct ttf_board *b = &boards[k].b;
        char *config, *module;

        if (b->machine.header != TTF_HEADER_RASPBERRY_PI)
            continue;
        config = text_of(&boards[k], "image/boot/config.txt");
        module = text_of(&boards[k], "image/root/etc/modprobe.d/ttfbox-camera.conf");
        for (unsigned i = 0; i < b->sim.n_lamps; i++)
            if (!driven_at_boot(config, b->guardian.wires[i].line, b->guardian.wires[i].active_low))
                fail_msg("%s: %s may burn while it boots", b->name, b->sim.lamps[i].info.name);
        for (unsigned i = 0; i < TTF_COUNT_OF(WORDS); i++)
            if (!strstr(config, WORDS[i]))
                fail_msg("%s: its firmware is not told '%s'", b->name, WORDS[i] + 1);
        /* Its own clock, which has no battery as it is sold, would be the one that sets the time. */
        if (strcmp(b->machine.model, "Raspberry Pi 5") == 0 &&
            !strstr(config, "\ndtparam=rtc=off\n"))
            fail_msg("%s: the DS3231 is its second clock, which nobody asks", b->name);
        /* The port's role: as the board says. */
        if ((b->machine.usb_role == TTF_USB_DEVICE) !=
            (strstr(config, "\ndtoverlay=dwc2,dr_mode=peripheral") != NULL))
            fail_msg("%s: its port is not what the board says", b->name);
        if (!strstr(module, "\noptions imx477 dpc_enable=0"))
            fail_msg("%s: a sensor repairs its pixels by itself", b->name);
        free(config);
        free(module);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_boards_that_the_documents_name_are_there),
        cmocka_unit_test(a_board_is_simulated_or_real_and_not_both),
        cmocka_unit_test(every_real_lamp_has_a_limit_and_every_real_box_an_owner),
        cmocka_unit_test(a_raspberry_pi_says_that_it_is_one),
        cmocka_unit_test(an_image_says_what_it_is_made_of),
        cmocka_unit_test(a_raspberry_pi_s_lamps_are_dark_from_its_firmware_on),
        cmocka_unit_test(every_real_board_can_be_built_by_its_readme),
        cmocka_unit_test(a_port_that_also_feeds_the_board_is_wired_without_vbus),
        cmocka_unit_test(every_real_board_says_what_it_runs_and_what_it_is_on_the_bus),
        cmocka_unit_test(every_real_boards_port_can_be_set_to_be_another),
        cmocka_unit_test(the_lamps_circuit_says_how_many_of_each_part),
        cmocka_unit_test(a_readme_without_a_check_a_number_or_a_wire_is_refused),
        cmocka_unit_test(every_real_board_says_what_was_tried_and_how_its_lamps_are_safe),
    };

    return cmocka_run_group_tests(tests, load_all, NULL);
}
