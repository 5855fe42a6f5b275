/* SPDX-License-Identifier: Apache-2.0 */
/* derived.h: what a server remembers of what it derives from datasets, so that asking again costs little. */
#ifndef HTTP_DERIVED_H
#define HTTP_DERIVED_H

struct derived {
    struct history *history;
    struct thumbs *thumbs;
    struct listed *listed;
    struct pictures *pictures;
    int archives; /* being sent; atomic */
};

/* NULL: no memory. */
struct derived *derived_create(void);
void derived_destroy(struct derived *derived); /* NULL allowed */

#endif
