/* SPDX-License-Identifier: Apache-2.0 */
#include "derived.h"

#include <stdlib.h>

#include "charts.h"

struct derived *derived_create(void)
{
    struct derived *derived = calloc(1, sizeof *derived);

    if (!derived)
        return NULL;
    derived->charts = charts_create();
    if (derived->charts)
        return derived;
    derived_destroy(derived);
    return NULL;
}

void derived_destroy(struct derived *derived)
{
    if (!derived)
        return;
    charts_destroy(derived->charts);
    free(derived);
}
