/* SPDX-License-Identifier: Apache-2.0 */
/* pwm_tree.h: a folder laid out like /sys with one PWM chip in it, for tests. */
#ifndef TTF_TESTS_PWM_TREE_H
#define TTF_TESTS_PWM_TREE_H

#include <stdint.h>

struct pwm_tree {
    char root[64];
};

/* Chip pwmchip0, device fe20c000.pwm, two channels, none of them exported. The test fails if it cannot be made. */
void pwm_tree_make(struct pwm_tree *tree);
void pwm_tree_free(const struct pwm_tree *tree);

/* What exporting would make: period 0, dark. */
void pwm_tree_export(const struct pwm_tree *tree, unsigned channel);

/* text becomes pwmchip0/PATH. */
void pwm_tree_put(const struct pwm_tree *tree, const char *path, const char *text);

/* The number in pwmchip0/PATH; -1: it cannot be read. */
int64_t pwm_tree_number(const struct pwm_tree *tree, const char *path);

/* pwmchip0/PATH goes, and what is below it. */
void pwm_tree_remove(const struct pwm_tree *tree, const char *path);

#endif
