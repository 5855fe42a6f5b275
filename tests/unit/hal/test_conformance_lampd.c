/* SPDX-License-Identifier: Apache-2.0 */
/* The lamps' suite on a guardian behind a socket, in real time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "conformance/conformance.h"
#include "lampd_fixture.h"

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

int main(void)
{
    const struct conformance_factory lampd = {"lampd", make};

    return conformance_lamps(&lampd);
}
