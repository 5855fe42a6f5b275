/* SPDX-License-Identifier: Apache-2.0 */
#include "faults.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>

#define ONCE(e)                  \
    {                            \
        .error = (e), .lasts = 1 \
    }
#define TIMES(e, n)                \
    {                              \
        .error = (e), .lasts = (n) \
    }
#define COUNT(h, e)                          \
    {                                        \
        .error = (e), .lasts = 1, .how = (h) \
    }

const struct fault_kind fault_kinds[] = {
    {.name = "EIO once", .fault = ONCE(EIO), .quick = true},
    {.name = "EIO once, but done",
     .fault = COUNT(FAIL_AFTER, EIO),
     .changes_only = true,
     .quick = true},
    {.name = "ENOSPC once", .fault = ONCE(ENOSPC), .changes_only = true},
    {.name = "EDQUOT once", .fault = ONCE(EDQUOT), .changes_only = true},
    {.name = "EROFS once", .fault = ONCE(EROFS), .changes_only = true},
    {.name = "EINTR once", .fault = ONCE(EINTR), .interruptible_only = true},
    {.name = "a short count", .fault = COUNT(SHORT_ONCE, 0), .transfers_only = true},
    {.name = "two short counts", .fault = COUNT(SHORT_TWICE, 0), .transfers_only = true},
    {.name = "a short count, then EIO",
     .fault = COUNT(SHORT_THEN_ERROR, EIO),
     .transfers_only = true},
    {.name = "a short count, then ENOSPC",
     .fault = COUNT(SHORT_THEN_ERROR, ENOSPC),
     .changes_only = true,
     .transfers_only = true},
    {.name = "EIO 3 times", .fault = TIMES(EIO, 3), .quick = true},
    {.name = "EIO 12 times", .fault = TIMES(EIO, 12)},
    {.name = "ENOSPC 12 times", .fault = TIMES(ENOSPC, 12), .changes_only = true},
    {.name = "EIO from then on", .fault = TIMES(EIO, LONG_MAX)},
    {.name = "ENOSPC from then on", .fault = TIMES(ENOSPC, LONG_MAX), .changes_only = true},
    {.name = "EDQUOT from then on", .fault = TIMES(EDQUOT, LONG_MAX), .changes_only = true},
    {.name = "EROFS from then on", .fault = TIMES(EROFS, LONG_MAX), .changes_only = true},
};
const unsigned n_fault_kinds = sizeof(fault_kinds) / sizeof(fault_kinds[0]);

static bool transfers(const struct model_call *call)
{
    return call->op == OP_PREAD || call->op == OP_PWRITE || call->op == OP_APPEND;
}

bool fault_fits(const struct fault_kind *kind, const struct model_call *call)
{
    if (kind->changes_only && !call->changes)
        return false;
    if (kind->interruptible_only && !transfers(call) && call->op != OP_SYNC)
        return false;
    return !kind->transfers_only || (transfers(call) && call->n > 1);
}

void fault_text(const struct fault_kind *kind, long at, const struct model_call *call,
                char ret[300])
{
    snprintf(ret, 300, "%s at operation %ld, %s of %s", kind->name, at, model_op_name(call->op),
             call->path);
}
