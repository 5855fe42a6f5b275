/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_factors.c: see quilt_factors.h. */
#include "quilt_factors.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FACTORS_MAX (SIZE_MAX / 4)

static const char MAGIC[8] = "ttfFP\0\0\2";

/* ---- how an input was prepared ---- */

static struct quilt_factors_how how_of(const struct ttf_report_prepared *p)
{
    struct quilt_factors_how how;

    memset(&how, 0, sizeof how); /* it is written as bytes */
    memcpy(how.magic, MAGIC, sizeof MAGIC);
    how.byte_order = 1;
    how.shrink = p->reduced ? p->shrink : 1;
    how.step = p->reduced ? p->step : 1;
    how.stabilised = p->stabilised;
    how.deflicker_window = p->deflickered ? p->deflicker_window : 0;
    how.flattened = p->flattened;
    how.sigma_px = p->flattened ? p->gradient_sigma_px : 0;
    return how;
}

static bool is_same(const struct quilt_factors_how *a, const struct quilt_factors_how *b)
{
    return a->shrink == b->shrink && a->step == b->step && a->stabilised == b->stabilised &&
           a->deflicker_window == b->deflicker_window && a->flattened == b->flattened &&
           a->sigma_px == b->sigma_px;
}

/* Does preparation look at all frames, so that more of them change the others? */
static bool looks_at_all(const struct quilt_factors_how *how)
{
    return how->stabilised || how->deflicker_window || how->flattened;
}

static void say_how(const struct quilt_factors_how *how, char *ret, size_t size)
{
    size_t n = 0;

    ret[0] = '\0';
    if (how->shrink > 1 || how->step > 1)
        n += (size_t)snprintf(ret + n, size - n, ", shrunk by %u, one frame of %u", how->shrink,
                              how->step);
    if (how->stabilised)
        n += (size_t)snprintf(ret + n, size - n, ", stabilised");
    if (how->deflicker_window)
        n += (size_t)snprintf(ret + n, size - n, ", deflickered over %u frames",
                              how->deflicker_window);
    if (how->flattened)
        n += (size_t)snprintf(ret + n, size - n, ", flattened by %.4g px", how->sigma_px);
    if (n == 0)
        (void)snprintf(ret, size, ", as it is");
}

/* ---- the file ---- */

static int keep(void *ctx, const struct ttf_quilt_factors *factors)
{
    struct quilt_factors *f = ctx;

    free(f->grown);
    f->grown = malloc(sizeof f->is + factors->size);
    if (!f->grown)
        return ttf_err_set(&f->err, -ENOMEM, "--factors", "no memory to keep them");
    memcpy(f->grown, &f->is, sizeof f->is);
    memcpy(f->grown + sizeof f->is, factors->bytes, factors->size);
    f->grown_size = sizeof f->is + factors->size;
    return 0;
}

int quilt_factors_save(const struct quilt_factors *factors)
{
    struct cli *cli = factors->cli;

    return factors->grown && !factors->stays
               ? ttf_io_write_file(cli->io, cli->opt.factors, factors->grown, factors->grown_size,
                                   &cli->err)
               : 0;
}

int quilt_factors_open(struct cli *cli, struct quilt_factors *ret, struct ttf_quilt_config *config)
{
    const char *path = cli->opt.factors;
    struct ttf_io_stat st;
    size_t size = 0, from;
    int r;

    if (!path)
        return 0;
    ret->cli = cli;
    config->keep_factors = keep;
    config->keep_ctx = ret;
    r = cli->io->ops->stat(cli->io, path, &st);
    if (r == -ENOENT)
        return 0;
    r = ttf_io_slurp(cli->io, path, FACTORS_MAX, &ret->bytes, &size, &cli->err);
    if (r < 0)
        return cli_by_option(cli, r, "--factors", path);
    if (size >= sizeof ret->was)
        memcpy(&ret->was, ret->bytes, sizeof ret->was);
    /* an earlier version's file begins with the factors */
    ret->told = memcmp(ret->was.magic, MAGIC, sizeof MAGIC) == 0 && ret->was.byte_order == 1;
    from = ret->told ? sizeof ret->was : 0;
    if (!ret->told)
        memset(&ret->was, 0, sizeof ret->was);
    config->known = (struct ttf_quilt_factors){ret->bytes + from, size - from};
    return 0;
}

static int begin_anew(struct quilt_factors *factors, bool replaces, struct ttf_quilt_config *config)
{
    factors->stays = !replaces;
    config->known = (struct ttf_quilt_factors){0};
    free(factors->bytes);
    factors->bytes = NULL;
    return 0;
}

int quilt_factors_suit(struct quilt_factors *factors, const struct ttf_report_prepared *prepared,
                       const char *uuid, struct ttf_sequence *input,
                       struct ttf_quilt_config *config)
{
    struct cli *cli = factors->cli;
    bool other = false, previews;
    char was[160], is[160];
    int r;

    factors->is = how_of(prepared);
    (void)snprintf(factors->is.uuid, sizeof factors->is.uuid, "%s", uuid);
    if (!cli) /* no --factors: nothing is kept */
        return 0;
    factors->is.preview = cli->opt.preview;
    if (!config->known.bytes)
        return 0;
    previews = factors->was.preview && factors->is.preview;
    say_how(&factors->was, was, sizeof was);
    say_how(&factors->is, is, sizeof is);
    if (factors->told && !is_same(&factors->was, &factors->is)) {
        cli_warn("--factors: %s knows the input%s; now it is taken%s: begun anew%s",
                 cli->opt.factors, was, is, previews ? "" : ", and the file is left as it is");
        return begin_anew(factors, previews, config);
    }
    r = ttf_quilt_factors_check(config, input, &other, &cli->err);
    if (r == -EINVAL && other && factors->told && looks_at_all(&factors->is) && *uuid &&
        strcmp(factors->was.uuid, uuid) == 0) {
        cli_warn("--factors: the input of %s is another by now%s, which depends on all of its "
                 "frames: begun anew",
                 cli->opt.factors, is);
        memset(&cli->err, 0, sizeof cli->err);
        return begin_anew(factors, true, config);
    }
    return r;
}

void quilt_factors_close(struct quilt_factors *factors)
{
    free(factors->bytes);
    free(factors->grown);
    factors->bytes = factors->grown = NULL;
}
