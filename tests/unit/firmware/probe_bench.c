/* SPDX-License-Identifier: Apache-2.0 */
#include "probe_bench.h"

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

int setup(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    char root[] = "/tmp/ttf-probe.XXXXXX";

    if (!b)
        return -1;
    assert_true(mkdtemp(root) != NULL);
    probe_machine_here(&b->machine, root);
    *state = b;
    return 0;
}

int teardown(void **state)
{
    struct bench *b = *state;
    char command[300];

    (void)snprintf(command, sizeof command, "rm -rf '%s'", b->machine.root);
    /* NOLINTNEXTLINE(cert-env33-c,concurrency-mt-unsafe): a test's own folder */
    assert_int_equal(system(command), 0);
    free(b);
    return 0;
}

static void make_folders(char *path)
{
    for (char *c = strchr(path + 1, '/'); c; c = strchr(c + 1, '/')) {
        *c = '\0';
        (void)mkdir(path, 0755);
        *c = '/';
    }
}

void put(const struct bench *b, const char *name, const char *text)
{
    char path[512];
    FILE *file;

    (void)probe_path(&b->machine, name, path);
    make_folders(path);
    file = fopen(path, "w");
    assert_true(file != NULL);
    fputs(text, file);
    (void)fclose(file);
}

void put_holder(const struct bench *b, const char *process, const char *name, const char *device)
{
    char file[128], path[512];

    (void)snprintf(file, sizeof file, "proc/%s/comm", process);
    put(b, file, name);
    (void)snprintf(file, sizeof file, "proc/%s/fd/", process);
    (void)probe_path(&b->machine, file, path);
    make_folders(path);
    (void)snprintf(path + strlen(path), 8, "7");
    assert_int_equal(symlink(device, path), 0);
}

void load(struct bench *b, const char *text)
{
    struct ttf_err err = {0};

    if (ttf_board_parse("b.yaml", text, strlen(text), NULL, 0, &b->board, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
}
const struct probe_finding *found(const struct bench *b, const char *text)
{
    for (unsigned i = 0; i < b->findings.n; i++)
        if (strstr(b->findings.finding[i].text, text)) {
            const struct probe_finding *f = &b->findings.finding[i];

            assert_true(strlen(f->text) < sizeof f->text - 1); /* none is cut short */
            assert_true(strlen(f->hint) < sizeof f->hint - 1);
            return f;
        }
    for (unsigned i = 0; i < b->findings.n; i++)
        print_message("    %s\n", b->findings.finding[i].text);
    fail_msg("nothing says '%s'", text);
    return &b->findings.finding[0];
}
