/* SPDX-License-Identifier: Apache-2.0 */
#include "lossless_jpeg.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>

#include "ttf/base/err.h"

/* Markers (T.81, table B.1). */
enum {
    SOF3 = 0xc3,
    DHT = 0xc4,
    RST0 = 0xd0,
    SOI = 0xd8,
    EOI = 0xd9,
    SOS = 0xda,
    DRI = 0xdd
};

#define COMPONENTS_MAX 4
#define CLASSES        17 /* categories of differences, 0..16 */

/* A Huffman table as T.81, F.2.2.3 decodes it: least and most code of each length. */
struct huffman {
    bool defined;
    int32_t least[17], most[17]; /* most -1: no code of that length */
    unsigned first[17];          /* index of the first value of that length */
    uint8_t values[CLASSES];
    uint8_t fast_length[256]; /* of the code that the next 8 bits begin with, 0: longer */
    uint8_t fast_value[256];
};

struct decoder {
    const uint8_t *data, *end;
    struct huffman tables[4];
    struct lossless_jpeg_info info;
    bool has_frame;
    uint8_t component_ids[COMPONENTS_MAX];
    unsigned table_of[COMPONENTS_MAX];
    unsigned predictor, point_transform;
    unsigned restart; /* units between restart markers, 0: none */
    /* the scan's bits */
    uint64_t bits;
    unsigned n_bits, n_made_up; /* of them, the last ones that the data did not hold */
};

static int read_u16(struct decoder *d)
{
    int value;

    if (d->end - d->data < 2)
        return -TTF_EDAMAGED;
    value = d->data[0] << 8 | d->data[1];
    d->data += 2;
    return value;
}

/* ---- marker segments ---- */

static int build_table(struct huffman *table, const uint8_t counts[16], const uint8_t *values,
                       size_t n)
{
    int32_t code = 0;
    unsigned k = 0;

    memset(table, 0, sizeof(*table));
    memcpy(table->values, values, n);
    for (unsigned length = 1; length <= 16; length++) {
        table->first[length] = k;
        table->least[length] = code;
        table->most[length] = code + counts[length - 1] - 1;
        if (code + counts[length - 1] > (int32_t)1 << length)
            return -TTF_EDAMAGED;
        for (unsigned i = 0; length <= 8 && i < counts[length - 1]; i++) {
            unsigned from = (unsigned)(code + (int32_t)i) << (8 - length);

            memset(table->fast_length + from, (int)length, (size_t)1 << (8 - length));
            memset(table->fast_value + from, table->values[k + i], (size_t)1 << (8 - length));
        }
        k += counts[length - 1];
        code = (code + counts[length - 1]) << 1;
    }
    table->defined = true;
    return 0;
}

static int read_dht(struct decoder *d, const uint8_t *segment, size_t n)
{
    while (n > 0) {
        size_t total = 0;
        unsigned id;
        int r;

        if (n < 17)
            return -TTF_EDAMAGED;
        id = segment[0];
        for (int i = 0; i < 16; i++)
            total += segment[1 + i];
        if (id > 3 || total > CLASSES || n < 17 + total)
            return -TTF_EDAMAGED;
        for (size_t i = 0; i < total; i++) {
            if (segment[17 + i] >= CLASSES)
                return -TTF_EDAMAGED;
        }
        r = build_table(&d->tables[id], segment + 1, segment + 17, total);
        if (r < 0)
            return r;
        segment += 17 + total;
        n -= 17 + total;
    }
    return 0;
}

