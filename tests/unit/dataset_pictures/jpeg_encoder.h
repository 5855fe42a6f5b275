/* SPDX-License-Identifier: Apache-2.0 */
/* jpeg_encoder.h: a lossless JPEG writer that tests hold the decoder against: slow, plain, from T.81. */
#ifndef JPEG_ENCODER_H
#define JPEG_ENCODER_H

#include <stddef.h>
#include <stdint.h>

struct jpeg_encoding {
    uint32_t width, height;
    unsigned components, bits, predictor;
    unsigned restart_rows; /* 0: none */
};

/* Bytes written to ret, which must have room (4 bytes a sample and 1 KiB will do). */
size_t jpeg_encode(const struct jpeg_encoding *encoding, const uint16_t *samples, uint8_t *ret);

#endif
