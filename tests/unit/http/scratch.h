/* SPDX-License-Identifier: Apache-2.0 */
/* scratch.h: a folder that goes away at the end of a test. */
#ifndef TEST_HTTP_SCRATCH_H
#define TEST_HTTP_SCRATCH_H

#include <stddef.h>

/* Makes it and goes there (the test's own working folder). 0, or -1. For cmocka's setup. */
int scratch_make(void **state);

/* Removes it. */
int scratch_remove(void **state);

/* A file with these bytes, folders above it made. */
void scratch_file(const char *path, const void *bytes, size_t n);

#endif