static int read_sof(struct decoder *d, const uint8_t *segment, size_t n)
{
    if (d->has_frame || n < 6)
        return -TTF_EDAMAGED;
    d->info.bits = segment[0];
    d->info.height = (uint32_t)segment[1] << 8 | segment[2];
    d->info.width = (uint32_t)segment[3] << 8 | segment[4];
    d->info.components = segment[5];
    if (d->info.bits < 2 || d->info.bits > 16 || d->info.components < 1 ||
        d->info.components > COMPONENTS_MAX || n < 6 + 3 * (size_t)d->info.components)
        return -TTF_EDAMAGED;
    if (d->info.width == 0 || d->info.height == 0)
        return -ENOTSUP; /* a height told after the scan: no camera does that */
    for (unsigned c = 0; c < d->info.components; c++) {
        d->component_ids[c] = segment[6 + 3 * c];
        if (segment[7 + 3 * c] != 0x11)
            return -ENOTSUP; /* subsampled */
    }
    d->has_frame = true;
    return 0;
}

static int read_sos(struct decoder *d, const uint8_t *segment, size_t n)
{
    unsigned components;

    if (!d->has_frame || n < 1)
        return -TTF_EDAMAGED;
    components = segment[0];
    if (components != d->info.components)
        return -ENOTSUP; /* a scan per component */
    if (n < 4 + 2 * (size_t)components)
        return -TTF_EDAMAGED;
    for (unsigned c = 0; c < components; c++) {
        unsigned table = segment[2 + 2 * c] >> 4;

        if (segment[1 + 2 * c] != d->component_ids[c] || table > 3 || !d->tables[table].defined)
            return -TTF_EDAMAGED;
        d->table_of[c] = table;
    }
    d->predictor = segment[1 + 2 * components];
    d->point_transform = segment[3 + 2 * components] & 15u;
    if (d->predictor < 1 || d->predictor > 7 || d->point_transform >= d->info.bits)
        return -TTF_EDAMAGED;
    return 0;
}

/* Reads segments up to and with SOS. */
static int read_header(struct decoder *d)
{
    if (read_u16(d) != (0xff00 | SOI))
        return -TTF_EDAMAGED;
    for (;;) {
        int marker = read_u16(d), length = read_u16(d), r = 0;
        const uint8_t *segment = d->data;

        if (marker < 0xff00 || length < 2 || length - 2 > d->end - d->data)
            return -TTF_EDAMAGED;
        length -= 2;
        marker &= 0xff;
        d->data += length;
        if (marker == DHT)
            r = read_dht(d, segment, (size_t)length);
        else if (marker == SOF3)
            r = read_sof(d, segment, (size_t)length);
        else if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc8)
            r = -ENOTSUP; /* a lossy or arithmetic process */
        else if (marker == DRI)
            d->restart = length >= 2 ? (unsigned)segment[0] << 8 | segment[1] : 0;
        else if (marker == SOS)
            return read_sos(d, segment, (size_t)length);
        if (r < 0)
            return r;
    }
}

/* ---- the scan ---- */

/* Tops up to more than 56 bits; behind a marker or the end come made-up zeros, which are counted. */
static void fill_bits(struct decoder *d)
{
    while (d->n_bits <= 56) {
        uint8_t byte = 0;

        if (d->data < d->end && d->data[0] != 0xff) {
            byte = *d->data++;
        } else if (d->end - d->data >= 2 && d->data[0] == 0xff && d->data[1] == 0) {
            byte = 0xff;
            d->data += 2;
        } else {
            d->n_made_up += 8;
        }
        d->bits = d->bits << 8 | byte;
        d->n_bits += 8;
    }
}

static unsigned take_bits(struct decoder *d, unsigned n)
{
    d->n_bits -= n;
    return (unsigned)(d->bits >> d->n_bits) & ((1u << n) - 1);
}

/* The next difference (T.81, H.1.2.2). False for bits that are no code. */
static bool next_difference(struct decoder *d, const struct huffman *table, int32_t *ret)
{
    unsigned next8, category, value;

    if (d->n_bits < 40)
        fill_bits(d);
    next8 = (unsigned)(d->bits >> (d->n_bits - 8)) & 255u;
    if (table->fast_length[next8]) {
        d->n_bits -= table->fast_length[next8];
        category = table->fast_value[next8];
    } else {
        int32_t code = (int32_t)take_bits(d, 8);
        unsigned length = 8;

        do {
            if (++length > 16)
                return false;
            code = code << 1 | (int32_t)take_bits(d, 1);
        } while (code > table->most[length] || code < table->least[length]);
        category = table->values[table->first[length] + (unsigned)(code - table->least[length])];
    }
    if (category == 0) {
        *ret = 0;
    } else if (category == 16) {
        *ret = 32768;
    } else {
        value = take_bits(d, category);
        *ret = value >> (category - 1) ? (int32_t)value : (int32_t)value - (1 << category) + 1;
    }
    return true;
}

