/* SPDX-License-Identifier: Apache-2.0 */
#include "derived.h"

#include <stdlib.h>

#include "history.h"
#include "listed.h"
#include "pictures.h"
#include "thumbs.h"

struct derived *derived_create(void)
{
    struct derived *derived = calloc(1, sizeof *derived);

    if (!derived)
        return NULL;
    derived->history = history_create();
    derived->thumbs = thumbs_create();
    derived->listed = listed_create();
    derived->pictures = pictures_create();
    if (derived->history && derived->thumbs && derived->listed && derived->pictures)
        return derived;
    derived_destroy(derived);
    return NULL;
}

void derived_destroy(struct derived *derived)
{
    if (!derived)
        return;
    pictures_destroy(derived->pictures);
    listed_destroy(derived->listed);
    thumbs_destroy(derived->thumbs);
    history_destroy(derived->history);
    free(derived);
}
