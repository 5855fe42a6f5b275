/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/ahead.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Frames of one piece: long enough that taking it costs nothing, short enough to share the last strip. */
#define PIECE_FRAMES 8u

/* Of a band: half of what a core's own cache holds, so that it is still there when it is written. */
#define BAND_BYTES ((size_t)384 << 10)

/*
 * Each strip reads the kept frames anew, from memory: while blocks are looked for, one waits until it is of so many times their pixels, or
 * of half of the rows that are left (else the last strip would be long, when nothing else is left to do). The first waits less: until it
 * comes nobody writes, and only one thread at a time can.
 */
#define STRIP_SOURCES 2u
#define FIRST_SOURCES 1u

/* That the room for all rows is asked for in: each is short beside a frame's reading. */
#define PARTS          4096u
#define PARTS_OF_PIECE 4u

/* Bands end between pages of the file where they can. */
#define PAGE 4096u

/* Copied at once: what is too much is overwritten by the next run. */
#define CHUNK 64u

struct run {
    uint32_t from, bytes; /* of a frame's codes */
    bool ends_band;
};

/* What a thread has to itself. */
struct desk {
    uint8_t *codes;
    int64_t render_ns, sink_ns;
};

struct ttf_ahead {
    const struct ttf_quilt_config *config;
    struct ttf_kept *kept;
    struct ttf_quilt_sink sink;
    struct ttf_aside aside;
    uint32_t rows_step, rows_max; /* of a band */
    unsigned reserved;            /* parts: the learner's, then that thread's that is */
    bool reserving;
    /* the map, when it is whole */
    struct ttf_quilt_map *map; /* NULL: nobody was at it yet */
    bool summed;
    struct ttf_ahead_sums sums;
    /* the strip */
    uint32_t y0, y1;
    uint32_t next; /* frame */
    unsigned working;
    struct run *runs;
    size_t n_runs, room_runs;
    unsigned n_desks;
    struct desk *desks;
};

static int64_t now_ns(const struct ttf_ahead *ahead)
{
    const struct ttf_quilt_config *config = ahead->config;

    return config->now_ns ? config->now_ns(config->now_ctx) : 0;
}

static size_t row_bytes(const struct ttf_ahead *ahead)
{
    return (size_t)ahead->config->width * 3;
}

/* The least number of rows that is a number of pages; 1 where that would be many. */
static uint32_t rows_of_pages(size_t row)
{
    uint32_t rows = 1;

    while (rows * row % PAGE != 0)
        rows *= 2;
    return rows * row <= BAND_BYTES ? rows : 1;
}

/* Of the next strip, but if it is among the last. */
static uint32_t least_rows(const struct ttf_ahead *ahead)
{
    uint64_t sources = ahead->y1 == 0 ? FIRST_SOURCES : STRIP_SOURCES;
    uint64_t rows = sources * ahead->kept->frame / row_bytes(ahead);
    uint32_t half = (ahead->config->height - ahead->y1) / 2;

    return rows < half ? (uint32_t)rows : half;
}

static int reserve_next(void *ctx, struct ttf_err *err)
{
    struct ttf_ahead *ahead = ctx;
    int r;

    if (ahead->reserved == PARTS)
        return 0;
    r = ahead->sink.reserve(ahead->sink.ctx, ahead->reserved, PARTS, err);
    ahead->reserved++;
    return r < 0 ? r : ahead->reserved < PARTS;
}

int ttf_ahead_create(const struct ttf_quilt_config *config, struct ttf_kept *kept,
                     const struct ttf_quilt_sink *sink, unsigned threads, struct ttf_ahead **ret)
{
    struct ttf_ahead *ahead = calloc(1, sizeof(*ahead));

    if (!ahead)
        return -ENOMEM;
    *ahead = (struct ttf_ahead){.config = config, .kept = kept, .sink = *sink, .n_desks = threads};
    ahead->reserved = sink->reserve ? 0 : PARTS;
    ahead->aside = (struct ttf_aside){.kept = kept,
                                      .next = sink->reserve ? reserve_next : NULL,
                                      .ctx = ahead,
                                      .now_ns = config->now_ns,
                                      .now_ctx = config->now_ctx};
    ahead->next = kept->frames;
    ahead->rows_step = rows_of_pages(row_bytes(ahead));
    ahead->rows_max = (uint32_t)(BAND_BYTES / row_bytes(ahead));
    ahead->rows_max -= ahead->rows_max % ahead->rows_step;
    ahead->rows_max = ahead->rows_max > 0 ? ahead->rows_max : 1;
    ahead->desks = calloc(threads, sizeof(*ahead->desks));
    for (unsigned i = 0; ahead->desks && i < threads; i++) {
        ahead->desks[i].codes = malloc(ahead->rows_max * row_bytes(ahead) + CHUNK);
        if (!ahead->desks[i].codes) {
            ttf_ahead_destroy(ahead);
            return -ENOMEM;
        }
    }
    if (!ahead->desks) {
        ttf_ahead_destroy(ahead);
        return -ENOMEM;
    }
    *ret = ahead;
    return 0;
}

