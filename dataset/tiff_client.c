/* SPDX-License-Identifier: Apache-2.0 */
#include "tiff_client.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "ttf/base/checked.h"

/*
 * libtiff reads a folder tag by tag, a few bytes each, and every folder more than once: a call of
 * the system for each would take longer than to read a small picture. False: not for the window.
 */
static bool read_window(struct tiff_client *client, void *buf, size_t n)
{
    int64_t from = client->position - client->position % (TIFF_WINDOW / 4), got;

    if (n > TIFF_WINDOW / 4)
        return false;
    if (client->position < client->window_at ||
        client->position + (int64_t)n > client->window_at + (int64_t)client->window_bytes) {
        client->window_bytes = 0;
        got = ttf_io_pread_all(client->io, client->file, client->window, TIFF_WINDOW, from);
        /* An error may be of bytes that nobody asked for: the plain read will tell. */
        if (got < client->position - from + (int64_t)n)
            return false;
        client->window_at = from;
        client->window_bytes = (size_t)got;
    }
    memcpy(buf, client->window + (client->position - client->window_at), n);
    client->position += (int64_t)n;
    return true;
}

static bool keep_error(struct tiff_client *client, int r)
{
    if (r < 0 && client->io_error == 0)
        client->io_error = r;
    return r >= 0;
}

/* Whoever reads sees all that was written. */
static bool release(struct tiff_client *client)
{
    return keep_error(client, tiff_order_release(&client->order, client->io, client->file));
}

static tmsize_t client_read(thandle_t handle, void *buf, tmsize_t n)
{
    struct tiff_client *client = handle;
    int64_t got;

    if (n < 0 || client->position < 0 || !release(client))
        return -1;
    if (read_window(client, buf, (size_t)n))
        return n;
    got = ttf_io_pread_all(client->io, client->file, buf, (size_t)n, client->position);
    if (!keep_error(client, got < 0 ? (int)got : 0))
        return -1;
    client->position += got;
    return (tmsize_t)got;
}

static tmsize_t client_write(thandle_t handle, void *buf, tmsize_t n)
{
    struct tiff_client *client = handle;
    int r;

    if (n < 0 || client->position < 0)
        return -1;
    if (client->dropped)
        return -1;
    client->window_bytes = 0;
    r = tiff_order_write(&client->order, client->io, client->file, client->position, buf,
                         (size_t)n);
    if (r == 0)
        r = ttf_io_pwrite_all(client->io, client->file, buf, (size_t)n, client->position);
    if (!keep_error(client, r))
        return -1;
    client->position += n;
    if (client->position > client->size)
        client->size = client->position;
    return n;
}

static toff_t client_seek(thandle_t handle, toff_t offset, int whence)
{
    struct tiff_client *client = handle;
    int64_t base = 0, to;

    if (whence == SEEK_CUR)
        base = client->position;
    else if (whence == SEEK_END)
        base = client->size;
    if (!ttf_add_i64(base, (int64_t)offset, &to) || to < 0)
        return (toff_t)-1;
    client->position = to;
    return (toff_t)to;
}

/* The handle outlives libtiff's: tiff_client_close closes it where it is ours. */
static int client_close(thandle_t handle)
{
    return 0;
}

static toff_t client_size(thandle_t handle)
{
    const struct tiff_client *client = handle;

    return (toff_t)client->size;
}

static int on_error(TIFF *tiff, void *user_data, const char *module, const char *fmt, va_list args)
    TTF_PRINTF(4, 0);
static int on_error(TIFF *tiff, void *user_data, const char *module, const char *fmt, va_list args)
{
    struct tiff_client *client = user_data;

    if (client->message[0] == '\0')
        vsnprintf(client->message, sizeof(client->message), fmt, args);
    client->made_up |= client->decoding; /* a fax goes on after errors */
    return 1;                            /* dealt with: libtiff's own handler would print */
}

static int on_warning(TIFF *tiff, void *user_data, const char *module, const char *fmt,
                      va_list args) TTF_PRINTF(4, 0);
static int on_warning(TIFF *tiff, void *user_data, const char *module, const char *fmt,
                      va_list args)
{
    /* Said while decoding, too, and no pixel is made up by it. */
    static const char *const harmless[] = {
        "Old-style LZW codes",         /* another order of bits, which is read */
        "Discarding",                  /* more than the strip holds */
        "strip size exceeds expected", /* more rows than asked for */
        "Adobe color transform",       /* how colours are told apart from a comment */
        "JFIF revision",
        "Invalid SOS parameters", /* zeros, as some encoders write */
        "extraneous bytes",       /* filled up behind the picture */
    };
    struct tiff_client *client = user_data;
    char text[sizeof(client->message)];

    if (!client->decoding || client->made_up)
        return 1;
    vsnprintf(text, sizeof(text), fmt, args);
    for (unsigned i = 0; i < TTF_COUNT_OF(harmless); i++) {
        if (strstr(text, harmless[i]))
            return 1;
    }
    client->made_up = true;
    memcpy(client->message, text, sizeof(text));
    return 1;
}

