/* SPDX-License-Identifier: Apache-2.0 */
/* A learner as bytes: a header, the noise's counts, and each factorisation's numbers. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "search/hash.h"
#include "search/learner.h"

static const char MAGIC[8] = "ttfUS\0\2";

struct header {
    char magic[8];
    uint32_t byte_order; /* 1 as this machine writes it */
    uint32_t metric, n_factors, room, frames, reserved;
    uint64_t pixels;
    uint64_t digest; /* of all that follows: a damaged byte must not spoil a search */
};

static uint64_t digest_of(const uint8_t *bytes, size_t size)
{
    uint64_t h = ttf_mix64(size), word = 0;

    for (size_t i = 0; i < size; i += sizeof(word)) {
        word = 0;
        memcpy(&word, bytes + i, size - i < sizeof(word) ? size - i : sizeof(word));
        h = ttf_mix64(h + word);
    }
    return h;
}

static size_t tiles_bytes(const struct ttf_factors *f)
{
    return ttf_factors_tiles(f) * sizeof(*f->tile_energy);
}

static size_t energies_bytes(const struct ttf_factors *f)
{
    return tiles_bytes(f) + f->pixels * sizeof(*f->energy);
}

static size_t coefs_bytes(const struct ttf_factors *f)
{
    return f->pixels * f->room * sizeof(*f->coefs);
}

int ttf_learner_pack(const struct ttf_learner *learner, enum ttf_metric metric,
                     struct ttf_quilt_factors *ret)
{
    const struct ttf_factors *first = &learner->factors[0];
    struct header header = {.byte_order = 1,
                            .metric = metric,
                            .n_factors = learner->n_factors,
                            .room = first->room,
                            .frames = first->frames,
                            .pixels = first->pixels};
    size_t own = coefs_bytes(first) + energies_bytes(first);
    size_t size = sizeof(header) + sizeof(learner->noise) + learner->n_factors * own;
    uint8_t *bytes = malloc(size), *at = bytes;

    if (!bytes)
        return -ENOMEM;
    memcpy(header.magic, MAGIC, sizeof(MAGIC));
    at += sizeof(header);
    memcpy(at, &learner->noise, sizeof(learner->noise));
    at += sizeof(learner->noise);
    for (unsigned i = 0; i < learner->n_factors; i++) {
        const struct ttf_factors *f = &learner->factors[i];

        memcpy(at, f->tile_energy, tiles_bytes(f));
        memcpy(at + tiles_bytes(f), f->energy, f->pixels * sizeof(*f->energy));
        memcpy(at + energies_bytes(f), f->coefs, coefs_bytes(f));
        at += own;
    }
    header.digest = digest_of(bytes + sizeof(header), size - sizeof(header));
    memcpy(bytes, &header, sizeof(header));
    *ret = (struct ttf_quilt_factors){bytes, size};
    return 0;
}

static int check_header(const struct header *header, const struct ttf_quilt_factors *bytes,
                        const struct ttf_sources *sources, unsigned room, unsigned n_factors,
                        enum ttf_metric metric, struct ttf_err *err)
{
    if (bytes->size < sizeof(*header) || memcmp(header->magic, MAGIC, sizeof(MAGIC)) != 0 ||
        header->byte_order != 1)
        return ttf_err_set(err, -EINVAL, "factors", "these are no factors of this program");
    if (header->pixels != sources->pixels)
        return ttf_err_set(err, -EINVAL, "factors", "they are of %llu pixels, the input has %u",
                           (unsigned long long)header->pixels, sources->pixels);
    if (header->n_factors != n_factors || header->room != room || header->metric != metric)
        return ttf_err_set(err, -EINVAL, "factors",
                           "they were made with another rank, metric or kind of factorisation");
    if (header->frames == 0 || header->frames > sources->frames)
        return ttf_err_set(err, -EINVAL, "factors", "they are of %u frames, the input has %u",
                           header->frames, sources->frames);
    return 0;
}

/* The last frame that is known must be the sources' own: else these are another sample's factors. */
static int check_last(const struct ttf_second_differences *noise, uint32_t frames,
                      const struct ttf_sources *sources, const uint8_t *table, struct ttf_err *err)
{
    uint16_t *scratch = malloc(TTF_SOURCES_PIECE * sizeof(*scratch));
    uint8_t *codes = malloc((size_t)sources->pixels * 3);
    int r = -ENOMEM;

    if (scratch && codes)
        r = ttf_sources_read_codes(sources, frames - 1, table, scratch, codes, err);
    else
        ttf_err_set(err, r, NULL, "no memory for a frame");
    if (r == 0 && !ttf_second_differences_is_last(noise, codes, sources->pixels)) {
        r = ttf_err_set(err, -EINVAL, "factors", "frame %u of the input is not the one they know",
                        frames - 1);
        ttf_err_hint(err, "they belong to another dataset, or to other options");
    }
    free(scratch);
    free(codes);
    return r;
}

int ttf_learner_unpack(const struct ttf_quilt_factors *bytes, const struct ttf_sources *sources,
                       unsigned room, bool per_channel, enum ttf_metric metric,
                       const uint8_t *table, struct ttf_learner *ret, struct ttf_err *err)
{
    struct header header = {0};
    struct ttf_learner learner = {0};
    const uint8_t *at = bytes->bytes;
    size_t own;
    int r;

    memcpy(&header, at, bytes->size < sizeof(header) ? bytes->size : sizeof(header));
    r = check_header(&header, bytes, sources, room, per_channel ? 3 : 1, metric, err);
    if (r == 0 && ttf_learner_create(sources->pixels, room, per_channel, &learner) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for the factors");
    if (r < 0)
        return r;
    own = coefs_bytes(&learner.factors[0]) + energies_bytes(&learner.factors[0]);
    if (bytes->size != sizeof(header) + sizeof(learner.noise) + learner.n_factors * own) {
        ttf_learner_free(&learner);
        return ttf_err_set(err, -EINVAL, "factors", "they are cut short");
    }
    at += sizeof(header);
    if (digest_of(at, bytes->size - sizeof(header)) != header.digest) {
        ttf_learner_free(&learner);
        return ttf_err_set(err, -EINVAL, "factors", "they are damaged");
    }
    memcpy(&learner.noise, at, sizeof(learner.noise));
    at += sizeof(learner.noise);
    for (unsigned i = 0; i < learner.n_factors; i++, at += own) {
        struct ttf_factors *f = &learner.factors[i];

        memcpy(f->tile_energy, at, tiles_bytes(f));
        memcpy(f->energy, at + tiles_bytes(f), f->pixels * sizeof(*f->energy));
        memcpy(f->coefs, at + energies_bytes(f), coefs_bytes(f));
        f->frames = header.frames;
    }
    learner.known = header.frames;
    r = check_last(&learner.noise, header.frames, sources, table, err);
    if (r < 0) {
        ttf_learner_free(&learner);
        return r;
    }
    *ret = learner;
    return 0;
}

bool ttf_learner_is_of_other(const struct ttf_quilt_factors *bytes,
                             const struct ttf_sources *sources, unsigned room, bool per_channel,
                             enum ttf_metric metric)
{
    struct header header = {0};

    memcpy(&header, bytes->bytes, bytes->size < sizeof(header) ? bytes->size : sizeof(header));
    header.pixels = sources->pixels; /* may be others */
    return check_header(&header, bytes, sources, room, per_channel ? 3 : 1, metric, NULL) == 0 &&
           digest_of((const uint8_t *)bytes->bytes + sizeof(header),
                     bytes->size - sizeof(header)) == header.digest;
}
