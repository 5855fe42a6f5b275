/* SPDX-License-Identifier: Apache-2.0 */
#include "image_model.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "optics.h"
#include "sensor_model.h"

struct sim_image_model {
    struct ttf_scene *scene; /* borrowed */
    struct optics optics;
    struct sensor sensor;
    unsigned n_lamps;
    float colour[TTF_LAMPS_MAX][3]; /* strength included */
    /*
     * What each lamp gives in the frame, and even light; vignetting in both. Of each row every light_step-th pixel, and
     * the one behind the last: between them a straight line is as good, for these are smooth and change over the whole frame.
     */
    float *lamp_map[TTF_LAMPS_MAX];
    float *even_map;
    uint32_t light_step, light_columns;
    /* Work space of one exposure. */
    float *rgb; /* the rendered sample */
    /* The frame's reflectance before blur, the rows that one row's blur sees: row y at y % rows, 3 x rows x width. */
    float *planes;
    uint32_t rows, filled; /* of the frame, rows before this one have been there */
    float mix;             /* of each other colour, in what a filter lets through */
    float *line;           /* a few rows */
    size_t line_stride;
};

#define LINES 5

/* So many steps across a frame keep a light map within 10^-5 of itself: it is a few parabolas. */
#define LIGHT_STEPS 256u

static float *floats(size_t n)
{
    /* Zeroed: the padding of rows is read by the blur. */
    return calloc(n, sizeof(float));
}

static int allocate(struct sim_image_model *m)
{
    const size_t lights = (size_t)m->light_columns * m->optics.height;
    const size_t src = (size_t)m->optics.src_width * m->optics.src_height;

    /* One line must hold a frame's row with the blur's border, or three rows' worth of the source. */
    m->line_stride = 3 * (size_t)m->optics.width + 2 * OPTICS_BLUR_RADIUS_MAX;
    m->even_map = floats(lights);
    m->rgb = floats(src * 3);
    m->planes = floats((size_t)m->rows * m->optics.width * 3);
    m->line = floats(m->line_stride * LINES);
    if (!m->even_map || !m->rgb || !m->planes || !m->line)
        return -ENOMEM;
    for (unsigned l = 0; l < m->n_lamps; l++) {
        m->lamp_map[l] = floats(lights);
        if (!m->lamp_map[l])
            return -ENOMEM;
    }
    return 0;
}

static void fill_light_maps(struct sim_image_model *m, const struct ttf_sim_config *config)
{
    const struct optics *o = &m->optics;

    for (uint32_t y = 0; y < o->height; y++) {
        const size_t at = (size_t)y * m->light_columns;
        struct optics_row row;

        optics_row(o, y + 0.5, &row);
        for (uint32_t i = 0; i < m->light_columns; i++) {
            const double x = (double)i * m->light_step + 0.5;
            const double u = row.u0 + x * row.du;
            const float vignette = optics_vignette(o, x, y + 0.5);

            m->even_map[at + i] = vignette;
            for (unsigned l = 0; l < m->n_lamps; l++)
                m->lamp_map[l][at + i] =
                    vignette * optics_lamp_fall_off(o, &config->lamps[l], u, row.v);
        }
    }
}

int sim_image_model_create(const struct ttf_sim_config *config, struct ttf_scene *scene,
                           struct sim_image_model **ret, struct ttf_err *err)
{
    struct sim_image_model *m;
    int r;

