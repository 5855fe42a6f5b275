/* SPDX-License-Identifier: Apache-2.0 */
/* dataset.json: what is accepted can be written, and read again as the same. */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "ttf/dataset/manifest.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_manifest *m = calloc(2, sizeof *m);
    char *text = NULL, *again = NULL;
    struct ttf_err err = {0};

    if (m && ttf_manifest_read((const char *)data, size, "dataset.json", &m[0], &err) == 0) {
        if (ttf_manifest_write(&m[0], &text, &err) < 0 ||
            ttf_manifest_read(text, strlen(text), "again", &m[1], &err) < 0 ||
            ttf_manifest_write(&m[1], &again, &err) < 0 || strcmp(text, again) != 0)
            abort();
        free(again);
        free(text);
    }
    free(m);
    return 0;
}
