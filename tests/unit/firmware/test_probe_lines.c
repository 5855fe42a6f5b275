/* SPDX-License-Identifier: Apache-2.0 */
/* test_probe_lines.c: wires that are something else, or somebody else's. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "probe_bench.h"

#define WIRES                                                                             \
    CAMERA "lamps:\n  left: {backend: gpiod, line: GPIO17}\n"                             \
           "  low: {backend: gpiod, line: GPIO1}\n  i2c: {backend: gpiod, line: GPIO2}\n" \
           "  serial: {backend: gpiod, chip: gpiochip0, line: 14}\n"                      \
           "  usb: {backend: gpiod, chip: cp2112_gpio, line: 2}\n"                        \
           "panel: {backend: gpiod, button: {line: GPIO9}}\n"

static void lines_of_a_pi_that_are_something_else_are_told(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    put(b, "dev/i2c-1", "");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 0); /* only a Pi's header is so */
    put(b, "proc/device-tree/model", "Raspberry Pi 5 Model B Rev 1.0");
    put(b, "proc/device-tree/hat/product", "Sense HAT");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 5);
    assert_int_equal(found(b, "ID EEPROM")->weight, PROBE_PROBLEM);
    assert_string_equal(found(b, "ID EEPROM")->about, "line low");
    assert_int_equal(found(b, "I2C bus")->weight, PROBE_PROBLEM);
    assert_int_equal(found(b, "SPI bus, which is switched off here")->weight, PROBE_NOTE);
    assert_int_equal(found(b, "serial console (UART), which is switched off")->weight, PROBE_NOTE);
    assert_int_equal(found(b, "a HAT is plugged on: Sense HAT")->weight, PROBE_NOTE);
}

static void a_lamp_on_a_pwm_channel_that_is_not_there_is_told(void **state)
{
    struct bench *b = *state;
    char link[512];

    load(b, CAMERA "lamps:\n"
                   "  left: {backend: gpiod, pwm: {chip: fe20c000.pwm, channel: 1, period: 50us}}\n"
                   "  right: {backend: gpiod, pwm: {chip: pwmchip3, channel: 2, period: 50us}}\n");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 2);
    assert_non_null(strstr(found(b, "no PWM chip fe20c000.pwm")->hint, "dtoverlay"));
    b->findings.n = 0;
    put(b, "sys/class/pwm/pwmchip3/npwm", "2");
    assert_int_equal(symlink("../../fe20c000.pwm",
                             probe_path(&b->machine, "sys/class/pwm/pwmchip3/device", link)),
                     0);
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 1); /* the left lamp's is found by its device */
    assert_string_equal(found(b, "has 2 channels: there is no channel 2")->about, "lamp right");
}

static void lines(struct bench *b)
{
    b->findings.n = 0;
    probe_lines(&b->machine, &b->board, &b->findings);
}

static void a_line_that_is_taken_says_by_whom(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    put(b, "sys/kernel/debug/gpio",
        "gpiochip0: GPIOs 512-565, parent: platform/fe200000.gpio, pinctrl-bcm2711:\n"
        " gpio-513 (GPIO1               |low                 ) out lo\n"
        " gpio-529 (GPIO17              |onewire@11          ) out hi\n"
        " gpio-521 (GPIO9               )\n");
    lines(b);
    assert_int_equal(b->findings.n,
                     1); /* the guardian's own, and free ones, are as they should be */
    assert_string_equal(found(b, "line GPIO17 is taken by 'onewire@11'")->about, "line left");
}

static void a_line_is_found_by_its_number_on_its_chip(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    /* The chip's number is no matter: its first line's is 500. Chips are known by number or label. */
    put(b, "sys/kernel/debug/gpio",
        "gpiochip1: GPIOs 2-5, gpio-mockup-A:\n"
        " gpio-4   (                    |other               ) in  lo\n"
        "\ngpiochip3: GPIOs 500-507, parent: usb/1-1:1.0, cp2112_gpio, can sleep:\n"
        " gpio-502 (                    |w1                  ) out hi ACTIVE LOW\n"
        " gpio-503 (                    |mine                ) out hi\n");
    lines(b);
    assert_int_equal(b->findings.n, 1);
    assert_string_equal(found(b, "line 2 of chip cp2112_gpio is taken by 'w1'")->about, "line usb");
    /* Kernels that count from 0. */
    put(b, "sys/kernel/debug/gpio",
        "gpiochip0: 54 GPIOs, parent: platform/soc:gpio, pinctrl-bcm2711:\n"
        " gpio-14  (TXD1                |bt                  ) out hi\n"
        "gpiochip1: 2 GPIOs, brcmvirt-gpio, can sleep:\n"
        " gpio-14  (                    |none                ) out hi\n");
    lines(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "line 14 of chip gpiochip0 is taken by 'bt'");
}

