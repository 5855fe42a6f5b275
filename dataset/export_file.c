/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "export_job.h"

int export_file_open(struct export_file *file, struct export_job *job, struct ttf_err *err)
{
    *file = (struct export_file){.io = job->io, .path = job->staging.temp};
    file->handle = job->io->ops->open(job->io, file->path, TTF_IO_CREATE_NEW);
    if (file->handle < 0)
        return ttf_err_set(err, file->handle, file->path, "cannot be created: %s",
                           strerrordesc_np(-file->handle));
    return 0;
}

int export_file_put(struct export_file *file, const void *data, size_t n, struct ttf_err *err)
{
    int code = ttf_io_pwrite_all(file->io, file->handle, data, n, file->offset);

    if (code)
        return ttf_err_set(err, code, file->path, "cannot be written: %s", strerrordesc_np(-code));
    file->offset += (int64_t)n;
    return 0;
}

void export_file_close(struct export_file *file)
{
    if (file->handle >= 0)
        file->io->ops->close(file->io, file->handle);
    file->handle = -1;
}
