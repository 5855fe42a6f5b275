/* SPDX-License-Identifier: Apache-2.0 */
#include "mdns.h"

#include <string.h>

#define HEAD      12
#define POINTER   0xc0   /* of a name's end that stands elsewhere: RFC 1035, 4.1.4 */
#define OUR_NAME  0xc00c /* the first name behind the head, which is always ours */
#define JUMPS_MAX 8
#define LABELS_MAX \
    4500 /* of all names of a datagram: what the largest holds without pointers; by pointers a hostile one has 180,000 */
#define TYPE_A    1
#define TYPE_NSEC 47
#define TYPE_ANY  255
#define CLASS_IN  1
#define CLASS_ANY 255
#define TOP \
    0x8000 /* of a question's class: to who asks alone; of a record's: forget what you knew */
#define ANSWER       0x8000 /* flags: it is one, */
#define OPCODE       0x7800
#define SURE         0x0400 /* of who knows */
#define LEGACY_TTL_S 10     /* 6.7: they are told of no change */

struct reader {
    const uint8_t *data;
    size_t n, at;
    unsigned labels; /* read so far */
};

struct writer {
    uint8_t *data;
    size_t n;
};

bool mdns_is_name(const char *name)
{
    size_t n = strlen(name);

    return n >= 1 && n <= 63 &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-") == n;
}

/* ---- reading ---- */

static bool take16(struct reader *r, unsigned *ret)
{
    if (r->n - r->at < 2)
        return false;
    *ret = (unsigned)r->data[r->at] << 8 | r->data[r->at + 1];
    r->at += 2;
    return true;
}

static bool take32(struct reader *r, uint32_t *ret)
{
    unsigned high, low;

    if (!take16(r, &high) || !take16(r, &low))
        return false;
    *ret = (uint32_t)high << 16 | low;
    return true;
}

static uint8_t small(uint8_t c)
{
    return c >= 'A' && c <= 'Z' ? c | 0x20 : c;
}

static bool same(const uint8_t *label, size_t n, const char *text)
{
    if (strlen(text) != n)
        return false;
    for (size_t i = 0; i < n; i++)
        if (small(label[i]) != small((uint8_t)text[i]))
            return false;
    return true;
}

/* One label, at *at, which goes on behind it; NULL: the name's end (*ret_n 0), or no name (*ret_n 1). */
static const uint8_t *next_label(const struct reader *r, size_t *at, unsigned *jumps, size_t *ret_n)
{
    *ret_n = 1;
    while (*at < r->n && (r->data[*at] & POINTER) == POINTER) {
        if (*at + 1 >= r->n || ++*jumps > JUMPS_MAX)
            return NULL;
        *at = (size_t)(r->data[*at] & ~POINTER) << 8 | r->data[*at + 1];
    }
    if (*at >= r->n || r->data[*at] > 63 || r->n - *at - 1 < r->data[*at])
        return NULL;
    *ret_n = r->data[*at];
    *at += 1 + *ret_n;
    return *ret_n > 0 ? r->data + *at - *ret_n : NULL;
}

/* Passes over a name. False: it is none. *ret_ours: it is NAME.local. */
static bool take_name(struct reader *r, const char *name, bool *ret_ours)
{
    const char *const wanted[] = {name, "local"};
    size_t at = r->at, n;
    unsigned jumps = 0, labels = 0;
    const uint8_t *label;

    *ret_ours = true;
    while ((label = next_label(r, &at, &jumps, &n))) {
        *ret_ours = *ret_ours && labels < 2 && same(label, n, wanted[labels]);
        if (++labels > 128 || ++r->labels > LABELS_MAX)
            return false;
    }
    *ret_ours = *ret_ours && labels == 2;
    if (n != 0)
        return false;
    /* In its place it ends at its own end, or behind its first pointer. */
    while (r->data[r->at] != 0 && (r->data[r->at] & POINTER) != POINTER)
        r->at += 1 + (size_t)r->data[r->at];
    r->at += r->data[r->at] == 0 ? 1 : 2;
    return true;
}

/* ---- writing ---- */

static void put16(struct writer *w, unsigned v)
{
    w->data[w->n++] = (uint8_t)(v >> 8);
    w->data[w->n++] = (uint8_t)v;
}

static void put_label(struct writer *w, const char *text)
{
    size_t n = strlen(text);

    w->data[w->n++] = (uint8_t)n;
    memcpy(w->data + w->n, text, n);
    w->n += n;
}

/* The first time in full, then by a pointer to that. */
static void put_name(struct writer *w, const struct mdns_host *host)
{
    if (w->n > HEAD) {
        put16(w, OUR_NAME);
        return;
    }
    put_label(w, host->name);
    put_label(w, "local");
    w->data[w->n++] = 0;
}

static void put_record(struct writer *w, const struct mdns_host *host, unsigned type,
                       unsigned class_, uint32_t ttl_s)
{
    put_name(w, host);
    put16(w, type);
    put16(w, class_);
    put16(w, ttl_s >> 16);
    put16(w, ttl_s & 0xffff);
}

static void put_address(struct writer *w, const struct mdns_host *host, unsigned class_,
                        uint32_t ttl_s)
{
    put_record(w, host, TYPE_A, class_, ttl_s);
    put16(w, sizeof host->address);
    memcpy(w->data + w->n, host->address, sizeof host->address);
    w->n += sizeof host->address;
}

