/* SPDX-License-Identifier: Apache-2.0 */
/* import_order.c: which picture stands in which slot. */
#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "export_staging.h"
#include "image_file_codecs.h"
#include "import_source.h"

/* A grid much finer than the pictures would be nothing but missed slots. */
#define SLOTS_PER_FRAME_MAX 1000

static const char *const order_names[TTF_IMPORT_ORDER_COUNT] = {
    [TTF_IMPORT_NATURAL] = "natural",
    [TTF_IMPORT_GIVEN] = "given",
    [TTF_IMPORT_EXIF_TIME] = "exif-time",
    [TTF_IMPORT_NAME_TIME] = "name-time",
};

const char *ttf_import_order_name(enum ttf_import_order order)
{
    return (unsigned)order < TTF_IMPORT_ORDER_COUNT ? order_names[order] : "?";
}

int ttf_import_order_find(const char *name)
{
    for (int i = 0; i < TTF_IMPORT_ORDER_COUNT; i++) {
        if (strcmp(order_names[i], name) == 0)
            return i;
    }
    return -ENOENT;
}

static size_t run_of_digits(const char *text)
{
    size_t n = 0;

    while (isdigit((unsigned char)text[n]))
        n++;
    return n;
}

/* Compares the numbers that a and b begin with, however long, and moves past them. */
static int compare_numbers(const char **a, const char **b)
{
    const char *x = *a, *y = *b;
    size_t nx, ny;
    int order;

    *a += run_of_digits(x);
    *b += run_of_digits(y);
    while (*x == '0')
        x++;
    while (*y == '0')
        y++;
    nx = run_of_digits(x);
    ny = run_of_digits(y);
    if (nx != ny)
        return nx < ny ? -1 : 1;
    order = strncmp(x, y, nx);
    return order;
}

int ttf_natural_compare(const char *a, const char *b)
{
    const char *x = a, *y = b;

    while (*x && *y) {
        if (isdigit((unsigned char)*x) && isdigit((unsigned char)*y)) {
            int order = compare_numbers(&x, &y);

            if (order)
                return order;
            continue;
        }
        if (*x != *y)
            break;
        x++;
        y++;
    }
    if (*x != *y)
        return (unsigned char)*x < (unsigned char)*y ? -1 : 1;
    return strcmp(a, b); /* img01 and img1: some order, always the same */
}

static int by_name(const void *a, const void *b)
{
    const struct import_frame *x = a, *y = b;
    int order = ttf_natural_compare(x->path, y->path);

    if (order)
        return order;
    return x->page < y->page ? -1 : x->page > y->page;
}

static int by_time(const void *a, const void *b)
{
    const struct import_frame *x = a, *y = b;

    if (x->taken_utc_ns != y->taken_utc_ns)
        return x->taken_utc_ns < y->taken_utc_ns ? -1 : 1;
    return by_name(a, b);
}

static int64_t time_of(const char *path, const struct ttf_image_info *info,
                       const struct ttf_import_config *config)
{
    int64_t ns;

    if (config->order == TTF_IMPORT_EXIF_TIME) {
        ns = info->taken_utc_ns;
        if (ns == TTF_NS_UNKNOWN || info->zone_known)
            return ns;
    } else {
        ns = ttf_time_in_name(staging_base(path));
        if (ns == TTF_NS_UNKNOWN)
            return ns;
    }
    if (__builtin_sub_overflow(ns, config->zone_offset_s * TTF_NS_PER_S, &ns))
        return TTF_NS_UNKNOWN;
    return ns;
}

static int add_pages(struct import_list *list, const char *path, const struct ttf_image_info *info,
                     const struct ttf_import_config *config, struct ttf_err *err)
{
    struct import_frame *more;
    int64_t taken_utc_ns = TTF_NS_UNKNOWN;

    if (list->timed) {
        taken_utc_ns = time_of(path, info, config);
        if (taken_utc_ns == TTF_NS_UNKNOWN) {
            ttf_err_set(err, -EINVAL, path,
                        config->order == TTF_IMPORT_EXIF_TIME
                            ? "nothing in the file says when it was taken"
                            : "there is no date and time in the file's name");
            ttf_err_hint(err, "order by name and give an interval instead");
            return -EINVAL;
        }
        if (info->pages > 1)
            return ttf_err_set(err, -EINVAL, path, "a stack of pages cannot be ordered by time");
    }
    more = realloc(list->frame, (list->n + info->pages) * sizeof(*more));
    if (!more)
        return ttf_err_set(err, -ENOMEM, path, "no memory for a list of pictures");
    list->frame = more;
    for (unsigned page = 0; page < info->pages; page++)
        list->frame[list->n++] = (struct import_frame){
            .path = path, .kind = info->kind, .page = page, .taken_utc_ns = taken_utc_ns};
    return 0;
}

