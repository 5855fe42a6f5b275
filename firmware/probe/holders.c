/* SPDX-License-Identifier: Apache-2.0 */
/*
 * holders.c: who has a GPIO line. Where libgpiod may not ask, or the machine is another one's files, there is the kernel's
 * list (/sys/kernel/debug/gpio, which root alone may read), a chip and its lines (gpiolib_dbg_show in the kernel's
 * drivers/gpio/gpiolib.c):
 *
 *   gpiochip0: GPIOs 512-569, parent: platform/fe200000.gpio, pinctrl-bcm2711:
 *    gpio-529 (GPIO17              |left                ) out lo
 *
 * Lines are counted from the first number of their chip; newer kernels write "58 GPIOs" and count from 0. Both names end
 * after 20 letters.
 */
#include "holders.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"

#define LISTED 20 /* letters of a name that the list has */

static bool is_listed_as(const char *listed, const char *whole)
{
    return strncmp(listed, whole, LISTED) == 0;
}

/* A field of the list without the spaces that fill it. */
static void take_field(const char *begin, const char *end, char ret[64])
{
    size_t n = (size_t)(end - begin);

    while (n > 0 && begin[n - 1] == ' ')
        n--;
    (void)snprintf(ret, 64, "%.*s", (int)(n < 63 ? n : 63), begin);
}

/* The heading of a chip: is it the one meant ("": any), and which number has its first line? */
static bool is_meant(char *heading, const char *chip, long *ret_first)
{
    char *colon = strchr(heading, ':'), *rest = NULL;
    bool meant;

    if (strncmp(chip, "/dev/", 5) == 0)
        chip += 5;
    *colon = '\0';
    meant = *chip == '\0' || strcmp(heading, chip) == 0;
    *ret_first = strncmp(colon + 1, " GPIOs ", 7) == 0 ? strtol(colon + 8, NULL, 10) : 0;
    for (char *part = strtok_r(colon + 1, ",", &rest); part && !meant;
         part = strtok_r(NULL, ",", &rest)) {
        part += strspn(part, " ");
        part[strcspn(part, "\n")] = '\0';
        if (*part && part[strlen(part) - 1] == ':') /* the last one */
            part[strlen(part) - 1] = '\0';
        meant = strcmp(part, chip) == 0;
    }
    return meant;
}

/* 1: the line meant, and it has a holder; 0: it is another, or free. */
static int read_entry(char *text, long first, const struct ttf_line_spec *wire, char ret[64])
{
    char *end_of_number, *open = strchr(text, '('), *bar = open ? strchr(open, '|') : NULL;
    char *end = bar ? strrchr(bar, ')') : NULL, called[64], *end_of_wanted;
    long number = strtol(text + strlen(" gpio-"), &end_of_number, 10);
    long wanted = strtol(wire->line, &end_of_wanted, 10);
    bool by_number = *wire->line && *end_of_wanted == '\0';

    if (!end || end_of_number == text + strlen(" gpio-"))
        return 0;
    take_field(open + 1, bar, called);
    if (by_number ? number - first != wanted : !is_listed_as(called, wire->line))
        return 0;
    take_field(bar + 1, end, ret);
    if (is_listed_as(ret, wire->label))
        (void)snprintf(ret, 64, "%s", wire->label); /* what was cut off is its own */
    return 1;
}

static int listed_holder(const struct probe_machine *m, const struct ttf_line_spec *wire,
                         char ret[64])
{
    char path[512], text[256];
    FILE *file = fopen(probe_path(m, "sys/kernel/debug/gpio", path), "re");
    bool on_chip = false;
    long first = 0;
    int r = 0;

    if (!file)
        return -EACCES;
    while (r == 0 && fgets(text, sizeof text, file)) {
        if (strncmp(text, "gpiochip", 8) == 0 && strchr(text, ':'))
            on_chip = is_meant(text, wire->chip, &first);
        else if (on_chip && strncmp(text, " gpio-", 6) == 0)
            r = read_entry(text, first, wire, ret);
    }
    (void)fclose(file);
    return r;
}

int probe_line_holder(const struct probe_machine *machine, const struct ttf_line_spec *wire,
                      char ret[64], struct ttf_err *err)
{
    int r = machine->line_holder ? machine->line_holder(wire, ret, err) : -EACCES;

    if (r >= 0 || r == -ENOENT)
        return r;
    r = listed_holder(machine, wire, ret);
    return r == -EACCES && !machine->line_holder ? 0 : r;
}
