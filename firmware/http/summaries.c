/* SPDX-License-Identifier: Apache-2.0 */
#include "summaries.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "described.h"
#include "tally.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/reader.h"

#define GROWING 8   /* datasets whose slots are counted as they come */
#define KEPT    256 /* datasets; with more, the one that was made longest ago is made anew */

/* What changes if a dataset does. */
struct stamp {
    int64_t records_bytes, records_mtime_ns, sums_bytes, sums_mtime_ns, manifest_mtime_ns;
    uint64_t records_inode, manifest_inode;
};

struct entry {
    char dataset[65];
    struct stamp stamp;
    char *text;
};

/* One that was asked for while it grew. */
struct growing {
    char dataset[65]; /* empty: free */
    uint64_t used;    /* larger is later */
    struct tally tally;
};

struct summaries {
    pthread_mutex_t counting; /* over these three */
    struct growing growing[GROWING];
    uint64_t uses;
    pthread_mutex_t lock; /* over all below */
    struct entry entries[KEPT];
    unsigned next;
};

struct summaries *summaries_create(void)
{
    struct summaries *s = calloc(1, sizeof *s);

    if (!s)
        return NULL;
    (void)pthread_mutex_init(&s->counting, NULL);
    (void)pthread_mutex_init(&s->lock, NULL);
    return s;
}

void summaries_destroy(struct summaries *s)
{
    if (!s)
        return;
    for (unsigned i = 0; i < KEPT; i++)
        free(s->entries[i].text);
    (void)pthread_mutex_destroy(&s->lock);
    (void)pthread_mutex_destroy(&s->counting);
    free(s);
}

static int64_t mtime_ns(const struct stat *st)
{
    return (int64_t)st->st_mtim.tv_sec * TTF_NS_PER_S + st->st_mtim.tv_nsec;
}

static int look(const struct folder *folder, const char *dataset, struct stamp *ret)
{
    struct stat st;
    int fd = folder_file(folder, dataset, "dataset.json", &st);

    memset(ret, 0, sizeof *ret);
    if (fd < 0)
        return fd;
    (void)close(fd);
    ret->manifest_mtime_ns = mtime_ns(&st);
    ret->manifest_inode = st.st_ino;
    fd = folder_file(folder, dataset, "records.jsonl", &st);
    if (fd >= 0) {
        (void)close(fd);
        ret->records_bytes = st.st_size;
        ret->records_mtime_ns = mtime_ns(&st);
        ret->records_inode = st.st_ino;
    }
    fd = folder_file(folder, dataset, "SHA256SUMS", &st);
    if (fd >= 0) {
        (void)close(fd);
        ret->sums_bytes = st.st_size;
        ret->sums_mtime_ns = mtime_ns(&st);
    }
    return 0;
}

