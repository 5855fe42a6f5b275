/* SPDX-License-Identifier: Apache-2.0 */
/* fake_pi.c: raw streams as libcamera's pipelines of Raspberry Pis offer and grant them, by its source. */
#include "fake_libcamera.h"
#include "ttf/base/attr.h"

#define CODE(a, b, c, d) \
    ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)
#define PLAIN      UINT64_C(0)
#define PACKED     (UINT64_C(0x0b) << 56 | 1)
#define COMPRESSED (UINT64_C(0x0c) << 56 | 1)
#define ORDERS     4

/* Orders as they follow each other when the picture is turned: the first becomes the last, the second the third. */
static const struct mosaic {
    unsigned bits;
    uint64_t modifier;
    uint32_t code[ORDERS];
} MOSAICS[] = {
    {16,
     PLAIN,
     {CODE('R', 'G', 'B', '6'), CODE('G', 'R', '1', '6'), CODE('G', 'B', '1', '6'),
      CODE('B', 'Y', 'R', '2')}},
    {16,
     COMPRESSED,
     {CODE('R', 'G', 'B', '6'), CODE('G', 'R', '1', '6'), CODE('G', 'B', '1', '6'),
      CODE('B', 'Y', 'R', '2')}},
    {12,
     PLAIN,
     {CODE('R', 'G', '1', '2'), CODE('G', 'R', '1', '2'), CODE('G', 'B', '1', '2'),
      CODE('B', 'G', '1', '2')}},
    {12,
     PACKED,
     {CODE('R', 'G', '1', '2'), CODE('G', 'R', '1', '2'), CODE('G', 'B', '1', '2'),
      CODE('B', 'G', '1', '2')}},
    {10,
     PLAIN,
     {CODE('R', 'G', '1', '0'), CODE('G', 'R', '1', '0'), CODE('G', 'B', '1', '0'),
      CODE('B', 'G', '1', '0')}},
    {10,
     PACKED,
     {CODE('R', 'G', '1', '0'), CODE('G', 'R', '1', '0'), CODE('G', 'B', '1', '0'),
      CODE('B', 'G', '1', '0')}},
};

static const struct mosaic *mosaic_of(uint32_t fourcc, uint64_t modifier, unsigned *ret_order)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(MOSAICS); i++)
        for (unsigned order = 0; order < ORDERS; order++)
            if (MOSAICS[i].code[order] == fourcc && MOSAICS[i].modifier == modifier) {
                *ret_order = order;
                return &MOSAICS[i];
            }
    return NULL;
}

static uint32_t code_of(unsigned bits, uint64_t modifier, unsigned order)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(MOSAICS); i++)
        if (MOSAICS[i].bits == bits && MOSAICS[i].modifier == modifier)
            return MOSAICS[i].code[order];
    return 0;
}

void fake_pi_grant(const struct fake_libcamera *fake, const struct lc_ask *ask,
                   struct lc_granted *ret)
{
    unsigned order = 0, native = 0, bits;
    const struct mosaic *asked = mosaic_of(ask->fourcc, ask->modifier, &order);
    const struct mosaic *sensor = mosaic_of(fake->raw[0].fourcc, fake->raw[0].modifier, &native);

    if (!asked || !sensor)
        return;
    /* The order is that of the sensor as it reads out, whatever was asked. */
    order = fake->turned ? ORDERS - 1 - native : native;
    ret->modifier = asked->modifier;
    bits = asked->bits <= sensor->bits ? asked->bits : sensor->bits;
    if (fake->pipeline == FAKE_PISP) {
        /* Its front end writes words of 16 bits: plain, or compressed where packed ones are asked. */
        ret->modifier = asked->modifier == PLAIN ? PLAIN : COMPRESSED;
        bits = 16;
    }
    ret->fourcc = code_of(bits, ret->modifier, order);
}

void fake_libcamera_be_pi(struct fake_libcamera *fake, enum fake_pipeline pipeline)
{
    fake->pipeline = pipeline;
    fake->turned = true; /* the official modules' sensors stand on their heads */
    fake->stamp_readout = true;
    /* Of an imx477: packed alone is listed, and the small mode has fewer bits. */
    fake->raw[0] = (struct lc_offer){CODE('R', 'G', '1', '2'), PACKED, 64, 48};
    fake->raw[1] = (struct lc_offer){CODE('R', 'G', '1', '0'), PACKED, 32, 24};
    fake->raw[2] = (struct lc_offer){0};
}
