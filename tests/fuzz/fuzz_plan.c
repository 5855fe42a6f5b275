/* SPDX-License-Identifier: Apache-2.0 */
/* A plan's YAML: decoded, its zone resolved, errors placed in the file. */
#include "fuzz.h"
#include "ttf/config/plan_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_plan_file *file = NULL;
    struct ttf_err err = {0};

    if (ttf_plan_file_parse("plan.yaml", (const char *)data, size, &file, &err) < 0)
        return 0;
    (void)!ttf_plan_file_resolve(file, INT64_C(1790000000000000000), &err);
    ttf_plan_file_free(file);
    return 0;
}
