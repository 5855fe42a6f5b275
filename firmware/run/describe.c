/* SPDX-License-Identifier: Apache-2.0 */
/* describe.c: a board in words; see run.h. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "run.h"
#include "ttf/dataset/hash.h"

static void add(char *text, size_t size, const char *key, const char *equals, const char *value)
{
    size_t n = strlen(text);

    (void)snprintf(text + n, size - n, ", %s%s%s", key, equals, value);
}

void run_describe(struct ttf_io *io, const struct ttf_board *board,
                  const struct run_choices *choices, char ret[256])
{
    char text[4096];
    char hex[65] = "";
    char seed[32];
    struct ttf_sha256 hash;

    if (ttf_sha256_file(io, board->path, NULL, hex, NULL) < 0)
        hex[0] = '\0';
    (void)snprintf(text, sizeof text, "%s, board.yaml %.8s", board->name, hex);
    if (choices->scene)
        add(text, sizeof text, "scene", " ", choices->scene);
    for (unsigned i = 0; i < choices->n_sets; i++)
        add(text, sizeof text, choices->sets[i].path, "=", choices->sets[i].value);
    (void)snprintf(seed, sizeof seed, "%" PRIu64, board->sim.seed);
    if (choices->has_seed)
        add(text, sizeof text, "seed", " ", seed);
    if (strlen(text) < 256) {
        (void)snprintf(ret, 256, "%s", text);
        return;
    }
    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, text, strlen(text));
    ttf_sha256_hex(&hash, hex);
    (void)snprintf(ret, 256, "%.230s..., all %.8s", text, hex);
}
