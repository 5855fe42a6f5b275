/* SPDX-License-Identifier: Apache-2.0 */
/* npy.c: one array n x h x w x 3 of uint16, or of floats, NumPy's format 1.0 (numpy.lib.format). */
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
                 "{'descr': '<%s', 'fortran_order': False, 'shape': (%u, %u, %u, 3), }",
                 job->values ? "f4" : "u2", job->n, job->height, job->width);
    header[10 + n] = ' ';
    n = (10 + n + 1 + 63) / 64 * 64;
    header[n - 1] = '\n';
    header[8] = (char)((n - 10) & 0xff);
    header[9] = (char)((n - 10) >> 8);
    return export_file_put(&sink->file, header, (size_t)n, err);
}

static void put_codes(const uint16_t *row, size_t n, uint8_t *ret)
{
    for (size_t i = 0; i < n; i++) {
        ret[2 * i] = (uint8_t)row[i];
        ret[2 * i + 1] = (uint8_t)(row[i] >> 8);
    }
}

static void put_values(const float *row, size_t n, uint8_t *ret)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t bits;

        memcpy(&bits, &row[i], sizeof(bits));
        for (unsigned k = 0; k < 4; k++)
            ret[4 * i + k] = (uint8_t)(bits >> (8 * k));
    }
}

static int npy_frame(struct export_sink *base, uint32_t k, const struct ttf_pixbuf *rgb,
                     struct ttf_err *err)
{
    struct npy_sink *sink = (struct npy_sink *)base;
    size_t n = (size_t)rgb->width * 3;
    int code = 0;

    for (uint32_t y = 0; y < rgb->height && !code; y++) {
        if (base->job->values)
            put_values(ttf_pixbuf_row(rgb, y), n, sink->row);
        else
            put_codes(ttf_pixbuf_row(rgb, y), n, sink->row);
        code = export_file_put(&sink->file, sink->row, (base->job->values ? 4 : 2) * n, err);
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
    sink->row = malloc((size_t)job->width * 3 * (job->values ? 4 : 2));
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
