/* SPDX-License-Identifier: Apache-2.0 */
/* exported.h: frames to export, and exports that must succeed. */
#ifndef EXPORTED_H
#define EXPORTED_H

#include "trade_test.h"
#include "ttf/dataset/export.h"

/* Codes are light as they are. */
extern const struct ttf_encoding plain_light;

/* n frames of 8-bit sRGB noise as light: each height x width x 3. */
void fill_noise(uint16_t *frames, uint32_t width, uint32_t height, unsigned n);

/* Fails the test with the error's words. */
struct ttf_export_result export_ok(struct ttf_sequence *s, const struct ttf_export_config *config);

#endif
