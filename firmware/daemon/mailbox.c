/* SPDX-License-Identifier: Apache-2.0 */
#include "mailbox.h"

#include <stdio.h>

void mailbox_put(struct mailbox *box, const struct ttf_progress *progress)
{
    uint32_t in = __atomic_load_n(&box->in, __ATOMIC_RELAXED);
    struct letter *letter = &box->letters[in % MAILBOX_ROOM];

    if (in - __atomic_load_n(&box->out, __ATOMIC_ACQUIRE) == MAILBOX_ROOM) {
        (void)__atomic_add_fetch(&box->dropped, 1, __ATOMIC_RELAXED);
        return;
    }
    *letter = (struct letter){.kind = progress->kind,
                              .result = progress->result,
                              .until = progress->until,
                              .waits = progress->waits,
                              .lit_ns = progress->lit_ns,
                              .settled_ns = progress->settled_ns,
                              .run = box->run,
                              .index = progress->index,
                              .total = progress->total,
                              .now_ns = progress->now_ns,
                              .error_ns = progress->error_ns,
                              .wakeup_ns = progress->wakeup_ns};
    (void)snprintf(letter->text, sizeof letter->text, "%s", progress->text ? progress->text : "");
    __atomic_store_n(&box->in, in + 1, __ATOMIC_RELEASE);
}

bool mailbox_take(struct mailbox *box, struct letter *ret)
{
    uint32_t out = __atomic_load_n(&box->out, __ATOMIC_RELAXED);

    if (__atomic_load_n(&box->in, __ATOMIC_ACQUIRE) == out)
        return false;
    *ret = box->letters[out % MAILBOX_ROOM];
    __atomic_store_n(&box->out, out + 1, __ATOMIC_RELEASE);
    return true;
}

void mailbox_tell(struct mailbox *box)
{
    __atomic_store_n(&box->told, __atomic_load_n(&box->out, __ATOMIC_RELAXED), __ATOMIC_RELEASE);
}

bool mailbox_all_told(const struct mailbox *box)
{
    return __atomic_load_n(&box->told, __ATOMIC_ACQUIRE) ==
           __atomic_load_n(&box->in, __ATOMIC_RELAXED);
}

uint32_t mailbox_dropped(struct mailbox *box)
{
    return __atomic_exchange_n(&box->dropped, 0, __ATOMIC_RELAXED);
}
