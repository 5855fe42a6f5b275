/* SPDX-License-Identifier: Apache-2.0 */
#include "pwm_tree.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define CHIP "class/pwm/pwmchip0"

static void whole(const struct pwm_tree *tree, const char *path, char ret[256])
{
    (void)snprintf(ret, 256, "%s/" CHIP "/%.128s", tree->root, path);
}

void pwm_tree_put(const struct pwm_tree *tree, const char *path, const char *text)
{
    char at[256];
    FILE *file;

    whole(tree, path, at);
    for (char *p = at + 1; (p = strchr(p, '/')) != NULL; p++) {
        *p = '\0';
        (void)mkdir(at, 0777);
        *p = '/';
    }
    file = fopen(at, "w");
    if (!file) {
        fail_msg("%s cannot be made", at);
        return;
    }
    fputs(text, file);
    (void)fclose(file);
}

int64_t pwm_tree_number(const struct pwm_tree *tree, const char *path)
{
    char at[256], text[32] = "";
    FILE *file;

    whole(tree, path, at);
    file = fopen(at, "r");
    if (!file)
        return -1;
    if (!fgets(text, sizeof text, file))
        text[0] = '\0';
    (void)fclose(file);
    return text[0] ? strtoll(text, NULL, 10) : -1;
}

void pwm_tree_remove(const struct pwm_tree *tree, const char *path)
{
    char at[256], command[300];

    whole(tree, path, at);
    (void)snprintf(command, sizeof command, "rm -rf '%s'", at);
    assert_int_equal(system(command), 0); /* NOLINT: of a folder that we made */
}

void pwm_tree_export(const struct pwm_tree *tree, unsigned channel)
{
    static const char *const FILES[][2] = {
        {"period", "0\n"}, {"duty_cycle", "0\n"}, {"enable", "0\n"}, {"polarity", "normal\n"}};
    char path[64];

    for (unsigned i = 0; i < sizeof FILES / sizeof *FILES; i++) {
        (void)snprintf(path, sizeof path, "pwm%u/%s", channel, FILES[i][0]);
        pwm_tree_put(tree, path, FILES[i][1]);
    }
}

void pwm_tree_make(struct pwm_tree *tree)
{
    char link[256];

    (void)snprintf(tree->root, sizeof tree->root, "/tmp/ttf-pwm.XXXXXX");
    assert_non_null(mkdtemp(tree->root));
    (void)chmod(tree->root, 0755);
    pwm_tree_put(tree, "npwm", "2\n");
    pwm_tree_put(tree, "export", "");
    whole(tree, "device", link);
    assert_int_equal(symlink("../../../devices/platform/fe20c000.pwm", link), 0);
}

void pwm_tree_free(const struct pwm_tree *tree)
{
    char command[96];

    (void)snprintf(command, sizeof command, "rm -rf '%s'", tree->root);
    assert_int_equal(system(command), 0); /* NOLINT: of a folder that we made */
}