/* 6.1: of this name there is an A record and nothing else, so nobody need wait for another. */
static void put_nothing_else(struct writer *w, const struct mdns_host *host)
{
    put_record(w, host, TYPE_NSEC, TOP | CLASS_IN, MDNS_TTL_S);
    put16(w, 5);
    put16(w, OUR_NAME);
    w->data[w->n++] = 0;              /* types 0 to 255, */
    w->data[w->n++] = 1;              /* of these one byte: */
    w->data[w->n++] = 0x80 >> TYPE_A; /* the first eight */
}

static void begin(struct writer *w, uint8_t *ret, unsigned id, unsigned questions, unsigned further)
{
    w->data = ret;
    w->n = 0;
    put16(w, id);
    put16(w, ANSWER | SURE);
    put16(w, questions);
    put16(w, 1); /* answers */
    put16(w, 0);
    put16(w, further);
}

size_t mdns_tell(const struct mdns_host *host, uint32_t ttl_s, uint8_t ret[MDNS_SIZE])
{
    struct writer w;

    begin(&w, ret, 0, 0, 0);
    put_address(&w, host, TOP | CLASS_IN, ttl_s);
    return w.n;
}

/* ---- answering ---- */

/* What a datagram asks of this name. */
struct asked {
    unsigned id;
    bool address, other; /* its address; anything else of it */
    unsigned type;       /* of the question about its address */
    bool to_all;         /* some question is to be answered to all */
    bool known;          /* who asks says that they know the address, and for long enough */
};

static bool take_questions(struct reader *r, const struct mdns_host *host, unsigned n,
                           struct asked *ret)
{
    unsigned type, class_;
    bool ours;

    for (; n > 0; n--) {
        if (!take_name(r, host->name, &ours) || !take16(r, &type) || !take16(r, &class_))
            return false;
        if (!ours ||
            ((class_ & ~(unsigned)TOP) != CLASS_IN && (class_ & ~(unsigned)TOP) != CLASS_ANY))
            continue;
        if (type == TYPE_A || type == TYPE_ANY) {
            ret->address = true;
            ret->type = type;
        } else {
            ret->other = true;
        }
        ret->to_all = ret->to_all || !(class_ & TOP);
    }
    return true;
}

/* 7.1: who knows it already, for at least half of its time, is not told again. */
static bool take_known(struct reader *r, const struct mdns_host *host, unsigned n,
                       struct asked *ret)
{
    unsigned type, class_, bytes;
    uint32_t ttl_s;
    bool ours;

    for (; n > 0; n--) {
        if (!take_name(r, host->name, &ours) || !take16(r, &type) || !take16(r, &class_) ||
            !take32(r, &ttl_s) || !take16(r, &bytes) || r->n - r->at < bytes)
            return false;
        if (ours && type == TYPE_A && (class_ & ~(unsigned)TOP) == CLASS_IN &&
            ttl_s >= MDNS_TTL_S / 2 && bytes == sizeof host->address &&
            memcmp(r->data + r->at, host->address, bytes) == 0)
            ret->known = true;
        r->at += bytes;
    }
    return true;
}

static bool read_asked(const struct mdns_host *host, struct reader *r, struct asked *ret)
{
    unsigned flags, questions, answers, authorities, further;

    if (!take16(r, &ret->id) || !take16(r, &flags) || !take16(r, &questions) ||
        !take16(r, &answers) || !take16(r, &authorities) || !take16(r, &further))
        return false;
    if (flags & (ANSWER | OPCODE))
        return false;
    return take_questions(r, host, questions, ret) && take_known(r, host, answers, ret);
}

/* As a server of plain DNS would: with its number and its question. */
static size_t answer_legacy(const struct mdns_host *host, const struct asked *asked, uint8_t *ret)
{
    struct writer w;

    begin(&w, ret, asked->id, 1, 0);
    put_name(&w, host);
    put16(&w, asked->type);
    put16(&w, CLASS_IN);
    put_address(&w, host, CLASS_IN, LEGACY_TTL_S);
    return w.n;
}

enum mdns_to mdns_answer(const struct mdns_host *host, const uint8_t *datagram, size_t n,
                         bool legacy, uint8_t ret[MDNS_SIZE], size_t *ret_n)
{
    struct reader r = {.data = datagram, .n = n};
    struct writer w;
    struct asked asked = {0};

    if (!read_asked(host, &r, &asked))
        return MDNS_NOBODY;
    asked.address = asked.address && !asked.known;
    if (legacy) {
        if (!asked.address)
            return MDNS_NOBODY;
        *ret_n = answer_legacy(host, &asked, ret);
        return MDNS_ASKER;
    }
    if (!asked.address && !asked.other)
        return MDNS_NOBODY;
    /* 6.2: who asks for the other kind of address will ask for this one next. */
    asked.address = !asked.known;
    begin(&w, ret, 0, 0, asked.address);
    if (asked.address)
        put_address(&w, host, TOP | CLASS_IN, MDNS_TTL_S);
    put_nothing_else(&w, host);
    *ret_n = w.n;
    if (!asked.to_all)
        return MDNS_ASKER;
    return asked.address ? MDNS_ALL : MDNS_ALL_ELSE;
}
