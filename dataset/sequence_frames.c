/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence_frames.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/pool.h"

void sequence_frames_free(struct sequence_frames *frames)
{
    for (uint32_t i = 0; i < frames->n; i++)
        free(frames->path[i]);
    free(frames->path);
    free(frames->index);
    free(frames->time_ns);
    free(frames->excluded);
    memset(frames, 0, sizeof(*frames));
}

static int grow(struct sequence_frames *frames)
{
    uint32_t room = frames->room ? frames->room * 2 : 64;
    void *more;

    if (frames->n < frames->room)
        return 0;
    if (room < frames->room)
        return -EOVERFLOW;
    more = realloc(frames->path, room * sizeof(*frames->path));
    if (!more)
        return -ENOMEM;
    frames->path = more;
    more = realloc(frames->index, room * sizeof(*frames->index));
    if (!more)
        return -ENOMEM;
    frames->index = more;
    more = realloc(frames->time_ns, room * sizeof(*frames->time_ns));
    if (!more)
        return -ENOMEM;
    frames->time_ns = more;
    frames->room = room;
    return 0;
}

static const char *role_of(const struct ttf_sequence_choice *choice)
{
    return choice->role ? choice->role : "developed";
}

static const struct ttf_file_ref *file_of(const struct ttf_image *image, const char *role)
{
    for (unsigned i = 0; i < image->n_files; i++) {
        if (strcmp(image->files[i].role, role) == 0)
            return &image->files[i];
    }
    return NULL;
}

/* How far a bracket's image is from its reference, in stops; 0: it is the one, or there is no bracket. */
static double stops_away(const struct ttf_image *image)
{
    if (image->bracket < 0)
        return 0.0;
    return image->relative_exposure > 0.0 ? fabs(log2(image->relative_exposure)) : 1e6;
}

static const struct ttf_file_ref *chosen_image(const struct ttf_slot_record *record,
                                               const char *stream,
                                               const struct ttf_sequence_choice *choice)
{
    const struct ttf_file_ref *best = NULL;
    double best_stops = 0.0;

    for (unsigned i = 0; i < record->n_images; i++) {
        const struct ttf_image *image = &record->images[i];
        const struct ttf_file_ref *file = file_of(image, role_of(choice));

        if (!file || image->lacking[0] || strcmp(image->stream, stream) != 0)
            continue;
        if (choice->one_bracket && image->bracket != choice->bracket)
            continue;
        if (!best || stops_away(image) < best_stops) {
            best = file;
            best_stops = stops_away(image);
        }
    }
    return best;
}

/* Paths in records stay inside of the dataset. */
static bool is_inside(const char *path)
{
    if (path[0] == '/' || path[0] == 0)
        return false;
    for (const char *p = path; p; p = strchr(p, '/')) {
        p += *p == '/';
        if (strncmp(p, "..", 2) == 0 && (p[2] == '/' || p[2] == 0))
            return false;
    }
    return true;
}

/* Carries time over from segment to segment, whose boot clocks have nothing to do with one another. */
struct time_line {
    struct ttf_reader *reader;
    bool begun;
    int segment;
    int64_t segment_due_ns, segment_time_ns; /* of the segment's first frame */
    int64_t first_utc_ns;
    int64_t last_index, last_time_ns;
};

