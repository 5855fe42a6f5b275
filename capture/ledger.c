/* SPDX-License-Identifier: Apache-2.0 */
#include "ledger.h"

#include <errno.h>
#include <stdio.h>

#include "ttf/base/time.h"

void ttf_ledger_judge(struct ttf_slot_record *record)
{
    const struct ttf_image *lacking = NULL;
    unsigned taken = 0;

    if (record->n_images == 0)
        return;
    for (unsigned i = 0; i < record->n_images; i++) {
        if (record->images[i].lacking[0] == '\0')
            taken++;
        else if (!lacking)
            lacking = &record->images[i];
    }
    if (!lacking)
        record->result = TTF_RESULT_CAPTURED;
    else
        record->result = taken > 0 ? TTF_RESULT_PARTIAL : TTF_RESULT_FAILED;
    if (lacking)
        snprintf(record->reason, sizeof(record->reason), "%s", lacking->lacking);
}

int ttf_ledger_add(struct ttf_ledger *ledger, const struct ttf_slot_record *record)
{
    if (record->index < ledger->next_index)
        return -EEXIST;
    if (record->index > ledger->next_index)
        return -ERANGE;
    ledger->next_index++;
    ledger->counts[record->result]++;
    if (record->result == TTF_RESULT_CAPTURED && record->middle_ns != TTF_NS_UNKNOWN)
        ttf_quantile_add(&ledger->error, record->middle_ns - record->due_ns);
    return 0;
}
