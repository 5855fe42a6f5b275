/* SPDX-License-Identifier: Apache-2.0 */
/* A plan's YAML: decoded, its zone resolved, checked, and told as JSON; errors placed in the file. */
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "fuzz.h"
#include "ttf/config/plan_file.h"

static void check(const struct ttf_plan_file *file)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(file);
    struct ttf_plan_figures figures;
    struct ttf_err err = {0};
    char *text = NULL;
    json_t *json;

    if (ttf_plan_check(plan, NULL, &figures, &err) < 0) {
        if (err.where[0] == '\0')
            abort(); /* a refusal that names no field */
        ttf_plan_file_place(file, &err);
        return;
    }
    if (figures.slots != plan->count || ttf_plan_json(plan, &text, &err) < 0)
        abort();
    json = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    if (!json)
        abort();
    json_decref(json);
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_plan_file *file = NULL;
    struct ttf_err err = {0};

    if (ttf_plan_file_parse("plan.yaml", (const char *)data, size, &file, &err) < 0)
        return 0;
    (void)!ttf_plan_file_resolve(file, INT64_C(1790000000000000000), &err);
    check(file);
    ttf_plan_file_free(file);
    return 0;
}
