/* SPDX-License-Identifier: Apache-2.0 */
/* scratch.h: a temporary folder of a test, and files in it. */
#ifndef SCRATCH_H
#define SCRATCH_H

#include <stddef.h>
#include <stdint.h>

/* cmocka set-up and tear-down: *state is the folder's path. */
int scratch_make(void **state);
int scratch_remove(void **state);

/* FOLDER/NAME, in a ring of a few buffers: good for the next few calls. */
const char *scratch_path(void **state, const char *name);

/* A new file of that name at the I/O table of the machine; asserts. */
int scratch_create(void **state, const char *name);

void scratch_write(void **state, const char *name, const void *bytes, size_t n);
/* To be freed. */
uint8_t *scratch_read(void **state, const char *name, size_t *ret_bytes);

/* Deterministic noise for tests: the next number of a 32-bit generator. */
uint32_t scratch_random(uint32_t *seed);

/* The folder of real data (TTFBOX_TEST_DATA, else ../shared/data from the tree or build), or NULL. */
const char *scratch_real_data(void);

#endif