void ttf_ahead_destroy(struct ttf_ahead *ahead)
{
    if (!ahead)
        return;
    for (unsigned i = 0; ahead->desks && i < ahead->n_desks; i++)
        free(ahead->desks[i].codes);
    free(ahead->desks);
    free(ahead->runs);
    free(ahead);
}

const struct ttf_aside *ttf_ahead_aside(const struct ttf_ahead *ahead)
{
    return &ahead->aside;
}

/* ---- strips ---- */

static int add_run(struct ttf_ahead *ahead, uint32_t source, uint32_t pixels, bool ends_band)
{
    if (ahead->n_runs == ahead->room_runs) {
        size_t room = ahead->room_runs ? 2 * ahead->room_runs : 4096;
        struct run *runs = realloc(ahead->runs, room * sizeof(*runs));

        if (!runs)
            return -ENOMEM;
        ahead->runs = runs;
        ahead->room_runs = room;
    }
    ahead->runs[ahead->n_runs++] = (struct run){source * 3, pixels * 3, ends_band};
    return 0;
}

/* Neighbours that are neighbours in the source, too. A run may go on in the next row of its band. */
static int find_runs(struct ttf_ahead *ahead, const struct ttf_quilt_map *map)
{
    const uint32_t *source = map->source + (size_t)ahead->y0 * map->width;
    size_t n = (size_t)(ahead->y1 - ahead->y0) * map->width, band = 0;
    int r = 0;

    ahead->n_runs = 0;
    for (size_t at = 0; at < n && r == 0;) {
        size_t end = at + 1;

        if (at == band) {
            band += (size_t)ahead->rows_max * map->width;
            band = band < n ? band : n;
        }
        while (end < band && source[end] == source[end - 1] + 1)
            end++;
        r = add_run(ahead, source[at], (uint32_t)(end - at), end == band);
        at = end;
    }
    return r;
}

/* The last row that a strip from y0 on may end before; y0: there is none yet. */
static uint32_t strip_end(const struct ttf_ahead *ahead, uint32_t final_rows)
{
    uint32_t height = ahead->config->height, end = final_rows;

    if (end == height)
        return end;
    end -= end % ahead->rows_step;
    return end > ahead->y1 && end - ahead->y1 >= least_rows(ahead) ? end : ahead->y1;
}

/* Of the strip, or of the next one. */
static int take_rows(struct ttf_ahead *ahead, const struct ttf_quilt_map *map, uint32_t final_rows,
                     struct ttf_ahead_piece *ret)
{
    uint32_t frames = ahead->kept->frames, end;
    int r;

    if (ahead->next == frames) {
        end = strip_end(ahead, final_rows);
        if (ahead->working > 0 || end == ahead->y1)
            return 0;
        ahead->y0 = ahead->y1;
        ahead->y1 = end;
        r = find_runs(ahead, map);
        if (r < 0)
            return r;
        ahead->next = 0;
    }
    *ret = (struct ttf_ahead_piece){.from = ahead->next};
    ret->to = frames - ret->from < PIECE_FRAMES ? frames : ret->from + PIECE_FRAMES;
    ahead->next = ret->to;
    ahead->working++;
    return 1;
}

int ttf_ahead_take(struct ttf_ahead *ahead, struct ttf_quilt_map *map, uint32_t final_rows,
                   bool alone, struct ttf_ahead_piece *ret)
{
    int r;

    /* first: while another thread is at rows that were final before, this one would mostly wait for the file */
    if (final_rows == ahead->config->height && !ahead->map) {
        ahead->map = map;
        *ret = (struct ttf_ahead_piece){.kind = TTF_AHEAD_MAP};
        return 1;
    }
    r = alone && ahead->working > 0 ? 0 : take_rows(ahead, map, final_rows, ret);
    if (r != 0 || ahead->working > 0 || ahead->reserving || ahead->reserved == PARTS)
        return r;
    /* nobody is at the file: the next rows find their room */
    *ret = (struct ttf_ahead_piece){.kind = TTF_AHEAD_ROOM};
    ahead->reserving = true;
    return 1;
}

void ttf_ahead_done(struct ttf_ahead *ahead, const struct ttf_ahead_piece *piece)
{
    switch (piece->kind) {
    case TTF_AHEAD_ROWS:
        ahead->working--;
        break;
    case TTF_AHEAD_ROOM:
        ahead->reserving = false;
        break;
    case TTF_AHEAD_MAP:
        ahead->summed = true;
        break;
    }
}

