/* SPDX-License-Identifier: Apache-2.0 */
/* Values of a chart as makers and measuring programs write them; nothing in the file is trusted. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/chart.h"

#define FILE_BYTES ((size_t)1 << 20)

struct values {
    struct ttf_chart *chart;
    bool have[TTF_CHART_PATCHES];
    unsigned n;
    int named; /* lines say which patch they are: 1, do not: 0, -1: not known yet */
};

static bool separates(char c)
{
    return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\r';
}

/* "37,99;13,56;14,06" would read as six other numbers, and nothing would look wrong. */
static bool decimal_commas(const char *line)
{
    const char *comma = line;

    if (!strpbrk(line, ";\t"))
        return false;
    while ((comma = strchr(comma, ','))) {
        if (comma > line && isdigit((unsigned char)comma[-1]) && isdigit((unsigned char)comma[1]))
            return true;
        comma++;
    }
    return false;
}

/* The last three words as numbers; false if they are none. *ret_first: where the first of them begins. */
static bool last_three(char *line, double ret[3], const char **ret_first)
{
    char *end = line + strlen(line);

    for (int i = 2; i >= 0; i--) {
        char *word, *rest;

        while (end > line && separates(end[-1]))
            end--;
        *end = '\0';
        word = end;
        while (word > line && !separates(word[-1]))
            word--;
        if (word == end)
            return false;
        ret[i] = strtod(word, &rest);
        if (*rest != '\0' || !isfinite(ret[i]))
            return false;
        end = word;
    }
    *ret_first = end;
    return true;
}

/* "A1" to "F4" at the line's beginning: the patch by rows, else -1. */
static int named_patch(const char *line, const char *values)
{
    const char *word = line;
    int column, row;

    while (word < values && (separates(*word) || *word == '"'))
        word++;
    if (values - word < 2)
        return -1;
    column = toupper((unsigned char)word[0]) - 'A';
    row = word[1] - '1';
    if (column < 0 || column >= TTF_CHART_COLUMNS || row < 0 || row >= TTF_CHART_ROWS ||
        (isalnum((unsigned char)word[2]) && word + 2 < values))
        return -1;
    return row * TTF_CHART_COLUMNS + column;
}

static int take(struct values *v, int patch, const double lab[3], const char *where,
                struct ttf_err *err)
{
    if (v->named >= 0 && v->named != (patch >= 0))
        return ttf_err_set(err, -EINVAL, where, "some lines name their patch, and some do not");
    v->named = patch >= 0;
    if (patch < 0)
        patch = (int)v->n;
    if (v->n == TTF_CHART_PATCHES)
        return ttf_err_set(err, -EINVAL, where, "there are more than %d patches",
                           TTF_CHART_PATCHES);
    if (v->have[patch])
        return ttf_err_set(err, -EINVAL, where, "this patch was given before");
    if (!(lab[0] >= 0 && lab[0] <= 110) || fabs(lab[1]) > 200 || fabs(lab[2]) > 200)
        return ttf_err_set(err, -EINVAL, where, "%g %g %g are no L*, a* and b*", lab[0], lab[1],
                           lab[2]);
    memcpy(v->chart->lab[patch], lab, sizeof v->chart->lab[patch]);
    v->have[patch] = true;
    v->n++;
    return 0;
}

static int take_lines(struct values *v, char *text, const char *path, struct ttf_err *err)
{
    bool cgats = strstr(text, "BEGIN_DATA\n") || strstr(text, "BEGIN_DATA\r");
    bool counts = !cgats;
    char where[256], *rest = text, *line;
    unsigned number = 0;
    int r = 0;

    while (r == 0 && (line = strsep(&rest, "\n"))) {
        const char *first;
        double lab[3];

        number++;
        if (cgats && (strncmp(line, "BEGIN_DATA", 10) == 0 || strncmp(line, "END_DATA", 8) == 0)) {
            counts = strncmp(line, "BEGIN_DATA", 10) == 0 && line[10] != '_';
            continue;
        }
        if (!counts || line[0] == '#')
            continue;
        (void)snprintf(where, sizeof where, "%s:%u", path, number);
        if (decimal_commas(line))
            return ttf_err_set(err, -EINVAL, where,
                               "has decimal commas: write numbers with a point");
        if (!last_three(line, lab, &first))
            continue;
        r = take(v, named_patch(line, first), lab, where, err);
    }
    return r;
}

int ttf_chart_load(struct ttf_io *io, const char *path, struct ttf_chart *ret, struct ttf_err *err)
{
    struct ttf_chart chart = {0};
    struct values values = {.chart = &chart, .named = -1};
    char *text = NULL;
    size_t bytes;
    int r = ttf_io_slurp(io, path, FILE_BYTES, &text, &bytes, err);

    if (r < 0)
        return r;
    r = take_lines(&values, text, path, err);
    free(text);
    if (r < 0)
        return r;
    if (values.n < TTF_CHART_PATCHES) {
        ttf_err_set(err, -EINVAL, path, "has L*, a* and b* of %u patches, not of %d", values.n,
                    TTF_CHART_PATCHES);
        ttf_err_hint(err,
                     "one line a patch that ends in the three numbers, by rows from the top left");
        return -EINVAL;
    }
    *ret = chart;
    return 0;
}
