/* SPDX-License-Identifier: Apache-2.0 */
/* probe_bench.h: a machine made of files, a board, and what is said of them. */
#ifndef PROBE_BENCH_H
#define PROBE_BENCH_H

#include "files.h"
#include "probe.h"

struct bench {
    struct probe_machine machine;
    struct ttf_board board;
    struct probe_findings findings;
};

#define LIBCAMERA "board: t\ncameras: {main: {backend: libcamera}}\nclock: {backend: machine}\n"
#define CAMERA    "board: t\ncameras: {main: {backend: v4l2}}\nclock: {backend: machine}\n"

#define ON_FILES(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int setup(void **state);
int teardown(void **state);

/* A file of the machine, its folders too. */
void put(const struct bench *b, const char *name, const char *text);

/* A process that has a device open. */
void put_holder(const struct bench *b, const char *process, const char *name, const char *device);

/* The board, from its text. */
void load(struct bench *b, const char *text);

/* The finding that says this, in full; there must be one. */
const struct probe_finding *found(const struct bench *b, const char *text);

#endif
