/* SPDX-License-Identifier: Apache-2.0 */
#include "sample_table.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/config/units.h"

#define TABLE_BYTES_MAX ((size_t)1 << 20)
#define COLUMNS_MAX     32

enum column {
    COLUMN_ID,
    COLUMN_TITLE,
    COLUMN_TREATMENT,
    COLUMN_X,
    COLUMN_Y,
    COLUMN_WIDTH,
    COLUMN_HEIGHT,
    COLUMN_COUNT
};

static const struct {
    const char *name;
    enum column column;
} NAMES[] = {{"id", COLUMN_ID},
             {"title", COLUMN_TITLE},
             {"species", COLUMN_TITLE},
             {"material", COLUMN_TITLE},
             {"treatment", COLUMN_TREATMENT},
             {"x", COLUMN_X},
             {"y", COLUMN_Y},
             {"width", COLUMN_WIDTH},
             {"height", COLUMN_HEIGHT}};

struct parse {
    const char *path;
    char *at; /* what is not read yet */
    char apart;
    unsigned line;
    int place[COLUMN_COUNT]; /* of each column in a line; -1: not there */
    struct ttf_err *err;
};

static int wrong(const struct parse *p, const char *what, const char *field)
{
    ttf_err_set(p->err, -EINVAL, p->path, "line %u: %s '%.60s'", p->line, what, field);
    ttf_err_hint(p->err, "the first line names columns: id,x,y,width,height,title,treatment");
    return -EINVAL;
}

/* One field, without its quotes, ended by zero; *ret_apart: what ended it. */
static char *take_field(struct parse *p, char *ret_apart)
{
    char *field = p->at, *put = p->at, *at = p->at;
    bool quoted = *at == '"';

    at += quoted;
    while (*at && (quoted || (*at != p->apart && *at != '\n'))) {
        if (quoted && *at == '"') {
            quoted = at[1] == '"';
            at += quoted ? 1 : 0;
            if (!quoted) {
                at++;
                continue;
            }
        }
        *put++ = *at++;
    }
    *ret_apart = *at;
    p->at = at + (*at != '\0');
    while (put > field && (put[-1] == '\r' || put[-1] == ' '))
        put--;
    *put = '\0';
    return field;
}

/* The fields of a line, those beyond COLUMNS_MAX dropped; 0: it is empty, or each of them is, as of rows that a spreadsheet saves below the last. */
static unsigned take_line(struct parse *p, char *fields[COLUMNS_MAX])
{
    bool said = false;
    unsigned n = 0;
    char apart;

    p->line++;
    do {
        char *field = take_field(p, &apart);

        said = said || *field;
        if (n < COLUMNS_MAX)
            fields[n++] = field;
    } while (apart == p->apart);
    return said ? n : 0;
}

static int take_head(struct parse *p)
{
    static const char others[] = ";\t";
    char *fields[COLUMNS_MAX];
    unsigned n;

    if (strncmp(p->at, "\xef\xbb\xbf", 3) == 0) /* as spreadsheets begin a text */
        p->at += 3;
    p->apart = ',';
    for (const char *other = others; *other; other++)
        if (memchr(p->at, *other, strcspn(p->at, "\n")))
            p->apart = *other;
    for (int i = 0; i < COLUMN_COUNT; i++)
        p->place[i] = -1;
    n = take_line(p, fields);
    for (unsigned i = 0; i < n; i++) {
        size_t name = 0;

        while (name < TTF_COUNT_OF(NAMES) && strcmp(NAMES[name].name, fields[i]) != 0)
            name++;
        if (name == TTF_COUNT_OF(NAMES))
            return wrong(p, "there is no column", fields[i]);
        if (p->place[NAMES[name].column] >= 0)
            return wrong(p, "twice the column", fields[i]);
        p->place[NAMES[name].column] = (int)i;
    }
    return p->place[COLUMN_ID] < 0 ? wrong(p, "there is no column", "id") : 0;
}

/* A region if any of its cells says something. */
static int take_region(struct parse *p, char *const cells[COLUMN_COUNT],
                       struct ttf_sample_rect *ret, const struct ttf_sample_rect **ret_there)
{
    int64_t *const to[] = {&ret->x, &ret->y, &ret->width, &ret->height};
    bool there = false;

    for (int i = 0; i < 4; i++)
        there = there || (cells[COLUMN_X + i] && cells[COLUMN_X + i][0]);
    for (int i = 0; there && i < 4; i++) {
        const char *cell = cells[COLUMN_X + i] ? cells[COLUMN_X + i] : "";

        if (ttf_integer_parse(cell, to[i], p->err) < 0)
            return wrong(p, "no whole number of pixels is", cell);
    }
    *ret_there = there ? ret : NULL;
    return 0;
}

/* Only what is said is changed: NULL, nothing is. */
static const char *take_text(const char *cell)
{
    return cell && *cell ? cell : NULL;
}

static int take_sample(struct parse *p, char *const fields[COLUMNS_MAX], unsigned n,
                       struct sample_table *table)
{
    struct ttf_sample_change *change = &table->changes[table->n];
    char *cells[COLUMN_COUNT] = {NULL};

    for (int i = 0; i < COLUMN_COUNT; i++)
        if (p->place[i] >= 0 && (unsigned)p->place[i] < n)
            cells[i] = fields[p->place[i]];
    if (!cells[COLUMN_ID] || cells[COLUMN_ID][0] == '\0')
        return wrong(p, "a sample without an id:", fields[0]);
    change->id = cells[COLUMN_ID];
    change->title = take_text(cells[COLUMN_TITLE]);
    change->treatment = take_text(cells[COLUMN_TREATMENT]);
    return take_region(p, cells, &table->regions[table->n++], &change->region);
}

int sample_table_read(struct ttf_io *io, const char *path, struct sample_table *ret,
                      struct ttf_err *err)
{
    struct parse p = {.path = path, .err = err};
    char *fields[COLUMNS_MAX];
    int r;

    *ret = (struct sample_table){0};
    r = ttf_io_slurp(io, path, TABLE_BYTES_MAX, &ret->text, NULL, err);
    if (r)
        return r;
    ret->changes = calloc(TTF_SAMPLES_MAX, sizeof(*ret->changes));
    ret->regions = calloc(TTF_SAMPLES_MAX, sizeof(*ret->regions));
    if (!ret->changes || !ret->regions)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    p.at = ret->text;
    r = take_head(&p);
    while (r == 0 && *p.at) {
        unsigned n = take_line(&p, fields);

        if (n > 0 && ret->n == TTF_SAMPLES_MAX)
            return wrong(&p, "more samples than there may be:", fields[0]);
        r = n > 0 ? take_sample(&p, fields, n, ret) : 0;
    }
    if (r == 0 && ret->n == 0)
        r = wrong(&p, "there is no sample in", path);
    return r;
}

void sample_table_free(struct sample_table *table)
{
    free(table->changes);
    free(table->regions);
    free(table->text);
}