/* T.81, table H.1: a left, b above, c above left. */
static int32_t predict(unsigned predictor, int32_t a, int32_t b, int32_t c)
{
    switch (predictor) {
    case 1:
        return a;
    case 2:
        return b;
    case 3:
        return c;
    case 4:
        return a + b - c;
    case 5:
        return a + ((b - c) >> 1);
    case 6:
        return b + ((a - c) >> 1);
    default:
        return (a + b) >> 1;
    }
}

/* Drops what is left of the bits and steps over the marker. */
static int skip_restart(struct decoder *d)
{
    d->bits = 0;
    d->n_bits = 0;
    d->n_made_up = 0;
    while (d->end - d->data >= 2) {
        if (d->data[0] == 0xff && d->data[1] >= RST0 && d->data[1] < RST0 + 8) {
            d->data += 2;
            return 0;
        }
        if (d->data[0] == 0xff && d->data[1] != 0 && d->data[1] != 0xff)
            return -TTF_EDAMAGED;
        d->data++;
    }
    return -TTF_EDAMAGED;
}

/* One row; first: no row above counts, as at the start or after a restart. */
static int decode_row(struct decoder *d, uint16_t *row, const uint16_t *above, bool first)
{
    unsigned k = d->info.components;
    int32_t start = 1 << (d->info.bits - d->point_transform - 1);

    for (size_t x = 0; x < d->info.width; x++) {
        for (unsigned c = 0; c < k; c++) {
            size_t i = x * k + c;
            int32_t difference, p;

            if (!next_difference(d, &d->tables[d->table_of[c]], &difference))
                return -TTF_EDAMAGED;
            if (x == 0)
                p = first ? start : above[c];
            else if (first)
                p = row[i - k];
            else
                p = predict(d->predictor, row[i - k], above[i], above[i - k]);
            row[i] = (uint16_t)(p + difference);
        }
    }
    return 0;
}

static int decode_scan(struct decoder *d, uint16_t *ret)
{
    size_t n = (size_t)d->info.width * d->info.components;
    unsigned rows_each = 0;

    if (d->restart) {
        if (d->restart % d->info.width != 0)
            return -ENOTSUP; /* restarts amid a row */
        rows_each = d->restart / d->info.width;
    }
    for (uint32_t y = 0; y < d->info.height; y++) {
        bool restart = rows_each && y > 0 && y % rows_each == 0;
        int r = restart ? skip_restart(d) : 0;

        if (r == 0)
            r = decode_row(d, ret + y * n, y > 0 ? ret + (y - 1) * n : NULL, y == 0 || restart);
        if (r == 0 && d->n_bits < d->n_made_up)
            r = -TTF_EDAMAGED;
        if (r < 0)
            return r;
    }
    for (size_t i = 0; d->point_transform && i < n * d->info.height; i++)
        ret[i] = (uint16_t)(ret[i] << d->point_transform);
    return 0;
}

int lossless_jpeg_decode(const uint8_t *data, size_t bytes, uint16_t *ret, size_t room,
                         struct lossless_jpeg_info *ret_info)
{
    struct decoder d = {.data = data, .end = data + bytes};
    int r = read_header(&d);

    if (r < 0)
        return r;
    if ((uint64_t)d.info.width * d.info.height * d.info.components > room)
        return -ENOSPC;
    r = decode_scan(&d, ret);
    if (r == 0)
        *ret_info = d.info;
    return r;
}
