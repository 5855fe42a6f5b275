/* SPDX-License-Identifier: Apache-2.0 */
/* export_job.h: what the parts of export share: the frames to write, and what takes them. Private to export. */
#ifndef TTF_DATASET_EXPORT_JOB_H
#define TTF_DATASET_EXPORT_JOB_H

#include <stdbool.h>
#include <stdint.h>

#include "export_staging.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/export.h"
#include "ttf/dataset/pixbuf.h"

/* One frame to write: frame a of the sequence, or between a and b. */
struct export_frame {
    int64_t index; /* of its slot */
    int64_t time_ns;
    uint32_t a, b;
    int64_t num, den; /* weight of b: num / den */
    bool invented;
};

struct export_job {
    struct ttf_sequence *sequence;
    struct ttf_io *io;
    const struct ttf_export_config *config; /* with zeros replaced by what they mean */
    struct staging staging;
    struct export_frame *frame;
    uint32_t n;
    uint32_t width, height; /* as written */
    bool values;            /* floats as they are: npy and tiff of a stream of floats */
    double white, black;    /* values that become codes 65535 and 0 */
    uint16_t *linear;       /* the sequence's codes to 0..65535 of light, 65536 entries */
    uint8_t *display;       /* 0..65535 of light to 8-bit sRGB, 65536 entries */
    struct ttf_pixbuf source[2];
    int64_t source_t[2]; /* frames that lie there, -1: none */
    struct ttf_pixbuf mixed, sized;
    char *side_file; /* of the kind's own, removed at the end; NULL: none */
};

/* export_frames.c: which frames, and each of them as linear 16-bit RGB, 65535 = white; or as floats, if job.values. */
TTF_MUST_USE int export_frames_make(struct export_job *job, struct ttf_err *err);
TTF_MUST_USE int export_frames_buffers(struct export_job *job, struct ttf_err *err);
/* *ret is the job's own, and may be written to, until the next call. */
TTF_MUST_USE int export_frames_read(struct export_job *job, uint32_t k, struct ttf_pixbuf **ret,
                                    struct ttf_err *err);
void export_frames_free(struct export_job *job);

/* What takes the frames, in order. */
struct export_sink;
struct export_sink_ops {
    int (*frame)(struct export_sink *sink, uint32_t k, const struct ttf_pixbuf *rgb,
                 struct ttf_err *err);
    int (*finish)(struct export_sink *sink, struct ttf_err *err); /* completes; does not free */
    void (*destroy)(struct export_sink *sink);
};

/* Embedded first. */
struct export_sink {
    const struct export_sink_ops *ops;
    struct export_job *job;
};

typedef int export_open_fn(struct export_job *job, unsigned pass, struct export_sink **ret,
                           struct ttf_err *err);
export_open_fn export_video_open; /* mp4, gif */
export_open_fn export_y4m_open;
export_open_fn export_pictures_open; /* png, tiff */
export_open_fn export_npy_open;
export_open_fn export_sheet_open;

/* A file at the staging's temporary path that is written from its start to its end. */
struct export_file {
    struct ttf_io *io;
    int handle; /* -1: not open */
    int64_t offset;
    char *path; /* borrowed */
};
TTF_MUST_USE int export_file_open(struct export_file *file, struct export_job *job,
                                  struct ttf_err *err);
TTF_MUST_USE int export_file_put(struct export_file *file, const void *data, size_t n,
                                 struct ttf_err *err);
void export_file_close(struct export_file *file);

/* What a file says of itself where its format has a place for it; NULL: nothing. */
static inline const char *export_mark(const struct export_job *job)
{
    return job->config->simulated ? "SIMULATED" : NULL;
}

/* A row of linear RGB as 8-bit sRGB. */
static inline void export_display_row(const struct export_job *job, const uint16_t *rgb16,
                                      uint32_t width, uint8_t *ret)
{
    for (uint32_t i = 0; i < width * 3; i++)
        ret[i] = job->display[rgb16[i]];
}

/* export_sidecar.c: the text of the JSON beside the output, to be freed. */
TTF_MUST_USE int export_sidecar(const struct export_job *job, char **ret_text, size_t *ret_bytes,
                                struct ttf_err *err);

/* export_sheet.c: keeps of the job's frames those that the sheet shows, and sets its cells. */
TTF_MUST_USE int export_sheet_choose(struct export_job *job, struct ttf_err *err);

#endif
