/* SPDX-License-Identifier: Apache-2.0 */
/* The lamps' suite on a guardian behind a socket, in real time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

#include "conformance/conformance.h"
#include "lampd_fixture.h"
#include "pwm_tree.h"
#include "ttf/hal/pwm.h"

static void destroy(struct ttf_box *box)
{
    ttf_lamps_destroy(box->lamps);
    lampd_fixture_free(box->box_private);
}

static int make(struct ttf_box *ret)
{
    struct lampd_fixture *f = lampd_fixture_make();

    lampd_fixture_start(f);
    *ret = (struct ttf_box){.clock = f->clock, .box_private = f, .destroy = destroy};
    return ttf_lamps_lampd_create(f->socket, f->clock, &ret->lamps, NULL);
}

/* The same guardian with its lamps on PWM channels, and the door where it was. */
static struct pwm_tree tree;

static void destroy_dimmed(struct ttf_box *box)
{
    destroy(box);
    pwm_tree_free(&tree);
}

static int make_dimmed(struct ttf_box *ret)
{
    struct lampd_fixture *f = lampd_fixture_make();
    struct ttf_line_spec specs[LAMPD_LAMPS + 1];
    struct ttf_lines *banks[2], *joined = NULL;

    pwm_tree_make(&tree);
    for (unsigned i = 0; i < LAMPD_LAMPS; i++) {
        pwm_tree_export(&tree, i);
        specs[i] = (struct ttf_line_spec){.chip = "pwmchip0", .line = {(char)('0' + i)}};
        specs[i].period_ns = 50000;
        memcpy(specs[i].label, f->info[i].name, sizeof specs[i].label);
        f->info[i].kind = TTF_LAMP_PWM;
    }
    specs[LAMPD_LAMPS] = *ttf_lines_spec(f->lines, LAMPD_LAMPS);
    if (ttf_lines_pwm_create(tree.root, specs, LAMPD_LAMPS, &banks[0], NULL) < 0 ||
        ttf_lines_file_create(f->wires, &specs[LAMPD_LAMPS], 1, &banks[1], NULL) < 0 ||
        ttf_lines_joined_create(specs, LAMPD_LAMPS + 1, banks, 2, &joined, NULL) < 0)
        return -1;
    lampd_fixture_take_lines(f, joined);
    lampd_fixture_start(f);
    *ret = (struct ttf_box){.clock = f->clock, .box_private = f, .destroy = destroy_dimmed};
    return ttf_lamps_lampd_create(f->socket, f->clock, &ret->lamps, NULL);
}

int main(void)
{
    const struct conformance_factory lampd = {"lampd", make};
    const struct conformance_factory dimmed = {"lampd on PWM channels", make_dimmed};

    return conformance_lamps(&lampd) + conformance_lamps(&dimmed);
}