/* Looks into a file only as far as is needed: all of it is read later, once. */
static int look_at(struct import_list *list, struct ttf_io *io, const char *path,
                   const struct ttf_import_config *config, struct ttf_err *err)
{
    struct ttf_image_info info = {.pages = 1, .taken_utc_ns = TTF_NS_UNKNOWN};
    struct ttf_io_stat stat;
    int code = io->ops->stat(io, path, &stat);

    if (code)
        return ttf_err_set(err, code, path, "cannot be read: %s", strerrordesc_np(-code));
    if (stat.is_dir) {
        ttf_err_set(err, -EINVAL, path, "this is a folder");
        ttf_err_hint(err, "name the pictures in it, as in %s/*.png", path);
        return -EINVAL;
    }
    code = image_find_kind(io, path, &info.kind, err);
    if (code == -ENOTSUP && config->n_inputs == 1 && stat.bytes > 0) {
        list->is_video = true;
        return 0;
    }
    if (code)
        return code;
    if (info.kind == TTF_IMAGE_TIFF || config->order == TTF_IMPORT_EXIF_TIME) {
        code = ttf_image_probe(io, path, &info, err);
        if (code)
            return code;
    }
    return add_pages(list, path, &info, config, err);
}

int import_list_make(struct import_list *list, struct ttf_io *io,
                     const struct ttf_import_config *config, struct ttf_err *err)
{
    int code = 0;

    memset(list, 0, sizeof(*list));
    if (config->n_inputs == 0)
        return ttf_err_set(err, -EINVAL, NULL, "there is nothing to import");
    if ((unsigned)config->order >= TTF_IMPORT_ORDER_COUNT)
        return ttf_err_set(err, -EINVAL, NULL, "no such order");
    list->timed = config->order == TTF_IMPORT_EXIF_TIME || config->order == TTF_IMPORT_NAME_TIME;
    for (size_t i = 0; i < config->n_inputs && !code; i++)
        code = look_at(list, io, config->inputs[i], config, err);
    if (!code && list->is_video && list->timed)
        code = ttf_err_set(err, -EINVAL, config->inputs[0], "a video has no times to order by");
    if (code) {
        import_list_free(list);
        return code;
    }
    if (list->n > 1 && config->order == TTF_IMPORT_NATURAL)
        qsort(list->frame, list->n, sizeof(*list->frame), by_name);
    else if (list->n > 1 && list->timed)
        qsort(list->frame, list->n, sizeof(*list->frame), by_time);
    return 0;
}

static int by_value(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;

    return x < y ? -1 : x > y;
}

static int median_distance(const struct import_list *list, int64_t *ret_ns, struct ttf_err *err)
{
    size_t n = list->n - 1;
    int64_t *distance = malloc(n * sizeof(*distance));

    if (!distance)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a list of times");
    for (size_t i = 0; i < n; i++)
        distance[i] = list->frame[i + 1].taken_utc_ns - list->frame[i].taken_utc_ns;
    qsort(distance, n, sizeof(*distance), by_value);
    *ret_ns = distance[n / 2];
    free(distance);
    if (*ret_ns <= 0) {
        ttf_err_set(err, -EINVAL, list->frame[0].path, "most pictures have the same time");
        ttf_err_hint(err, "order by name and give an interval instead");
        return -EINVAL;
    }
    return 0;
}

static int slots_on_grid(struct import_list *list, int64_t interval_ns, struct ttf_err *err)
{
    int64_t t0 = list->frame[0].taken_utc_ns;

    for (size_t i = 0; i < list->n; i++) {
        struct import_frame *frame = &list->frame[i];
        int64_t since_ns = frame->taken_utc_ns - t0;

        frame->slot = since_ns / interval_ns + (since_ns % interval_ns >= (interval_ns + 1) / 2);
        if (i > 0 && frame->slot == frame[-1].slot) {
            ttf_err_set(err, -EINVAL, frame->path, "falls into the same slot as %s",
                        staging_base(frame[-1].path));
            ttf_err_hint(err, "give a shorter interval, or none to number them one by one");
            return -EINVAL;
        }
    }
    if (list->frame[list->n - 1].slot / SLOTS_PER_FRAME_MAX > (int64_t)list->n) {
        ttf_err_set(err, -EINVAL, NULL, "%zu pictures would lie in %lld slots", list->n,
                    (long long)list->frame[list->n - 1].slot + 1);
        ttf_err_hint(err, "give a longer interval");
        return -EINVAL;
    }
    return 0;
}

int import_list_slots(struct import_list *list, int64_t *interval_ns, struct ttf_err *err)
{
    int64_t span_ns; /* that it can be said is what all arithmetic on times here stands on */

    if (list->timed && list->n > 0 &&
        __builtin_sub_overflow(list->frame[list->n - 1].taken_utc_ns, list->frame[0].taken_utc_ns,
                               &span_ns)) {
        ttf_err_set(err, -EINVAL, list->frame[list->n - 1].path, "was taken 292 years after %s",
                    staging_base(list->frame[0].path));
        ttf_err_hint(err, "one of the two times is wrong: order by name and give an interval");
        return -EINVAL;
    }
    if (list->timed && *interval_ns > 0)
        return slots_on_grid(list, *interval_ns, err);
    for (size_t i = 0; i < list->n; i++)
        list->frame[i].slot = (int64_t)i;
    if (*interval_ns > 0)
        return 0;
    if (list->timed && list->n > 1)
        return median_distance(list, interval_ns, err);
    ttf_err_set(err, -EINVAL, NULL, "nothing says how long from one picture to the next");
    ttf_err_hint(err, "give an interval, as in --interval 10min");
    return -EINVAL;
}

void import_list_free(struct import_list *list)
{
    free(list->frame);
    memset(list, 0, sizeof(*list));
}
