/* SPDX-License-Identifier: Apache-2.0 */
/* page.c: see page.h. The page's own sources are in page/, embedded when this is built. */
#include "page.h"

#include <stdio.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/dataset/json_writer.h"
#include "view_sources.h"

static void put_source(struct view_file *file, const char *name)
{
    const struct view_source *source = view_source_find(name);

    if (source)
        view_file_put(file, (const char *)source->data, source->bytes);
}

static void json_panel(struct ttf_json *json, const struct view_panel *panel)
{
    const struct ttf_view_texture *texture = panel->texture;
    const struct ttf_sequence *s = texture->sequence;

    ttf_json_object(json);
    ttf_json_kstring(json, "role", texture->role);
    ttf_json_kstring(json, "title", texture->title);
    ttf_json_kstring(json, "quantity", texture->quantity);
    ttf_json_kbool(json, "camera_colours", texture->camera_colours);
    ttf_json_kbool(json, "simulated", texture->simulated);
    ttf_json_kint(json, "width", panel->width);
    ttf_json_kint(json, "height", panel->height);
    ttf_json_kint(json, "of_width", s->width);
    ttf_json_kint(json, "of_height", s->height);
    ttf_json_kint(json, "of_frames", s->n);
    ttf_json_kstring(json, "kind", panel->exact ? "png" : "jpeg");
    ttf_json_kdouble(json, "black", panel->black);
    ttf_json_kdouble(json, "white", panel->white);
    ttf_json_key(json, "slots");
    ttf_json_array(json);
    for (uint32_t i = 0; i < panel->n; i++)
        ttf_json_int(json, s->index[panel->frame[i]]);
    ttf_json_array_end(json);
    ttf_json_key(json, "times_s");
    ttf_json_array(json);
    for (uint32_t i = 0; i < panel->n; i++)
        ttf_json_double(json, (double)s->time_ns[panel->frame[i]] / (double)TTF_NS_PER_S);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
}

static int put_json(struct view_file *file, const struct view_panel *panels, unsigned n,
                    struct ttf_err *err)
{
    struct ttf_json json;
    const char *text;
    size_t bytes;
    int code;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "software", "ttfbox " TTFBOX_VERSION);
    ttf_json_key(&json, "panels");
    ttf_json_array(&json);
    for (unsigned p = 0; p < n; p++)
        json_panel(&json, &panels[p]);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    code = ttf_json_finish(&json, &text, &bytes);
    if (code)
        ttf_err_set(err, code, NULL, "no memory to describe the view");
    else
        view_file_json(file, text);
    ttf_json_free(&json);
    return code;
}

int page_head(struct view_file *file, const struct view_panel *panels, unsigned n,
              struct ttf_err *err)
{
    const char *title = panels[0].texture->title;
    int code;

    view_file_text(file,
                   "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                   "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
                   "img-src data: blob:; style-src 'unsafe-inline'; "
                   "script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n"
                   "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                   "<meta name=\"color-scheme\" content=\"light dark\">\n<title>");
    view_file_escaped(file, title && *title ? title : "A time-varying texture");
    view_file_text(file, "</title>\n<style>\n");
    put_source(file, "view.css");
    put_source(file, "parts.css");
    view_file_text(file, "</style>\n</head>\n<body>\n");
    put_source(file, "body.html");
    view_file_text(file, "<script type=\"application/json\" id=\"about\">");
    code = put_json(file, panels, n, err);
    view_file_text(file, "</script>\n");
    return code;
}

void page_picture(struct view_file *file, unsigned panel, const uint8_t *data, size_t bytes)
{
    char open[64];

    (void)snprintf(open, sizeof open, "<script type=\"text/plain\" class=\"p%u\">", panel);
    view_file_text(file, open);
    view_file_base64(file, data, bytes);
    view_file_text(file, "</script>\n");
}

void page_tail(struct view_file *file)
{
    static const char *const scripts[] = {"surface.js", "flat.js", "plot.js", "panel.js",
                                          "main.js"};

    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++) {
        view_file_text(file, "<script>\n");
        put_source(file, scripts[i]);
        view_file_text(file, "</script>\n");
    }
    view_file_text(file, "</body>\n</html>\n");
}