    if (!scene || !scene->ops || config->n_lamps > TTF_LAMPS_MAX || config->width == 0 ||
        config->height == 0 || config->bits < 1 || config->bits > 16)
        return ttf_err_set(err, -EINVAL, NULL, "a simulated camera needs a scene and a frame");
    m = calloc(1, sizeof(*m));
    if (!m)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the simulated camera");
    m->scene = scene;
    optics_init(&m->optics, config);
    m->n_lamps = config->n_lamps;
    m->mix = (float)config->colour_mix;
    m->rows = 2 * (uint32_t)m->optics.blur_radius + 1;
    m->light_step = config->width > LIGHT_STEPS ? config->width / LIGHT_STEPS : 1;
    m->light_columns = (config->width + m->light_step - 1) / m->light_step + 1;
    for (unsigned l = 0; l < m->n_lamps; l++) {
        for (int c = 0; c < 3; c++)
            m->colour[l][c] = (float)(config->lamps[l].strength * config->lamps[l].colour[c]);
    }
    r = sensor_init(&m->sensor, config);
    if (r == 0)
        r = allocate(m);
    if (r < 0)
        ttf_err_set(err, r, NULL, "no memory for the simulated camera");
    else if (scene->ops->prepare)
        r = scene->ops->prepare(scene->priv, m->optics.src_width, m->optics.src_height, err);
    if (r < 0) {
        sim_image_model_destroy(m);
        return r;
    }
    fill_light_maps(m, config);
    *ret = m;
    return 0;
}

void sim_image_model_destroy(struct sim_image_model *m)
{
    if (!m)
        return;
    sensor_finish(&m->sensor);
    for (unsigned l = 0; l < TTF_LAMPS_MAX; l++)
        free(m->lamp_map[l]);
    free(m->even_map);
    free(m->rgb);
    free(m->planes);
    free(m->line);
    free(m);
}

static float *plane_row(struct sim_image_model *m, unsigned channel, int64_t y)
{
    const int64_t h = m->optics.height;

    y = y < 0 ? 0 : y >= h ? h - 1 : y;
    return m->planes + ((size_t)channel * m->rows + (size_t)y % m->rows) * m->optics.width;
}

/* Row y of one channel behind the lens's blur, into line[k]; returns where it begins. */
static const float *blurred(struct sim_image_model *m, unsigned channel, uint32_t y, float *wide,
                            float *dst)
{
    const float *taps[2 * OPTICS_BLUR_RADIUS_MAX + 1];
    const int r = m->optics.blur_radius;
    const uint32_t w = m->optics.width;

    if (r == 0)
        return plane_row(m, channel, y);
    for (int k = -r; k <= r; k++)
        taps[k + r] = plane_row(m, channel, (int64_t)y + k);
    wide += OPTICS_BLUR_RADIUS_MAX;
    optics_blur_rows(&m->optics, taps, w, wide);
    for (int k = 1; k <= r; k++) {
        wide[-k] = wide[0];
        wide[w - 1 + (uint32_t)k] = wide[w - 1];
    }
    optics_blur_along(&m->optics, wide, w, dst);
    return dst;
}

/* Row y of a light map, pixel by pixel: in dst, or where it is if the map has every pixel. */
static const float *map_row(const struct sim_image_model *m, const float *map, uint32_t y,
                            float *dst)
{
    const float *at = map + (size_t)y * m->light_columns;
    const uint32_t step = m->light_step, w = m->optics.width;

    if (step == 1)
        return at;
    for (uint32_t x = 0; x < w; x += step, at++) {
        const float slope = (at[1] - at[0]) / (float)step;

        for (uint32_t k = 0; k < step && x + k < w; k++)
            dst[x + k] = at[0] + slope * (float)k;
    }
    return dst;
}

/* The light of row y on pixels of channels c_even and c_odd. scratch: a row. */
static void light_row(const struct sim_image_model *m, const struct sim_exposure_light *light,
                      uint32_t y, unsigned c_even, unsigned c_odd, float *scratch, float *dst)
{
    const uint32_t w = m->optics.width;
    const float ambient = light->ambient_rows ? light->ambient_rows[y] : 0.0f;
    const float *vignette = map_row(m, m->even_map, y, scratch);

    for (uint32_t x = 0; x < w; x++)
        dst[x] = vignette[x] * ambient;
    for (unsigned l = 0; l < m->n_lamps && l < light->n_lamps; l++) {
        const float now = light->lamp_rows[l][y];
        const float even = now * m->colour[l][c_even], odd = now * m->colour[l][c_odd];
        const float *map;

        if (now == 0.0f)
            continue;
        map = map_row(m, m->lamp_map[l], y, scratch);
        for (uint32_t x = 0; x + 1 < w; x += 2) {
            dst[x] += map[x] * even;
            dst[x + 1] += map[x + 1] * odd;
        }
        if (w & 1u)
            dst[w - 1] += map[w - 1] * even;
    }
}