static void put_streams(struct ttf_json *json, const struct ttf_manifest *m)
{
    ttf_json_key(json, "streams");
    ttf_json_array(json);
    for (unsigned i = 0; i < m->n_streams; i++) {
        const struct ttf_stream *s = &m->streams[i];

        ttf_json_object(json);
        ttf_json_kstring(json, "id", s->id);
        ttf_json_kstring(json, "quantity", s->quantity);
        ttf_json_kstring(json, "colour_space", s->colour_space);
        ttf_json_kint(json, "width", s->width);
        ttf_json_kint(json, "height", s->height);
        ttf_json_kint(json, "samples", s->samples);
        ttf_json_kbool(json, "primary", s == ttf_manifest_primary(m));
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

static void put_slots(struct ttf_json *json, const struct ttf_reader_summary *s)
{
    ttf_json_kint(json, "slots", s->slots);
    ttf_json_key(json, "results");
    ttf_json_object(json);
    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        ttf_json_kint(json, ttf_result_name((enum ttf_result)i), s->counts[i]);
    ttf_json_object_end(json);
    ttf_json_kint(json, "segments", s->n_segments);
    ttf_json_kbool(json, "ended", s->ended);
    ttf_json_kbool(json, "sealed", s->sealed);
}

/* digest: NULL: it has none. */
static int write_text(const struct ttf_manifest *m, const struct ttf_reader_summary *s,
                      const char *digest, const char *dataset, char **ret_text)
{
    struct ttf_json json;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "name", dataset);
    ttf_json_kstring(&json, "uuid", m->uuid);
    if (*m->title)
        ttf_json_kstring(&json, "title", m->title);
    ttf_json_kbool(&json, "simulated", m->simulated);
    put_slots(&json, s);
    if (digest)
        ttf_json_kstring(&json, "digest", digest);
    put_streams(&json, m);
    ttf_json_object_end(&json);
    return ttf_json_take(&json, ret_text, NULL);
}

/* By reading all of it. */
static int make_by_reader(struct ttf_io *io, const char *path, const char *dataset, char **ret_text,
                          struct ttf_err *err)
{
    struct ttf_reader *reader;
    const struct ttf_reader_summary *s;
    char digest[65];
    int r = ttf_reader_open(io, path, &reader, err);

    if (r < 0)
        return r;
    s = ttf_reader_summary(reader);
    if (s->sealed)
        r = ttf_reader_digest(reader, digest, err);
    if (r == 0)
        r = write_text(ttf_reader_manifest(reader), s, s->sealed ? digest : NULL, dataset,
                       ret_text);
    ttf_reader_close(reader);
    return r;
}

/* ---- of one that grows: what is new is added to what was counted ---- */

static struct growing *recall_growing(struct summaries *s, const char *dataset)
{
    struct growing *oldest = &s->growing[0];

    for (unsigned i = 0; i < GROWING; i++) {
        struct growing *g = &s->growing[i];

        if (strcmp(g->dataset, dataset) == 0) {
            g->used = ++s->uses;
            return g;
        }
        if (g->used < oldest->used)
            oldest = g;
    }
    *oldest = (struct growing){.used = ++s->uses};
    (void)snprintf(oldest->dataset, sizeof oldest->dataset, "%s", dataset);
    return oldest;
}

static int count(struct summaries *s, struct ttf_io *io, const char *path, const char *dataset,
                 struct ttf_reader_summary *ret)
{
    char records[4096 + 96];
    struct growing *growing;
    int r;

    (void)snprintf(records, sizeof records, "%s/records.jsonl", path);
    (void)pthread_mutex_lock(&s->counting);
    growing = recall_growing(s, dataset);
    r = tally_read(io, records, &growing->tally);
    *ret = growing->tally.summary;
    (void)pthread_mutex_unlock(&s->counting);
    return r;
}

static int make(struct summaries *s, const struct folder *folder, struct ttf_io *io,
                const char *path, const char *dataset, char **ret_text, struct ttf_err *err)
{
    struct ttf_reader_summary summary;
    struct ttf_manifest *manifest;
    int r;

    if (described_sealed(folder, dataset) || count(s, io, path, dataset, &summary) < 0)
        return make_by_reader(io, path, dataset, ret_text, err);
    manifest = malloc(sizeof *manifest);
    if (!manifest)
        return ttf_err_set(err, -ENOMEM, dataset, "no memory");
    r = ttf_manifest_load(io, path, manifest, err);
    if (r == 0)
        r = write_text(manifest, &summary, NULL, dataset, ret_text);
    free(manifest);
    return r;
}

/* A copy of what is remembered; NULL: nothing. */
static char *recall(struct summaries *s, const char *dataset, const struct stamp *stamp)
{
    char *text = NULL;

    (void)pthread_mutex_lock(&s->lock);
    for (unsigned i = 0; i < KEPT; i++)
        if (s->entries[i].text && strcmp(s->entries[i].dataset, dataset) == 0 &&
            memcmp(&s->entries[i].stamp, stamp, sizeof *stamp) == 0)
            text = strdup(s->entries[i].text);
    (void)pthread_mutex_unlock(&s->lock);
    return text;
}

static void remember(struct summaries *s, const char *dataset, const struct stamp *stamp,
                     const char *text)
{
    char *copy = strdup(text);
    struct entry *entry = NULL;

    if (!copy)
        return; /* it is made anew next time */
    (void)pthread_mutex_lock(&s->lock);
    for (unsigned i = 0; i < KEPT && !entry; i++)
        if (s->entries[i].text && strcmp(s->entries[i].dataset, dataset) == 0)
            entry = &s->entries[i];
    if (!entry) {
        entry = &s->entries[s->next];
        s->next = (s->next + 1) % KEPT;
    }
    free(entry->text);
    (void)snprintf(entry->dataset, sizeof entry->dataset, "%s", dataset);
    entry->stamp = *stamp;
    entry->text = copy;
    (void)pthread_mutex_unlock(&s->lock);
}

int summaries_get(struct summaries *s, const struct folder *folder, struct ttf_io *io,
                  const char *dataset, char **ret_text, struct ttf_err *err)
{
    char path[4096 + 80];
    struct stamp stamp;
    int r = look(folder, dataset, &stamp);

    if (r == 0)
        r = folder_dataset(folder, dataset, path, sizeof path);
    if (r < 0)
        return ttf_err_set(err, r, dataset, "there is no dataset of this name");
    *ret_text = recall(s, dataset, &stamp);
    if (*ret_text)
        return 0;
    r = make(s, folder, io, path, dataset, ret_text, err);
    if (r == 0 && *ret_text)
        remember(s, dataset, &stamp, *ret_text);
    return r;
}
