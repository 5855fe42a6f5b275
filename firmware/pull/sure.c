/* SPDX-License-Identifier: Apache-2.0 */
#include "sure.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static bool are_same(const char *a, size_t n_a, const char *b, size_t n_b)
{
    return n_a == n_b && memcmp(a, b, n_a) == 0;
}

int sure_text(struct wire *wire, const char *path, int64_t first, int64_t last, size_t max,
              const struct sure_known *known, char **ret_text, size_t *ret_bytes,
              struct ttf_err *err)
{
    char *text = NULL, *again = NULL;
    size_t n, n_again;
    int r = pull_wire_get_text(wire, path, first, last, max, &text, &n, err);

    if (r < 0)
        return r;
    if (!known->bytes || !are_same(text, n, known->bytes, known->n)) {
        r = pull_wire_get_text(wire, path, first, last, max, &again, &n_again, err);
        if (r == 0 && !are_same(text, n, again, n_again))
            r = ttf_err_set(err, -ECONNRESET, path, "came in two ways when it was asked for twice");
    }
    free(again);
    if (r < 0) {
        free(text);
        return r;
    }
    *ret_text = text;
    *ret_bytes = n;
    return 0;
}