static void expose_row(struct sim_image_model *m, const struct sim_exposure_light *light,
                       const struct sensor_exposure *e, uint32_t y, uint16_t *dst)
{
    const uint32_t w = m->optics.width;
    const unsigned c_even = sensor_channel(0, y), c_odd = sensor_channel(1, y);
    float *wide = m->line, *electrons = m->line + m->line_stride;
    const float *even = blurred(m, c_even, y, wide, m->line + 2 * m->line_stride);
    const float *odd = blurred(m, c_odd, y, wide, m->line + 3 * m->line_stride);

    light_row(m, light, y, c_even, c_odd, m->line + 4 * m->line_stride, electrons);
    for (uint32_t x = 0; x < w; x++) {
        const bool is_odd = x & 1u;

        electrons[x] *= (is_odd ? odd[x] : even[x]) * e->e_per_light[is_odd ? c_odd : c_even];
    }
    sensor_read_row(&m->sensor, e, y, electrons, dst);
}

static bool is_dark(const struct sim_image_model *m, const struct sim_exposure_light *light)
{
    for (uint32_t y = 0; y < m->optics.height; y++) {
        if (light->ambient_rows && light->ambient_rows[y] != 0.0f)
            return false;
        for (unsigned l = 0; l < m->n_lamps && l < light->n_lamps; l++) {
            if (light->lamp_rows[l][y] != 0.0f)
                return false;
        }
    }
    return true;
}

/* What filters that are not sharp make of a row; white stays white. */
static void mix_colours(float mix, uint32_t w, float *red, float *green, float *blue)
{
    for (uint32_t x = 0; x < w; x++) {
        const float others = mix * (red[x] + green[x] + blue[x]), own = 1.0f - 3.0f * mix;

        red[x] = own * red[x] + others;
        green[x] = own * green[x] + others;
        blue[x] = own * blue[x] + others;
    }
}

/* Brings the rows of the sample that row y's blur sees. */
static void draw_rows(struct sim_image_model *m, uint32_t y)
{
    const struct optics *o = &m->optics;
    const uint32_t last = y + (uint32_t)o->blur_radius;

    for (; m->filled <= last && m->filled < o->height; m->filled++) {
        float *red = plane_row(m, 0, m->filled), *green = plane_row(m, 1, m->filled);
        float *blue = plane_row(m, 2, m->filled);

        optics_resample_row(o, m->rgb, m->filled, m->line, red, green, blue);
        if (m->mix > 0.0f)
            mix_colours(m->mix, o->width, red, green, blue);
    }
}

int sim_image_expose(struct sim_image_model *m, int64_t elapsed_ns,
                     const struct sim_exposure_light *light, const struct ttf_exposure *granted,
                     double temp_degc, uint64_t noise_key, uint16_t *dst, struct ttf_err *err)
{
    const struct optics *o = &m->optics;
    const bool dark = is_dark(m, light);
    struct sensor_exposure e;
    int r;

    /* In the dark nothing is to be seen of the sample, so it need not be drawn. */
    if (!dark) {
        r = m->scene->ops->render(m->scene->priv, elapsed_ns, o->src_width, o->src_height, m->rgb,
                                  err);
        if (r < 0)
            return r;
    }
    m->filled = 0;
    sensor_expose(&m->sensor, granted, temp_degc, noise_key, &e);
    for (uint32_t y = 0; y < o->height; y++) {
        if (!dark)
            draw_rows(m, y);
        expose_row(m, light, &e, y, dst + (size_t)y * o->width);
    }
    return 0;
}

int sim_image_truth(struct sim_image_model *m, int64_t elapsed_ns, uint32_t w, uint32_t h,
                    float *rgb, struct ttf_err *err)
{
    return m->scene->ops->render(m->scene->priv, elapsed_ns, w, h, rgb, err);
}

void sim_image_corners(const struct sim_image_model *m, double ret_xy[4][2])
{
    optics_corners(&m->optics, ret_xy);
}
