/* SPDX-License-Identifier: Apache-2.0 */
/* hand_over_none.c: of `ttfbox-full`, which hands nothing over. */
#include <errno.h>

#include "hand_over.h"

bool cli_is_full(void)
{
    return true;
}

int cli_hand_over(struct cli *cli)
{
    return ttf_err_set(&cli->err, -ENOTSUP, NULL, "this program does it itself");
}
