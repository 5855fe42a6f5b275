/* SPDX-License-Identifier: Apache-2.0 */
/* framing.h: lines with the seq and crc that hold: no mutation ever finds them by itself. */
#ifndef FUZZ_FRAMING_H
#define FUZZ_FRAMING_H

#include <stddef.h>
#include <stdint.h>

/*
 * Each line anew, counted and with its crc; a line that begins with '~' stays as it is, without
 * the '~'. What ends without a newline still does. To be freed.
 */
char *fuzz_frame_lines(const uint8_t *data, size_t size, size_t *ret_size);

#endif
