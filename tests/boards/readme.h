/* SPDX-License-Identifier: Apache-2.0 */
/* readme.h: what a board's README must have before somebody builds the box by it. */
#ifndef TTF_TESTS_BOARDS_README_H
#define TTF_TESTS_BOARDS_README_H

#include <stdbool.h>
#include <stddef.h>

/* A wire of the board's description: what it is called there, and its line's number. */
struct readme_wire {
    const char *label, *line;
};

/*
 * The first thing that is missing, into ret_fault; false: nothing. The drawing, the first block between ``` of "## Wiring",
 * has each wire by its name and its line.
 */
bool readme_draws(const char *text, const struct readme_wire *wires, unsigned n_wires,
                  char ret_fault[160]);

/* Each row of each table of the section `heading` begins with how many; at least `least` rows. */
bool readme_counts(const char *text, const char *heading, unsigned least, char ret_fault[160]);

/*
 * Each step of "## Wiring, step by step" and "## First power, step by step" has its check, and each wire is in a step of the
 * first.
 */
bool readme_checks(const char *text, const struct readme_wire *wires, unsigned n_wires,
                   char ret_fault[160]);

#endif