#define LONG                                                                       \
    CAMERA "lamps:\n  a-lamp-of-twenty-five-let: {backend: gpiod, line: GPIO17}\n" \
           "  left: {backend: gpiod, line: a-line-of-twenty-five-let}\n"

static void names_that_the_kernels_list_cuts_off_are_known(void **state)
{
    struct bench *b = *state;

    load(b, LONG);
    put(b, "sys/kernel/debug/gpio",
        "gpiochip0: GPIOs 512-565, parent: platform/fe200000.gpio, pinctrl-bcm2711:\n"
        " gpio-529 (GPIO17              |a-lamp-of-twenty-fiv) out lo\n"
        " gpio-530 (a-line-of-twenty-fiv|spi                 ) out lo\n");
    lines(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "line a-line-of-twenty-five-let is taken by 'spi'");
}

/* ---- the kernel is asked ---- */

static int told(const struct ttf_line_spec *spec, char ret_holder[64], struct ttf_err *err)
{
    const char *holder = strcmp(spec->label, "left") == 0  ? "onewire@11"
                         : strcmp(spec->label, "low") == 0 ? "low"
                         : strcmp(spec->label, "usb") == 0 ? ""
                                                           : NULL;

    if (strcmp(spec->label, "serial") == 0) {
        ttf_err_set(err, -ENOENT, spec->label, "no GPIO line is called '%s'", spec->line);
        return ttf_err_hint(err, "gpioinfo lists them"), -ENOENT;
    }
    if (holder)
        (void)snprintf(ret_holder, 64, "%s", holder);
    return holder != NULL;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the kernel's, as probe_machine has it */
static int denied(const struct ttf_line_spec *spec, char ret_holder[64], struct ttf_err *err)
{
    (void)ret_holder;
    return ttf_err_set(err, -EACCES, spec->label, "no permission");
}

static void the_kernel_is_asked_first(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    b->machine.line_holder = told;
    put(b, "sys/kernel/debug/gpio",
        "gpiochip0: GPIOs 512-565, pinctrl-bcm2711:\n"
        " gpio-529 (GPIO17              |left                ) out lo\n");
    lines(b);
    assert_int_equal(b->findings.n, 3);
    assert_string_equal(found(b, "line GPIO17 is taken by 'onewire@11'")->about, "line left");
    (void)found(b, "line 2 of chip cp2112_gpio is taken by the kernel itself");
    assert_string_equal(found(b, "no GPIO line is called '14'")->hint, "gpioinfo lists them");
}

static void who_may_not_ask_reads_the_list_or_is_told_so_once(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    b->machine.line_holder = denied;
    lines(b);
    assert_int_equal(b->findings.n, 1);
    assert_int_equal(found(b, "is not told to whoever runs this")->weight, PROBE_NOTE);
    put(b, "sys/kernel/debug/gpio",
        "gpiochip0: GPIOs 512-565, pinctrl-bcm2711:\n"
        " gpio-529 (GPIO17              |onewire@11          ) out lo\n");
    lines(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "line GPIO17 is taken by 'onewire@11'");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_FILES(lines_of_a_pi_that_are_something_else_are_told),
        ON_FILES(a_lamp_on_a_pwm_channel_that_is_not_there_is_told),
        ON_FILES(a_line_that_is_taken_says_by_whom),
        ON_FILES(a_line_is_found_by_its_number_on_its_chip),
        ON_FILES(names_that_the_kernels_list_cuts_off_are_known),
        ON_FILES(the_kernel_is_asked_first),
        ON_FILES(who_may_not_ask_reads_the_list_or_is_told_so_once),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