bool ttf_ahead_finished(const struct ttf_ahead *ahead)
{
    return ahead->y1 == ahead->config->height && ahead->next == ahead->kept->frames &&
           ahead->working == 0 && ahead->summed;
}

size_t ttf_ahead_sums_bytes(size_t source_pixels)
{
    return source_pixels * sizeof(uint32_t); /* repetition counts uses */
}

const struct ttf_ahead_sums *ttf_ahead_sums(const struct ttf_ahead *ahead)
{
    return &ahead->sums;
}

/* ---- pieces ---- */

/*
 * Whole chunks: faster than the exact length, and what is too much lies within the slack behind either. The next frame's are asked for
 * meanwhile: they are far from the processor, and no pattern that it would guess.
 */
static const struct run *copy_band(const struct ttf_ahead *ahead, const struct run *run,
                                   const uint8_t *source, uint8_t *to)
{
    for (bool more = true; more; run++) {
        const uint8_t *from = source + run->from;

        for (uint32_t k = 0; k < run->bytes; k += CHUNK) {
            __builtin_prefetch(from + ahead->kept->frame + k);
            memcpy(to + k, from + k, CHUNK);
        }
        to += run->bytes;
        more = !run->ends_band;
    }
    return run;
}

/* All rows of the strip of frame t, band after band: those of the frame that the first has read are still near for the others. */
static int hand_on(const struct ttf_ahead *ahead, uint32_t t, struct desk *desk,
                   struct ttf_err *err)
{
    const uint8_t *source = ahead->kept->codes + t * ahead->kept->frame;
    const struct run *run = ahead->runs;
    int r = 0;

    for (uint32_t y = ahead->y0, end; y < ahead->y1 && r == 0; y = end) {
        int64_t copied_ns;

        end = ahead->y1 - y > ahead->rows_max ? y + ahead->rows_max : ahead->y1;
        run = copy_band(ahead, run, source, desk->codes);
        copied_ns = now_ns(ahead);
        r = ahead->sink.rows8(ahead->sink.ctx, t, y, end, desk->codes, err);
        desk->sink_ns += now_ns(ahead) - copied_ns;
    }
    return r;
}

static int make_room(struct ttf_ahead *ahead, struct desk *desk, struct ttf_err *err)
{
    int64_t start_ns = now_ns(ahead);
    int r = 1;

    for (unsigned i = 0; i < PARTS_OF_PIECE && r > 0; i++)
        r = reserve_next(ahead, err);
    desk->sink_ns += now_ns(ahead) - start_ns;
    return r;
}

static int hand_on_rows(struct ttf_ahead *ahead, const struct ttf_ahead_piece *piece,
                        struct desk *desk, struct ttf_err *err)
{
    int r = 0;

    for (uint32_t t = piece->from; t < piece->to && r == 0; t++)
        r = hand_on(ahead, t, desk, err);
    return r;
}

static int sum_up(struct ttf_ahead *ahead, struct ttf_err *err)
{
    int r = ttf_quilt_map_index(ahead->map);

    ahead->sums.digest = ttf_quilt_map_digest(ahead->map);
    if (r == 0)
        r = ttf_repetition_of_map(ahead->map, &ahead->sums.repetition);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory for a map of %u x %u pixels",
                               ahead->map->width, ahead->map->height)
                 : 0;
}

int ttf_ahead_run(struct ttf_ahead *ahead, const struct ttf_ahead_piece *piece, unsigned worker,
                  struct ttf_err *err)
{
    struct desk *desk = &ahead->desks[worker];
    int64_t start_ns = now_ns(ahead);
    int r = 0;

    switch (piece->kind) {
    case TTF_AHEAD_ROWS:
        r = hand_on_rows(ahead, piece, desk, err);
        break;
    case TTF_AHEAD_ROOM:
        r = make_room(ahead, desk, err);
        break;
    case TTF_AHEAD_MAP:
        return sum_up(ahead, err); /* no part of rendering */
    }
    desk->render_ns += now_ns(ahead) - start_ns;
    return r < 0 ? r : 0;
}

void ttf_ahead_costs(const struct ttf_ahead *ahead, struct ttf_quilt_report *report)
{
    for (unsigned i = 0; i < ahead->n_desks; i++) {
        report->render_ns += ahead->desks[i].render_ns;
        report->sink_ns += ahead->desks[i].sink_ns;
    }
    report->frame_bytes +=
        ttf_kept_bytes(ahead->kept) + ahead->n_desks * (ahead->rows_max * row_bytes(ahead) + CHUNK);
}
