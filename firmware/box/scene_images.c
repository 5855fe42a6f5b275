/* SPDX-License-Identifier: Apache-2.0 */
/* scene_images.c: a folder of pictures as a scene; see scene.h. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "scene.h"
#include "scene_cache.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/import.h"

struct images {
    struct ttf_io *io;
    char **paths;
    size_t n, room;
    int64_t span_ns;
    struct scene_cache cache;
    const char *folder; /* while listing */
};

static int load(void *ctx, int64_t frame, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    struct images *s = ctx;
    struct ttf_pixbuf codes = {0}, rgb = {0};
    int r = ttf_image_read_linear(s->io, s->paths[frame], &codes, NULL, err);

    if (r < 0)
        return r;
    r = ttf_pixbuf_alloc(&rgb, codes.width, codes.height, 3, TTF_SAMPLE_F32);
    if (r == 0)
        r = ttf_pixbuf_convert(&codes, &rgb);
    ttf_pixbuf_free(&codes);
    if (r < 0) {
        ttf_pixbuf_free(&rgb);
        return ttf_err_set(err, r, s->paths[frame], "cannot be brought into memory");
    }
    *ret = rgb;
    return 0;
}

static int render(void *scene, int64_t t_ns, uint32_t w, uint32_t h, float *rgb,
                  struct ttf_err *err)
{
    struct images *s = scene;
    double at = (double)t_ns / (double)s->span_ns * (double)(s->n - 1);
    int64_t frame = at <= 0 ? 0 : (int64_t)(at + 0.5);

    if (frame > (int64_t)s->n - 1)
        frame = (int64_t)s->n - 1;
    return scene_cache_render(&s->cache, frame, w, h, load, s, rgb, err);
}

static void destroy(void *scene)
{
    struct images *s = scene;

    scene_cache_finish(&s->cache);
    for (size_t i = 0; i < s->n; i++)
        free(s->paths[i]);
    free(s->paths);
    free(s);
}

static const struct ttf_scene_ops OPS = {
    .name = "images",
    .render = render,
    .destroy = destroy,
};

static bool is_picture(const char *name)
{
    static const char *const ENDINGS[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff"};
    const char *dot = strrchr(name, '.');

    for (unsigned i = 0; dot && i < TTF_COUNT_OF(ENDINGS); i++)
        if (strcasecmp(dot, ENDINGS[i]) == 0)
            return *name != '.';
    return false;
}

static int take_entry(void *ctx, const char *name, bool is_dir)
{
    struct images *s = ctx;
    char path[PATH_MAX];

    if (is_dir || !is_picture(name))
        return 0;
    if (s->n == s->room) {
        size_t room = s->room ? 2 * s->room : 128;
        char **paths = realloc(s->paths, room * sizeof *paths);

        if (!paths)
            return -ENOMEM;
        s->paths = paths;
        s->room = room;
    }
    (void)snprintf(path, sizeof path, "%s/%s", s->folder, name);
    s->paths[s->n] = strdup(path);
    if (!s->paths[s->n])
        return -ENOMEM;
    s->n++;
    return 0;
}

static int by_name(const void *a, const void *b)
{
    return ttf_natural_compare(*(const char *const *)a, *(const char *const *)b);
}

int scene_of_images(struct ttf_io *io, const char *folder, int64_t span_ns, struct ttf_scene *ret,
                    struct ttf_err *err)
{
    struct images *s = calloc(1, sizeof *s);
    int r;

    if (!s)
        return ttf_err_set(err, -ENOMEM, folder, "no memory");
    s->io = io;
    s->span_ns = span_ns;
    s->folder = folder;
    scene_cache_init(&s->cache);
    r = io->ops->list(io, folder, take_entry, s);
    if (r < 0) {
        ttf_err_set(err, r, folder, "the scene's folder cannot be listed: %s", strerrordesc_np(-r));
        goto fail;
    }
    if (s->n == 0) {
        r = ttf_err_set(err, -ENODATA, folder, "the scene's folder holds no picture");
        ttf_err_hint(err, "PNG, JPEG and TIFF files are looked at");
        goto fail;
    }
    qsort(s->paths, s->n, sizeof *s->paths, by_name);
    s->folder = NULL;
    *ret = (struct ttf_scene){.ops = &OPS, .priv = s};
    return 0;
fail:
    destroy(s);
    return r;
}