void tiff_decode_begin(struct tiff_client *client)
{
    errno = 0;
    client->message[0] = '\0';
    client->made_up = false;
    client->decoding = true;
}

int tiff_decode_end(struct tiff_client *client, struct ttf_err *err, const char *doing)
{
    client->decoding = false;
    if (client->made_up)
        return tiff_client_fail(client, err, -TTF_EDAMAGED, doing);
    return tiff_client_done(client, err, doing);
}

static int open_handle(struct tiff_client *client, const char *mode)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();

    if (!options)
        return -ENOMEM;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, (tmsize_t)TIFF_ALLOC_MAX);
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, client);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, client);
    client->tiff = TIFFClientOpenExt(client->where[0] ? client->where : "TIFF", mode, client,
                                     client_read, client_write, client_seek, client_close,
                                     client_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return client->tiff ? 0 : -TTF_EDAMAGED;
}

int tiff_client_attach(struct tiff_client *client, struct ttf_io *io, int file, const char *mode,
                       struct ttf_err *err)
{
    int r;

    memset(client, 0, sizeof(*client));
    errno = 0;
    client->io = io;
    client->file = file;
    r = io->ops->size(io, file, &client->size);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "cannot tell the size of a file: %s", strerrordesc_np(-r));
    if (mode[0] == 'w' && client->size == 0)
        tiff_order_begin(&client->order);
    r = open_handle(client, mode);
    if (r < 0)
        return tiff_client_fail(client, err, r, "opening a TIFF file");
    return 0;
}

int tiff_client_pixels(struct tiff_client *client, int64_t bytes, struct ttf_err *err)
{
    int r = tiff_order_pixels(&client->order, client->io, client->file, client->size, bytes);

    return keep_error(client, r) ? 0 : tiff_client_fail(client, err, r, "writing a TIFF file");
}

int tiff_client_open(struct tiff_client *client, struct ttf_io *io, const char *path,
                     struct ttf_err *err)
{
    int r, file = io->ops->open(io, path, TTF_IO_READ);

    memset(client, 0, sizeof(*client));
    if (file < 0)
        return ttf_err_set(err, file, path, "cannot open: %s", strerrordesc_np(-file));
    errno = 0;
    client->io = io;
    client->file = file;
    client->owns_file = true;
    snprintf(client->where, sizeof(client->where), "%s", path);
    r = io->ops->size(io, file, &client->size);
    if (r < 0)
        client->io_error = r;
    else
        r = open_handle(client, "rm");
    if (r < 0) {
        r = tiff_client_fail(client, err, r, "opening the file as TIFF");
        tiff_client_drop(client);
    }
    return r;
}

void tiff_client_drop(struct tiff_client *client)
{
    client->dropped = true; /* libtiff would write a last folder */
    if (client->tiff)
        TIFFCleanup(client->tiff);
    client->tiff = NULL;
    client->order.n = 0;
    (void)tiff_client_close(client);
}

int tiff_client_close(struct tiff_client *client)
{
    int r;

    if (client->tiff)
        TIFFClose(client->tiff);
    client->tiff = NULL;
    if (client->order.n > 0)
        (void)release(client);
    r = client->io_error;
    if (client->owns_file) {
        int closed = client->io->ops->close(client->io, client->file);

        if (r == 0)
            r = closed;
    }
    client->owns_file = false;
    return r;
}

int tiff_client_fail(const struct tiff_client *client, struct ttf_err *err, int code,
                     const char *doing)
{
    const char *where = client->where[0] ? client->where : NULL;

    if (client->io_error < 0)
        return ttf_err_set(err, client->io_error, where, "%s: %s", doing,
                           strerrordesc_np(-client->io_error));
    if (errno == ENOMEM)
        code = -ENOMEM;
    if (client->message[0])
        return ttf_err_set(err, code, where, "%s: %s", doing, client->message);
    return ttf_err_set(err, code, where, "%s failed", doing);
}

int tiff_client_done(const struct tiff_client *client, struct ttf_err *err, const char *doing)
{
    return errno == ENOMEM ? tiff_client_fail(client, err, -ENOMEM, doing) : 0;
}

bool tiff_set_text(TIFF *tiff, uint32_t tag, const char *text)
{
    return !text || !text[0] || TIFFSetField(tiff, tag, text) == 1;
}
