/* SPDX-License-Identifier: Apache-2.0 */
/*
 * run_seeds.c: a fuzz target as a plain test, for compilers without a fuzzer: every file of the
 * folder given, as it is, cut short at each of some places, and with bytes changed at random, the
 * same on each run.
 */
#include <dirent.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

#define CUTS 24
#ifndef MUTATIONS
#define MUTATIONS 800 /* CMakeLists.txt gives targets fewer that take long for each */
#endif
#define SEED_MAX (1 << 20)

/* xorshift64: Marsaglia, "Xorshift RNGs" (2003), section 3. */
static uint64_t next(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

/* On a copy of exactly that size, so that a read beyond its end is seen. */
static void give(const uint8_t *data, size_t n)
{
    uint8_t *copy = malloc(n ? n : 1);

    if (!copy)
        abort();
    memcpy(copy, data, n);
    (void)LLVMFuzzerTestOneInput(copy, n);
    free(copy);
}

static void mutate(uint8_t *data, size_t n, uint64_t *state)
{
    static const uint8_t ODD[] = {0, 1, 0x7f, 0x80, 0xff, '-', '9', '{'};
    unsigned changes = 1 + (unsigned)(next(state) % 4);

    for (unsigned i = 0; i < changes; i++) {
        uint64_t r = next(state);
        /* Headers matter most: half of the changes are made in the first 256 bytes. */
        size_t at = (size_t)(r >> 16) % (r & 1 || n < 256 ? n : 256);

        data[at] = r & 2 ? ODD[r >> 8 & 7] : (uint8_t)(data[at] ^ 1u << (r >> 8 & 7));
    }
}

static void run_file(const uint8_t *seed, size_t n)
{
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15);
    uint8_t *data = malloc(n ? n : 1);

    if (!data)
        abort();
    give(seed, n);
    for (size_t i = 0; i < CUTS; i++)
        give(seed, n * i / CUTS);
    for (unsigned i = 0; n > 0 && i < MUTATIONS; i++) {
        memcpy(data, seed, n);
        mutate(data, n, &state);
        give(data, n);
    }
    free(data);
}

static size_t load(const char *path, uint8_t *data)
{
    FILE *file = fopen(path, "rb");
    size_t n;

    if (!file) {
        perror(path);
        exit(1);
    }
    n = fread(data, 1, SEED_MAX, file);
    (void)fclose(file);
    return n;
}

int main(int argc, char **argv)
{
    DIR *folder = argc == 2 ? opendir(argv[1]) : NULL;
    uint8_t *data = malloc(SEED_MAX);
    struct dirent *entry;
    unsigned n = 0;

    if (!folder || !data) {
        (void)fprintf(stderr, "usage: %s FOLDER-OF-SEEDS\n", argv[0]);
        return 2;
    }
    while ((entry = readdir(folder))) { /* NOLINT(concurrency-mt-unsafe): one thread runs */
        char path[PATH_MAX];

        if (entry->d_name[0] == '.')
            continue;
        (void)snprintf(path, sizeof path, "%s/%s", argv[1], entry->d_name);
        run_file(data, load(path, data));
        n++;
    }
    (void)closedir(folder);
    free(data);
    (void)printf("%u seeds, each with %d cuts and %d changed copies\n", n, CUTS, MUTATIONS);
    return n > 0 ? 0 : 1; /* a test of nothing is no test */
}
