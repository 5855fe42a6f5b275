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

/* The whole text of FOLDER/README.md, to be freed. */
static char *readme(const struct board *b)
{
    char path[300];
    char *text = calloc(1, 65536);
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/README.md", b->folder);
    file = fopen(path, "r");
    if (!file || !text || fread(text, 1, 65535, file) == 0)
        fail_msg("%s has no README.md", b->b.name);
    if (file)
        (void)fclose(file);
    return text;
}

static void every_real_board_says_what_was_tried_and_how_its_lamps_are_safe(void **state)
{
    static const char *const WORDS[] = {"described", "built for it", "booted", "on real hardware"};

    (void)state;
    for (unsigned k = 0; k < n_boards; k++) {
        bool burns = strcmp(boards[k].b.name, "qemu-virt-arm64") != 0;
        char *text;

        if (!boards[k].b.real)
            continue;
        text = readme(&boards[k]);
        for (unsigned i = 0; i < TTF_COUNT_OF(WORDS); i++)
            if (!strstr(text, WORDS[i]))
                fail_msg("%s: its README does not say '%s'", boards[k].b.name, WORDS[i]);
        if (burns && (!strstr(text, "(../LAMPS.md)") || !strstr(text, "## Checks, step by step") ||
                      !strstr(text, "## Parts") || !strstr(text, "## Wiring")))
            fail_msg("%s: its README lacks wiring, parts or checks", boards[k].b.name);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_boards_that_the_documents_name_are_there),
        cmocka_unit_test(a_board_is_simulated_or_real_and_not_both),
        cmocka_unit_test(every_real_lamp_has_a_limit_and_every_real_box_an_owner),
        cmocka_unit_test(a_raspberry_pi_says_that_it_is_one),
        cmocka_unit_test(every_real_board_says_what_was_tried_and_how_its_lamps_are_safe),
    };

    return cmocka_run_group_tests(tests, load_all, NULL);
}
