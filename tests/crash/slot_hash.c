/* SPDX-License-Identifier: Apache-2.0 */
#include "slot_hash.h"

#include <stdlib.h>

#include "record_line.h"

uint64_t slot_hash(const struct ttf_slot_record *record)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    struct ttf_json json;
    const char *text;
    size_t n, i;

    ttf_line_begin(&json, "slot", 0);
    ttf_slot_put(&json, record);
    if (ttf_line_finish(&json, &text, &n) != 0)
        abort();
    for (i = 0; i < n; i++)
        hash = (hash ^ (unsigned char)text[i]) * UINT64_C(0x100000001b3);
    ttf_json_free(&json);
    return hash;
}
