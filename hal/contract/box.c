/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/box.h"

#include <string.h>

void ttf_box_destroy(struct ttf_box *box)
{
    if (!box)
        return;
    if (box->destroy)
        box->destroy(box);
    memset(box, 0, sizeof(*box));
}
