/* SPDX-License-Identifier: Apache-2.0 */
/*
 * mutate.c: a mutator for texts of lines and JSON, beside the fuzzer's own. Lines are doubled, moved
 * and left out; numbers become odd ones; a value takes the place of another.
 */
#include <ctype.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

struct text {
    uint8_t *data;
    size_t size, room;
};

struct range {
    size_t at, n;
};

/* xorshift64: Marsaglia, "Xorshift RNGs" (2003), section 3. */
static uint64_t next(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

/* Puts bytes, which may lie in the text, in place of a range; false: no room. */
static bool replace(struct text *t, struct range r, const uint8_t *with, size_t n)
{
    uint8_t *copy = malloc(n + 1);

    if (!copy || t->size - r.n + n > t->room) {
        free(copy);
        return false;
    }
    memcpy(copy, with, n);
    memmove(t->data + r.at + n, t->data + r.at + r.n, t->size - r.at - r.n);
    memcpy(t->data + r.at, copy, n);
    t->size = t->size - r.n + n;
    free(copy);
    return true;
}

/* The line around a place, its newline included. */
static struct range line_at(const struct text *t, size_t at)
{
    struct range r = {at, 0};
    const uint8_t *end = memchr(t->data + at, '\n', t->size - at);

    while (r.at > 0 && t->data[r.at - 1] != '\n')
        r.at--;
    r.n = (end ? (size_t)(end - t->data) + 1 : t->size) - r.at;
    return r;
}

static bool double_line(struct text *t, uint64_t *state)
{
    struct range from = line_at(t, next(state) % t->size);
    struct range to = line_at(t, next(state) % t->size);

    return replace(t, (struct range){to.at, 0}, t->data + from.at, from.n);
}

static bool leave_out_line(struct text *t, uint64_t *state)
{
    return replace(t, line_at(t, next(state) % t->size), t->data, 0);
}

/* The digits, sign and point nearest behind a place. */
static bool find_number(const struct text *t, size_t from, struct range *ret)
{
    size_t at = from, n = 0;

    while (at < t->size && !isdigit(t->data[at]))
        at++;
    while (at + n < t->size && (isdigit(t->data[at + n]) || t->data[at + n] == '.'))
        n++;
    *ret = (struct range){at, n};
    return n > 0;
}

static bool odd_number(struct text *t, uint64_t *state)
{
    static const char *const ODD[] = {"0",
                                      "1",
                                      "2",
                                      "-1",
                                      "1.5",
                                      "255",
                                      "65535",
                                      "65536",
                                      "2147483647",
                                      "2147483648",
                                      "4294967295",
                                      "4294967296",
                                      "999999999999999999",
                                      "9223372036854775807",
                                      "-9223372036854775808",
                                      "9223372036854775808",
                                      "1e308",
                                      "1e-320",
                                      "1e999"};
    const char *odd = ODD[next(state) % (sizeof ODD / sizeof ODD[0])];
    struct range number;

    return find_number(t, next(state) % t->size, &number) &&
           replace(t, number, (const uint8_t *)odd, strlen(odd));
}

/* What stands between a place's next two of : , { } [ ] and line ends. */
static struct range value_at(const struct text *t, size_t at)
{
    static const char ENDS[] = ":,{}[]\n";
    struct range r;

    while (at < t->size && !strchr(ENDS, t->data[at]))
        at++;
    r = (struct range){at < t->size ? at + 1 : at, 0};
    while (r.at + r.n < t->size && !strchr(ENDS, t->data[r.at + r.n]))
        r.n++;
    return r;
}

static bool other_value(struct text *t, uint64_t *state)
{
    struct range to = value_at(t, next(state) % t->size);
    struct range from = value_at(t, next(state) % t->size);

    return replace(t, to, t->data + from.at, from.n);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed)
{
    struct text t = {data, size, room};
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15) ^ ((uint64_t)seed << 17 | 1);
    bool changed = false;

    (void)next(&state);
    if (size > 1)
        switch (next(&state) % 8) {
        case 0:
            changed = double_line(&t, &state);
            break;
        case 1:
            changed = leave_out_line(&t, &state);
            break;
        case 2:
            changed = odd_number(&t, &state);
            break;
        case 3:
            changed = other_value(&t, &state);
            break;
        default:
            break;
        }
    return changed && t.size > 0 ? t.size : LLVMFuzzerMutate(data, size, room);
}