static int64_t time_of(struct time_line *line, const struct ttf_slot_record *record)
{
    int64_t utc_ns = ttf_reader_due_utc_ns(line->reader, record);
    struct ttf_segment segment;
    int64_t time_ns = TTF_NS_UNKNOWN, since_ns;

    if (!line->begun) {
        line->first_utc_ns = utc_ns;
        time_ns = 0;
    } else if (record->segment == line->segment &&
               !__builtin_sub_overflow(record->due_ns, line->segment_due_ns, &since_ns) &&
               !__builtin_add_overflow(line->segment_time_ns, since_ns, &time_ns)) {
        /* by the clock of one boot */
    } else if (utc_ns != TTF_NS_UNKNOWN && line->first_utc_ns != TTF_NS_UNKNOWN &&
               !__builtin_sub_overflow(utc_ns, line->first_utc_ns, &since_ns) &&
               since_ns > line->last_time_ns) {
        time_ns = since_ns;
    } else {
        /* Nobody knows how long the outage was, or the times are beyond all that can be said: as if the grid had gone on. */
        int64_t interval_ns = TTF_NS_PER_S;

        if (ttf_reader_segment(line->reader, record->segment, &segment) == 0 &&
            segment.interval_ns > 0)
            interval_ns = segment.interval_ns;
        if (__builtin_mul_overflow(record->index - line->last_index, interval_ns, &since_ns) ||
            __builtin_add_overflow(line->last_time_ns, since_ns, &time_ns))
            time_ns = INT64_MAX;
    }
    if (!line->begun || record->segment != line->segment) {
        line->segment = record->segment;
        line->segment_due_ns = record->due_ns;
        line->segment_time_ns = time_ns;
    }
    line->begun = true;
    line->last_index = record->index;
    line->last_time_ns = time_ns;
    return time_ns;
}

static int add_slot(struct sequence_frames *frames, struct time_line *line,
                    const struct ttf_slot_record *record, const struct ttf_file_ref *file,
                    struct ttf_err *err)
{
    const char *folder = ttf_reader_path(line->reader);
    char *path;
    int code;

    if (!is_inside(file->path))
        return ttf_err_set(err, -TTF_EDAMAGED, folder, "slot %lld names a file outside: %s",
                           (long long)record->index, file->path);
    code = grow(frames);
    path = code ? NULL : ttf_path_format("%s/%s", folder, file->path);
    if (!path)
        return ttf_err_set(err, code ? code : -ENOMEM, folder, "no memory for a sequence");
    frames->path[frames->n] = path;
    frames->index[frames->n] = record->index;
    frames->time_ns[frames->n] = time_of(line, record);
    frames->n++;
    return 0;
}

/* ---- records, some at once: parsing them is most of what opening costs ---- */

#define AT_ONCE 64

struct some_records {
    struct ttf_reader *reader;
    int64_t first;
    unsigned n;
    struct ttf_slot_record records[AT_ONCE];
    int codes[AT_ONCE];
    struct ttf_err errs[AT_ONCE];
};

static void read_record(void *ctx, unsigned tile, unsigned worker)
{
    struct some_records *some = ctx;

    (void)worker;
    ttf_slot_record_init(&some->records[tile]);
    some->codes[tile] =
        ttf_reader_slot(some->reader, some->first + tile, &some->records[tile], &some->errs[tile]);
}

static void read_some(struct some_records *some, int64_t first, int64_t slots,
                      struct ttf_pool *pool)
{
    some->first = first;
    some->n = slots - first < AT_ONCE ? (unsigned)(slots - first) : AT_ONCE;
    ttf_pool_run(pool, some->n, read_record, some);
}

static void free_some(struct some_records *some)
{
    for (unsigned i = 0; i < some->n; i++) {
        if (some->codes[i] == 0)
            ttf_slot_record_free(&some->records[i]);
    }
    some->n = 0;
}

/* Notes that exclude slots. */
struct exclusions {
    struct ttf_note *note;
    unsigned n, room;
    int failed;
};

static void keep_exclusion(void *ctx, const struct ttf_note *note)
{
    struct exclusions *x = ctx;

    if (!ttf_note_has_tag(note, "exclude") || x->failed)
        return;
    if (x->n == x->room) {
        unsigned room = x->room ? x->room * 2 : 8;
        struct ttf_note *more = realloc(x->note, room * sizeof(*more));

        if (!more) {
            x->failed = -ENOMEM;
            return;
        }
        x->note = more;
        x->room = room;
    }
    x->note[x->n++] = *note;
}

static bool is_excluded(const struct exclusions *x, int64_t index)
{
    for (unsigned i = 0; i < x->n; i++)
        if (ttf_note_is_of(&x->note[i], index))
            return true;
    return false;
}

static int leave_out(struct sequence_frames *frames, int64_t index)
{
    if (frames->n_excluded == frames->excluded_room) {
        uint32_t room = frames->excluded_room ? frames->excluded_room * 2 : 16;
        int64_t *more = realloc(frames->excluded, room * sizeof(*more));

        if (!more)
            return -ENOMEM;
        frames->excluded = more;
        frames->excluded_room = room;
    }
    frames->excluded[frames->n_excluded++] = index;
    return 0;
}

