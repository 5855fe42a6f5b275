/* SPDX-License-Identifier: Apache-2.0 */
/* export_sidecar.c: which frames an export holds, and which of them nobody took. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"
#include "ttf/dataset/json_writer.h"

static bool is_numbered(const struct export_job *job)
{
    return job->config->kind == TTF_EXPORT_PNG || job->config->kind == TTF_EXPORT_TIFF;
}

static void put_invented(struct ttf_json *json, const struct export_job *job)
{
    const int64_t *index = job->sequence->index;

    ttf_json_key(json, "invented");
    ttf_json_array(json);
    for (uint32_t k = 0; k < job->n; k++) {
        const struct export_frame *frame = &job->frame[k];

        if (!frame->invented)
            continue;
        ttf_json_object(json);
        ttf_json_kint(json, "frame", is_numbered(job) ? job->config->start + k : k);
        ttf_json_kint(json, "slot", frame->index);
        ttf_json_kstring(json, "how", frame->num > 0 ? "interpolate" : "hold");
        ttf_json_key(json, "from_slots");
        ttf_json_array(json);
        ttf_json_int(json, index[frame->a]);
        if (frame->num > 0)
            ttf_json_int(json, index[frame->b]);
        ttf_json_array_end(json);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

/* Slots that have an image which a note tags "exclude". */
static void put_excluded(struct ttf_json *json, const struct export_job *job)
{
    ttf_json_key(json, "excluded_slots");
    ttf_json_array(json);
    for (uint32_t i = 0; i < job->sequence->n_excluded; i++)
        ttf_json_int(json, job->sequence->excluded[i]);
    ttf_json_array_end(json);
}

static void put_frames(struct ttf_json *json, const struct export_job *job)
{
    ttf_json_key(json, "slots");
    ttf_json_array(json);
    for (uint32_t k = 0; k < job->n; k++)
        ttf_json_int(json, job->frame[k].index);
    ttf_json_array_end(json);
    ttf_json_key(json, "times_ns");
    ttf_json_array(json);
    for (uint32_t k = 0; k < job->n; k++)
        ttf_json_int(json, job->frame[k].time_ns);
    ttf_json_array_end(json);
}

int export_sidecar(const struct export_job *job, char **ret_text, size_t *ret_bytes,
                   struct ttf_err *err)
{
    const struct ttf_export_config *config = job->config;
    struct ttf_json json;
    const char *text;
    size_t n;
    int code;

    ttf_json_init(&json, true);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "kind", ttf_export_kind_name(config->kind));
    ttf_json_kbool(&json, "simulated", config->simulated);
    ttf_json_kint(&json, "frames", job->n);
    ttf_json_kint(&json, "width", job->width);
    ttf_json_kint(&json, "height", job->height);
    if (is_numbered(job)) {
        ttf_json_kstring(&json, "name", config->name);
        ttf_json_kint(&json, "start", config->start);
    } else if (config->kind != TTF_EXPORT_NPY) {
        ttf_json_kdouble(&json, "fps", (double)config->fps_num / config->fps_den);
    }
    ttf_json_kstring(&json, "samples", job->values ? "values as float32" : "light");
    if (!job->values) {
        ttf_json_kdouble(&json, "white", job->white);
        ttf_json_kdouble(&json, "black", job->black);
    }
    ttf_json_kstring(&json, "gaps", ttf_gaps_name(config->gaps));
    put_invented(&json, job);
    put_excluded(&json, job);
    put_frames(&json, job);
    ttf_json_object_end(&json);
    code = ttf_json_finish(&json, &text, &n);
    if (!code && !(*ret_text = strndup(text, n)))
        code = -ENOMEM;
    *ret_bytes = code ? 0 : n;
    ttf_json_free(&json);
    if (code)
        return ttf_err_set(err, code, NULL, "no memory for the sidecar");
    return 0;
}
