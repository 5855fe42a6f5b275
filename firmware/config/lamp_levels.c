/* SPDX-License-Identifier: Apache-2.0 */
/* lamp_levels.c: see lamp_levels.h. */
#include "lamp_levels.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

int cfg_lamp_levels(const struct cfg_field *field, struct yaml_node *node,
                    struct ttf_lamp_level levels[TTF_LAMPS_MAX], unsigned *ret_n,
                    struct ttf_err *err)
{
    static const struct cfg_field LEVEL = {
        "level", cfg_unsigned_permille, 0, 0, 1000, "a lamp's level, as 80% or 800permille", 0, 0};
    unsigned n = 0;

    if (node->kind != YAML_MAP)
        return cfg_error(node, err, field->meant, "lamps and their levels are meant");
    if (node->n > TTF_LAMPS_MAX)
        return cfg_error(node, err, field->meant, "more than %d lamps", TTF_LAMPS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        int r = cfg_unsigned_permille(&LEVEL, c, &levels[n].permille, err);

        if (r < 0)
            return r;
        if (strlen(c->key) >= sizeof levels[n].lamp)
            return cfg_error_at_key(c, err, "names have at most 31 letters", "no lamp's name");
        memset(levels[n].lamp, 0, sizeof levels[n].lamp);
        memcpy(levels[n].lamp, c->key, strlen(c->key));
        c->used = true;
    }
    *ret_n = n;
    return 0;
}
