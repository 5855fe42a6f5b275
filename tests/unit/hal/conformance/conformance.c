/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>

#include "conformance.h"

int conformance_setup(void **state)
{
    const struct conformance_factory *factory = *state;
    struct ttf_box *box = calloc(1, sizeof(*box));

    if (!box || factory->make(box) < 0) {
        free(box);
        return -1;
    }
    *state = box;
    return 0;
}

int conformance_teardown(void **state)
{
    ttf_box_destroy(*state);
    free(*state);
    return 0;
}
