/* SPDX-License-Identifier: Apache-2.0 */
/* The plain ground of the photograph: a plane per channel, by iterated reweighting of its border. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "control/rates.h"
#include "control/shadow_parts.h"
#include "ttf/dataset/colour.h"

#define ROUNDS        16
#define BAND_SHARE    64     /* the border is a 64th of the smaller side */
#define TUKEY         4.685  /* in deviations: 95% efficient on plain noise (Huber & Ronchetti) */
#define MAD_TO_SIGMA  1.4826 /* of the median absolute deviation of normal noise */
#define SIGMA_LEAST   5e-4   /* of full scale; a synthetic ground has no noise at all */
#define RIDGE         1e-6   /* keeps a slope that nothing shows at 0 */
#define LUMINANCE_MIN 0.02f

struct sample {
    double u, v;
    double rgb[3];
    double weight;
};

struct border {
    struct sample *samples;
    double *scratch; /* as many */
    size_t n;
};

/* From -1/2 to 1/2 along the larger side, so that the equations are of one scale. */
static void place(const struct ttf_ground *ground, uint32_t x, uint32_t y, double *ret_u,
                  double *ret_v)
{
    double side = ground->width > ground->height ? ground->width : ground->height;

    *ret_u = ((double)x + 0.5 - 0.5 * (double)ground->width) / side;
    *ret_v = ((double)y + 0.5 - 0.5 * (double)ground->height) / side;
}

static double plane_at(const struct ttf_ground *ground, int c, double u, double v)
{
    return ground->at[c] + ground->across[c] * u + ground->down[c] * v;
}

static int border_collect(const struct ttf_pixbuf *photo, const struct ttf_ground *ground,
                          struct border *ret)
{
    uint32_t w = photo->width, h = photo->height, side = w < h ? w : h;
    uint32_t band = side / BAND_SHARE > 0 ? side / BAND_SHARE : 1;
    size_t room = 2 * (size_t)band * ((size_t)w + h);

    ret->n = 0;
    ret->samples = calloc(room, sizeof(*ret->samples));
    ret->scratch = calloc(room, sizeof(*ret->scratch));
    if (!ret->samples || !ret->scratch)
        return -ENOMEM;
    for (uint32_t y = 0; y < h; y++) {
        const float *row = ttf_pixbuf_row(photo, y);
        int whole = y < band || y >= h - band;

        for (uint32_t x = 0; x < w; x++) {
            struct sample *s = &ret->samples[ret->n];

            if (!whole && x >= band && x < w - band)
                continue;
            place(ground, x, y, &s->u, &s->v);
            for (int c = 0; c < 3; c++)
                s->rgb[c] = (double)row[3 * (size_t)x + (size_t)c];
            ret->n++;
        }
    }
    return 0;
}

static double median_of(struct border *border, int c, const struct ttf_ground *off)
{
    for (size_t i = 0; i < border->n; i++) {
        const struct sample *s = &border->samples[i];

        border->scratch[i] = off ? fabs(s->rgb[c] - plane_at(off, c, s->u, s->v)) : s->rgb[c];
    }
    return ttf_control_quantile(border->scratch, border->n, 0.5);
}

/* Tukey's biweight of the channel that differs most: a pixel is ground or it is not. */
static void weigh(struct border *border, const struct ttf_ground *ground)
{
    double reach[3];

    for (int c = 0; c < 3; c++) {
        double sigma = MAD_TO_SIGMA * median_of(border, c, ground);

        reach[c] = TUKEY * (sigma > SIGMA_LEAST ? sigma : SIGMA_LEAST);
    }
    for (size_t i = 0; i < border->n; i++) {
        struct sample *s = &border->samples[i];
        double worst = 0.0, left;

        for (int c = 0; c < 3; c++) {
            double off = fabs(s->rgb[c] - plane_at(ground, c, s->u, s->v)) / reach[c];

            worst = off > worst ? off : worst;
        }
        left = worst < 1.0 ? 1.0 - worst * worst : 0.0;
        s->weight = left * left;
    }
}

/* Symmetric, positive definite: elimination without pivots. */
static void solve3(double m[3][3], double b[3])
{
    for (int k = 0; k < 3; k++) {
        for (int i = k + 1; i < 3; i++) {
            double f = m[i][k] / m[k][k];

            for (int j = k; j < 3; j++)
                m[i][j] -= f * m[k][j];
            b[i] -= f * b[k];
        }
    }
    for (int k = 2; k >= 0; k--) {
        for (int j = k + 1; j < 3; j++)
            b[k] -= m[k][j] * b[j];
        b[k] /= m[k][k];
    }
}

/* Weighted least squares of one channel. */
static void fit_channel(const struct border *border, int c, struct ttf_ground *ground)
{
    double m[3][3] = {{0}}, b[3] = {0};

    for (size_t i = 0; i < border->n; i++) {
        const struct sample *s = &border->samples[i];
        double row[3] = {1.0, s->u, s->v};

        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++)
                m[j][k] += s->weight * row[j] * row[k];
            b[j] += s->weight * row[j] * s->rgb[c];
        }
    }
    m[1][1] += RIDGE * m[0][0];
    m[2][2] += RIDGE * m[0][0];
    solve3(m, b);
    ground->at[c] = b[0];
    ground->across[c] = b[1];
    ground->down[c] = b[2];
}

/* A plane is darkest at a corner. */
static int brightness_check(const struct ttf_ground *ground, struct ttf_err *err)
{
    for (int i = 0; i < 4; i++) {
        float rgb[3], luminance;

        ttf_ground_at(ground, i % 2 ? ground->width - 1 : 0, i / 2 ? ground->height - 1 : 0, rgb);
        luminance = ttf_luminance(rgb[0], rgb[1], rgb[2]);
        if (luminance >= LUMINANCE_MIN)
            continue;
        ttf_err_set(
            err, -EINVAL, "photograph",
            "its ground is too dark for a shadow to be seen: %.3f of full scale in a corner",
            (double)luminance);
        ttf_err_hint(err, "use a brighter ground, or expose longer");
        return -EINVAL;
    }
    return 0;
}

int ttf_ground_fit(const struct ttf_pixbuf *photo, struct ttf_ground *ret, struct ttf_err *err)
{
    struct ttf_ground ground = {.width = photo->width, .height = photo->height};
    struct border border = {0};
    int r = border_collect(photo, &ground, &border);

    if (r < 0) {
        ttf_err_set(err, r, "photograph", "no memory for its border");
        goto out;
    }
    for (int c = 0; c < 3; c++)
        ground.at[c] = median_of(&border, c, NULL);
    for (int round = 0; round < ROUNDS; round++) {
        weigh(&border, &ground);
        for (int c = 0; c < 3; c++)
            fit_channel(&border, c, &ground);
    }
    r = brightness_check(&ground, err);
    if (r == 0)
        *ret = ground;
out:
    free(border.samples);
    free(border.scratch);
    return r;
}

void ttf_ground_at(const struct ttf_ground *ground, uint32_t x, uint32_t y, float ret[3])
{
    double u, v;

    place(ground, x, y, &u, &v);
    for (int c = 0; c < 3; c++) {
        double value = plane_at(ground, c, u, v);

        ret[c] = value > 0.0 ? (float)value : 0.0f;
    }
}
