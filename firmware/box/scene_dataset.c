/* SPDX-License-Identifier: Apache-2.0 */
/* scene_dataset.c: a dataset's primary stream as a scene; see scene.h. */
#include <errno.h>
#include <stdlib.h>

#include "scene.h"
#include "scene_cache.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"

struct of_dataset {
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;
    int64_t span_ns;
    struct scene_cache cache;
};

static int load(void *ctx, int64_t frame, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    const struct of_dataset *s = ctx;
    struct ttf_sequence *q = s->sequence;
    struct ttf_pixbuf rgb = {0};
    uint16_t *row = malloc((size_t)q->width * 3 * sizeof *row);
    int r = row ? ttf_pixbuf_alloc(&rgb, q->width, q->height, 3, TTF_SAMPLE_F32) : -ENOMEM;

    if (r < 0) {
        free(row);
        return ttf_err_set(err, r, NULL, "no memory for a scene's frame");
    }
    for (uint32_t y = 0; r == 0 && y < q->height; y++) {
        float *out = ttf_pixbuf_row(&rgb, y);

        r = ttf_sequence_read_rows(q, (uint32_t)frame, y, 1, row, err);
        for (uint32_t i = 0; r == 0 && i < q->width * 3; i++) {
            double v = (row[i] - q->encoding.pedestal) / q->encoding.scale;

            out[i] = (float)(v < 0 ? 0 : v > 1 ? 1 : v);
        }
    }
    free(row);
    if (r < 0)
        ttf_pixbuf_free(&rgb);
    else
        *ret = rgb;
    return r;
}

/* The frame nearest in time, its times stretched to the span. */
static int64_t nearest(const struct of_dataset *s, int64_t t_ns)
{
    const struct ttf_sequence *q = s->sequence;
    double own = (double)q->time_ns[q->n - 1];
    double at = own > 0 ? (double)t_ns / (double)s->span_ns * own : 0;
    uint32_t lo = 0, hi = q->n - 1;

    while (lo < hi) { /* the last frame whose time is not after `at` */
        uint32_t mid = hi - (hi - lo) / 2;

        if ((double)q->time_ns[mid] <= at)
            lo = mid;
        else
            hi = mid - 1;
    }
    if (lo + 1 < q->n && (double)q->time_ns[lo + 1] - at < at - (double)q->time_ns[lo])
        lo++;
    return lo;
}

static int render(void *scene, int64_t t_ns, uint32_t w, uint32_t h, float *rgb,
                  struct ttf_err *err)
{
    struct of_dataset *s = scene;

    return scene_cache_render(&s->cache, nearest(s, t_ns), w, h, load, s, rgb, err);
}

static void destroy(void *scene)
{
    struct of_dataset *s = scene;

    scene_cache_finish(&s->cache);
    ttf_sequence_destroy(s->sequence);
    ttf_reader_close(s->reader);
    free(s);
}

static const struct ttf_scene_ops OPS = {
    .name = "dataset",
    .render = render,
    .destroy = destroy,
};

int scene_of_dataset(struct ttf_io *io, const char *path, int64_t span_ns, struct ttf_scene *ret,
                     struct ttf_err *err)
{
    struct of_dataset *s = calloc(1, sizeof *s);
    int r;

    if (!s)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    s->span_ns = span_ns;
    scene_cache_init(&s->cache);
    r = ttf_reader_open(io, path, &s->reader, err);
    if (r == 0)
        r = ttf_sequence_of_dataset(s->reader, NULL, &s->sequence, err);
    if (r < 0) {
        destroy(s);
        return r;
    }
    *ret = (struct ttf_scene){.ops = &OPS, .priv = s};
    return 0;
}
