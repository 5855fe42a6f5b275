/* SPDX-License-Identifier: Apache-2.0 */
/* picture.h: the picture readers are fuzzed through the front that users meet. */
#ifndef FUZZ_PICTURE_H
#define FUZZ_PICTURE_H

#include <stddef.h>
#include <stdint.h>

/* Probes, reads and makes linear; pictures beyond a million pixels are only probed. */
void fuzz_picture(const uint8_t *data, size_t size);

#endif
