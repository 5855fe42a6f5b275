/* SPDX-License-Identifier: Apache-2.0 */
#include "names.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int names_add(struct names *names, const char *name, size_t n_bytes)
{
    if (!names->bytes || names->n_bytes + n_bytes + 1 > names->room) {
        size_t room = 2 * (names->room + n_bytes + 1);
        char *more = realloc(names->bytes, room);

        if (!more)
            return -ENOMEM;
        names->bytes = more;
        names->room = room;
    }
    memcpy(names->bytes + names->n_bytes, name, n_bytes);
    names->bytes[names->n_bytes + n_bytes] = '\0';
    names->n_bytes += n_bytes + 1;
    names->n++;
    return 0;
}

void names_free(struct names *names)
{
    free(names->bytes);
    memset(names, 0, sizeof *names);
}

const char *names_first(const struct names *names)
{
    return names->n > 0 ? names->bytes : NULL;
}

const char *names_next(const struct names *names, const char *name)
{
    name += strlen(name) + 1;
    return name < names->bytes + names->n_bytes ? name : NULL;
}
