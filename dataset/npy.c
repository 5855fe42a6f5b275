/* SPDX-License-Identifier: Apache-2.0 */
/* npy.c: one array n x h x w x 3 of uint16, NumPy's format 1.0 (numpy.lib.format). */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"

struct npy_sink {
    struct export_sink base; /* first: downcast by address */
    struct export_file file;
    uint8_t *row; /* little-endian */
};

/* Magic, version, length, a Python dict padded with blanks to a multiple of 64, newline. */
static int put_header(struct npy_sink *sink, struct ttf_err *err)
{
    const struct export_job *job = sink->base.job;
    static const char magic[8] = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0};
    char header[192];
    int n;

    memset(header, ' ', sizeof(header));
    memcpy(header, magic, sizeof(magic));
    n = snprintf(header + 10, sizeof(header) - 10,
                 "{'descr': '<u2', 'fortran_order': False, 'shape': (%u, %u, %u, 3), }", job->n,
                 job->height, job->width);
    header[10 + n] = ' ';
    n = (10 + n + 1 + 63) / 64 * 64;
    header[n - 1] = '\n';
    header[8] = (char)((n - 10) & 0xff);
    header[9] = (char)((n - 10) >> 8);
    return export_file_put(&sink->file, header, (size_t)n, err);
}

static int npy_frame(struct export_sink *base, uint32_t k, const struct ttf_pixbuf *rgb16,
                     struct ttf_err *err)
{
    struct npy_sink *sink = (struct npy_sink *)base;
    size_t n = (size_t)rgb16->width * 3;
    int code = 0;

    for (uint32_t y = 0; y < rgb16->height && !code; y++) {
        const uint16_t *row = ttf_pixbuf_row(rgb16, y);

        for (size_t i = 0; i < n; i++) {
            sink->row[2 * i] = (uint8_t)row[i];
            sink->row[2 * i + 1] = (uint8_t)(row[i] >> 8);
        }
        code = export_file_put(&sink->file, sink->row, 2 * n, err);
    }
    return code;
}

static int npy_finish(struct export_sink *base, struct ttf_err *err)
{
    return 0; /* synced with its renaming */
}

static void npy_destroy(struct export_sink *base)
{
    struct npy_sink *sink = (struct npy_sink *)base;

    export_file_close(&sink->file);
    free(sink->row);
    free(sink);
}

static const struct export_sink_ops npy_ops = {
    .frame = npy_frame,
    .finish = npy_finish,
    .destroy = npy_destroy,
};

int export_npy_open(struct export_job *job, unsigned pass, struct export_sink **ret,
                    struct ttf_err *err)
{
    struct npy_sink *sink = calloc(1, sizeof(*sink));
    int code;

    if (!sink)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write an array");
    sink->base = (struct export_sink){.ops = &npy_ops, .job = job};
    sink->file.handle = -1;
    sink->row = malloc((size_t)job->width * 6);
    code = sink->row ? export_file_open(&sink->file, job, err)
                     : ttf_err_set(err, -ENOMEM, NULL, "no memory to write an array");
    if (!code)
        code = put_header(sink, err);
    if (code) {
        npy_destroy(&sink->base);
        return code;
    }
    *ret = &sink->base;
    return 0;
}