static int no_image(const struct sequence_frames *frames, const char *path,
                    const struct ttf_stream *stream, const struct ttf_sequence_choice *choice,
                    struct ttf_err *err)
{
    if (frames->n_excluded) {
        ttf_err_set(err, -ENODATA, path, "notes exclude all %u images of stream '%s'",
                    frames->n_excluded, stream->id);
        ttf_err_hint(err, "ask for them with the excluded ones");
    } else if (choice->one_bracket) {
        ttf_err_set(err, -ENODATA, path, "stream '%s' has no %s image of bracket %d", stream->id,
                    role_of(choice), choice->bracket);
    } else if (choice->role && strcmp(choice->role, "developed") != 0) {
        ttf_err_set(err, -ENODATA, path, "stream '%s' has no %s image", stream->id, choice->role);
    } else {
        ttf_err_set(err, -ENODATA, path, "stream '%s' has no developed image", stream->id);
        ttf_err_hint(err, "if only raw frames were kept, develop the dataset first");
    }
    return -ENODATA;
}

/* What a sequence is collected with. */
struct collector {
    struct sequence_frames frames;
    struct time_line line;
    struct exclusions excluded;
    const struct ttf_stream *stream;
    const struct ttf_sequence_choice *choice;
};

static int collect_record(struct collector *c, const struct ttf_slot_record *record,
                          struct ttf_err *err)
{
    const struct ttf_file_ref *file = chosen_image(record, c->stream->id, c->choice);

    if (!file)
        return 0;
    if (!is_excluded(&c->excluded, record->index))
        return add_slot(&c->frames, &c->line, record, file, err);
    if (leave_out(&c->frames, record->index) < 0)
        return ttf_err_set(err, -ENOMEM, ttf_reader_path(c->line.reader),
                           "no memory for the slots that are left out");
    return 0;
}

static int collect_all(struct collector *c, struct ttf_err *err)
{
    int64_t slots = ttf_reader_summary(c->line.reader)->slots;
    struct some_records *some = calloc(1, sizeof(*some));
    struct ttf_pool *pool;
    int code = 0;

    if (!some)
        return ttf_err_set(err, -ENOMEM, ttf_reader_path(c->line.reader), "no memory for records");
    some->reader = c->line.reader;
    pool = slots > AT_ONCE && c->choice->threads != 1 ? ttf_pool_create(c->choice->threads)
                                                      : NULL; /* NULL: one by one */
    for (int64_t first = 0; first < slots && code == 0; first += AT_ONCE) {
        read_some(some, first, slots, pool);
        for (unsigned i = 0; i < some->n && code == 0; i++) {
            code = some->codes[i];
            if (code < 0 && err)
                *err = some->errs[i];
            if (code == 0)
                code = collect_record(c, &some->records[i], err);
        }
        free_some(some);
    }
    free(some);
    ttf_pool_destroy(pool);
    return code;
}

int sequence_frames_collect(struct ttf_reader *reader, const struct ttf_stream *stream,
                            const struct ttf_sequence_choice *choice, struct sequence_frames *ret,
                            struct ttf_err *err)
{
    struct collector c = {.line = {.reader = reader}, .stream = stream, .choice = choice};
    const char *path = ttf_reader_path(reader);
    const struct ttf_note_visitor visitor = {.note = keep_exclusion, .ctx = &c.excluded};
    int code = 0;

    if (!choice->with_excluded)
        code = ttf_notes_read(ttf_reader_io(reader), path, &visitor, err);
    if (!code && c.excluded.failed)
        code = ttf_err_set(err, c.excluded.failed, path, "no memory for notes");
    if (!code)
        code = collect_all(&c, err);
    free(c.excluded.note);
    if (!code && c.frames.n == 0)
        code = no_image(&c.frames, path, stream, choice, err);
    if (code) {
        sequence_frames_free(&c.frames);
        return code;
    }
    *ret = c.frames;
    return 0;
}
