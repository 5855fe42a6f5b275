/* SPDX-License-Identifier: Apache-2.0 */
/* A quilting's map: what is accepted can be composed through, written, and read again as the same. */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "ttf/synth/map_file.h"

#define PIXELS_MAX 65536u /* of output and input: so much is composed */

static void compose(const struct ttf_quilt_map *map)
{
    size_t in = (size_t)map->source_pixels * 3, out = (size_t)map->width * map->height * 3;
    uint16_t *codes = calloc(in + out, sizeof *codes);

    if (codes)
        ttf_quilt_compose(map, codes, codes + in);
    free(codes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ttf_quilt_map map, again;
    struct ttf_err err = {0};
    struct ttf_json json;
    const char *text;
    size_t bytes;

    if (ttf_quilt_map_parse((const char *)data, size, PIXELS_MAX, &map, &err) < 0)
        return 0;
    if (map.source_pixels <= PIXELS_MAX)
        compose(&map);
    ttf_json_init(&json, true);
    ttf_quilt_map_json(&map, &json);
    if (ttf_json_finish(&json, &text, &bytes) < 0 ||
        ttf_quilt_map_parse(text, bytes, 0, &again, &err) < 0 ||
        ttf_quilt_map_digest(&map) != ttf_quilt_map_digest(&again))
        abort();
    ttf_json_free(&json);
    ttf_quilt_map_free(&map);
    ttf_quilt_map_free(&again);
    return 0;
}
