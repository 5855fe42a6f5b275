/* SPDX-License-Identifier: Apache-2.0 */
/* readme.c: readme.h. */
#include "boards/readme.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FAULT 160

/* What stands under a heading, to the next one of its rank; a copy, to be freed. NULL: it is not there. */
static char *section(const char *text, const char *heading)
{
    const size_t n = strlen(heading);
    const char *at = text, *end;

    while ((at = strstr(at, heading)) != NULL && ((at > text && at[-1] != '\n') || at[n] != '\n'))
        at += n;
    if (!at)
        return NULL;
    at += n;
    end = strstr(at, "\n## ");
    return strndup(at, end ? (size_t)(end - at) : strlen(at));
}

/* Whether `word` is in it, in whatever case; a number as a whole one. */
static bool has(const char *text, const char *word)
{
    const size_t n = strlen(word);
    const char *at = text;

    while ((at = strcasestr(at, word)) != NULL) {
        bool part =
            isdigit((unsigned char)word[0]) &&
            ((at > text && isdigit((unsigned char)at[-1])) || isdigit((unsigned char)at[n]));

        if (!part)
            return true;
        at++;
    }
    return false;
}

bool readme_draws(const char *text, const struct readme_wire *wires, unsigned n_wires,
                  char ret_fault[FAULT])
{
    char *wiring = section(text, "## Wiring");
    char *drawing = wiring ? strstr(wiring, "```\n") : NULL;
    char *end = drawing ? strstr(drawing + 4, "```") : NULL;
    bool ok = end != NULL;

    if (ok)
        *end = '\0';
    else
        (void)snprintf(ret_fault, FAULT, "there is no drawing of its wires");
    for (unsigned i = 0; ok && i < n_wires; i++) {
        ok = has(drawing, wires[i].label) && has(drawing, wires[i].line);
        if (!ok)
            (void)snprintf(ret_fault, FAULT, "its drawing has no %s at line %s", wires[i].label,
                           wires[i].line);
    }
    free(wiring);
    return !ok;
}

bool readme_counts(const char *text, const char *heading, unsigned least, char ret_fault[FAULT])
{
    char *parts = section(text, heading), *rest = parts;
    unsigned n = 0;
    bool body = false, ok = true;

    for (char *line; ok && rest && (line = strsep(&rest, "\n")) != NULL;) {
        bool rule = strncmp(line, "|---", 4) == 0;

        if (body && line[0] == '|' && !rule) {
            ok = strncmp(line, "| ", 2) == 0 && strtol(line + 2, NULL, 10) > 0;
            if (!ok)
                (void)snprintf(ret_fault, FAULT, "how many? %.100s", line);
            n++;
        }
        body = rule || (body && line[0] == '|');
    }
    if (ok && n < least)
        (void)snprintf(ret_fault, FAULT, "'%s' has %u parts in its tables", heading, n);
    free(parts);
    return !ok || n < least;
}

/* The end of the step that begins here: the next one, or the end of the list. */
static char *step_end(char *step)
{
    char *line = strchr(step, '\n');

    while (line && line[1] != '\0' && line[1] != '\n' && !isdigit((unsigned char)line[1]))
        line = strchr(line + 1, '\n');
    return line;
}

/* Steps without a check; *found[i] is set where a step has the wire i. */
static bool steps_check(char *list, const struct readme_wire *wires, unsigned n_wires, bool *found,
                        char ret_fault[FAULT])
{
    unsigned n = 0;

    for (char *at = list, *end; at && *at; at = end) {
        at += strspn(at, "\n");
        end = step_end(at);
        if (!isdigit((unsigned char)*at))
            continue;
        if (end)
            *end++ = '\0';
        n++;
        if (!strstr(at, "**Check:**")) {
            (void)snprintf(ret_fault, FAULT, "no check in: %.100s", at);
            return false;
        }
        for (unsigned i = 0; i < n_wires; i++)
            found[i] |= has(at, wires[i].label);
    }
    if (n < 3)
        (void)snprintf(ret_fault, FAULT, "%u steps are none", n);
    return n >= 3;
}

bool readme_checks(const char *text, const struct readme_wire *wires, unsigned n_wires,
                   char ret_fault[FAULT])
{
    char *wiring = section(text, "## Wiring, step by step");
    char *power = section(text, "## First power, step by step");
    bool found[32] = {false}, none[32];
    bool ok = wiring && power && n_wires <= 32;

    if (!ok)
        (void)snprintf(ret_fault, FAULT,
                       "there are no steps for its wires, or for its first power");
    ok = ok && steps_check(wiring, wires, n_wires, found, ret_fault) &&
         steps_check(power, wires, 0, none, ret_fault);
    for (unsigned i = 0; ok && i < n_wires; i++)
        if (!found[i]) {
            (void)snprintf(ret_fault, FAULT, "no step has the wire %s", wires[i].label);
            ok = false;
        }
    free(wiring);
    free(power);
    return !ok;
}
