/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_info.c: `ttfbox info`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "elsewhere.h"
#include "info_people.h"
#include "ttf/config/units.h"
#include "ttf/dataset/reader.h"

/* What only a walk over all slots tells. */
struct walk {
    int64_t bytes, files, images;
    int64_t first_utc_ns, last_utc_ns;
};

/* The words by which images are marked, image by image. */
static void put_flags(struct ttf_json *j, const struct ttf_slot_record *record)
{
    ttf_json_key(j, "flags");
    ttf_json_array(j);
    for (unsigned k = 0; k < record->n_images; k++) {
        const char *at = record->images[k].flags;

        while (*at) {
            char word[sizeof record->images[k].flags];
            size_t n = strcspn(at, ",");

            (void)snprintf(word, sizeof word, "%.*s", (int)n, at);
            ttf_json_string(j, word);
            at += n + (at[n] == ',');
        }
    }
    ttf_json_array_end(j);
}

/* One slot for programs: what happened, when it was due, its images' files and flags. */
static void put_slot(struct cli *cli, const struct ttf_slot_record *record, int64_t due_utc_ns)
{
    struct ttf_json *j = &cli->out;

    ttf_json_object(j);
    ttf_json_kint(j, "index", record->index);
    ttf_json_kint(j, "segment", record->segment);
    ttf_json_kint(j, "due_ns", record->due_ns);
    if (due_utc_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(j, "due_utc_ns", due_utc_ns);
    ttf_json_kstring(j, "result", ttf_result_name(record->result));
    if (*record->reason)
        ttf_json_kstring(j, "reason", record->reason);
    ttf_json_key(j, "files");
    ttf_json_array(j);
    for (unsigned k = 0; k < record->n_images; k++)
        for (unsigned f = 0; f < record->images[k].n_files; f++)
            ttf_json_string(j, record->images[k].files[f].path);
    ttf_json_array_end(j);
    put_flags(j, record);
    ttf_json_object_end(j);
}

static int walk_slots(struct cli *cli, struct ttf_reader *reader, struct walk *w)
{
    const struct ttf_reader_summary *s = ttf_reader_summary(reader);

    *w = (struct walk){.first_utc_ns = TTF_NS_UNKNOWN, .last_utc_ns = TTF_NS_UNKNOWN};
    ttf_json_key(&cli->out, "slot_list");
    ttf_json_array(&cli->out);
    for (int64_t i = 0; i < s->slots; i++) {
        struct ttf_slot_record record;
        int r = ttf_reader_slot(reader, i, &record, &cli->err);
        int64_t due;

        if (r < 0)
            return r;
        due = ttf_reader_due_utc_ns(reader, &record);
        put_slot(cli, &record, due);
        if (due != TTF_NS_UNKNOWN) {
            w->last_utc_ns = due;
            if (w->first_utc_ns == TTF_NS_UNKNOWN)
                w->first_utc_ns = due;
        }
        for (unsigned k = 0; k < record.n_images; k++) {
            w->images += record.images[k].n_files > 0;
            for (unsigned f = 0; f < record.images[k].n_files; f++, w->files++)
                w->bytes += record.images[k].files[f].bytes;
        }
        ttf_slot_record_free(&record);
    }
    ttf_json_array_end(&cli->out);
    return 0;
}

static void put_streams(struct cli *cli, const struct ttf_manifest *m)
{
    struct ttf_json *j = &cli->out;

    ttf_json_key(j, "streams");
    ttf_json_array(j);
    for (unsigned i = 0; i < m->n_streams; i++) {
        const struct ttf_stream *s = &m->streams[i];

        cli_say(cli, "stream %-10s %u x %u, %u x %s, %s in %s%s%s%s", s->id, s->width, s->height,
                s->samples, ttf_sample_name(s->format), s->quantity, s->colour_space,
                *s->channel ? ", light " : "", s->channel,
                s == ttf_manifest_primary(m) ? ", primary" : "");
        ttf_json_object(j);
        ttf_json_kstring(j, "id", s->id);
        ttf_json_kstring(j, "camera", s->camera);
        ttf_json_kstring(j, "channel", s->channel);
        ttf_json_kstring(j, "quantity", s->quantity);
        ttf_json_kstring(j, "colour_space", s->colour_space);
        ttf_json_kint(j, "width", s->width);
        ttf_json_kint(j, "height", s->height);
        ttf_json_kint(j, "samples", s->samples);
        ttf_json_kstring(j, "format", ttf_sample_name(s->format));
        ttf_json_kdouble(j, "pedestal", s->encoding.pedestal);
        ttf_json_kdouble(j, "scale", s->encoding.scale);
        ttf_json_kbool(j, "primary", s == ttf_manifest_primary(m));
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
}

static void put_origin(struct cli *cli, const struct ttf_manifest *m)
{
    struct ttf_json *j = &cli->out;

    if (*m->group_uuid) {
        cli_say(cli, "group             %s, member %s", m->group_uuid, m->group_member);
        ttf_json_kstring(j, "group_uuid", m->group_uuid);
        ttf_json_kstring(j, "group_member", m->group_member);
    }
    if (*m->source) {
        cli_say(cli, "imported from     %s", m->source);
        ttf_json_kstring(j, "source", m->source);
    }
    if (*m->derived_uuid) {
        cli_say(cli, "derived from      %s by %s", m->derived_uuid, m->derived_command);
        ttf_json_kstring(j, "derived_uuid", m->derived_uuid);
        ttf_json_kstring(j, "derived_digest", m->derived_digest);
        ttf_json_kstring(j, "derived_command", m->derived_command);
    }
}

/* One line, and one more for each change of the interval. */
static void put_intervals(struct cli *cli, struct ttf_reader *reader)
{
    int n = ttf_reader_summary(reader)->n_segments;
    struct ttf_segment segment;
    int64_t before_ns = 0;
    char text[64], from[48];

    for (int i = 0; i < n && ttf_reader_segment(reader, i, &segment) == 0; i++) {
        if (segment.interval_ns == before_ns)
            continue;
        before_ns = segment.interval_ns;
        if (i == 0)
            ttf_json_kint(&cli->out, "interval_ns", segment.interval_ns);
        (void)snprintf(from, sizeof from, " from slot %" PRId64 " on", segment.first_index);
        cli_say(cli, "interval          %s%s",
                ttf_unit_format(TTF_UNIT_TIME, segment.interval_ns, text, sizeof text),
                i ? from : "");
    }
    if (n > 1)
        cli_say(cli, "segments          %d: boots, and changes of the plan or the clock", n);
    if (ttf_reader_summary(reader)->n_calibrations > 1)
        cli_say(cli, "calibrations      %d: each picture names its own",
                (int)ttf_reader_summary(reader)->n_calibrations);
}

static void put_slots(struct cli *cli, struct ttf_reader *reader)
{
    const struct ttf_reader_summary *s = ttf_reader_summary(reader);
    struct ttf_json *j = &cli->out;
    char text[256];
    int n = snprintf(text, sizeof text, "%" PRId64, s->slots);

    ttf_json_kint(j, "slots", s->slots);
    for (int i = 0; i < TTF_RESULT_COUNT; i++) {
        const char *name = ttf_result_name((enum ttf_result)i);

        ttf_json_kint(j, name, s->counts[i]);
        if (s->counts[i])
            n +=
                snprintf(text + n, sizeof text - (size_t)n, ", %" PRId64 " %s", s->counts[i], name);
    }
    cli_say(cli, "slots             %s", text);
    ttf_json_kint(j, "segments", s->n_segments);
    ttf_json_kint(j, "calibrations", s->n_calibrations);
    put_intervals(cli, reader);
}

static void put_walk(struct cli *cli, const struct walk *w)
{
    struct ttf_json *j = &cli->out;
    char a[40], b[40];

    if (w->first_utc_ns != TTF_NS_UNKNOWN) {
        ttf_utc_format(w->first_utc_ns, a, sizeof a);
        ttf_utc_format(w->last_utc_ns, b, sizeof b);
        cli_say(cli, "time              %s to %s", a, b);
        ttf_json_kstring(j, "first_utc", a);
        ttf_json_kstring(j, "last_utc", b);
    }
    cli_say(cli, "files             %" PRId64 " of %" PRId64 " images, %.1f MB", w->files,
            w->images, (double)w->bytes / 1e6);
    ttf_json_kint(j, "files", w->files);
    ttf_json_kint(j, "images", w->images);
    ttf_json_kint(j, "bytes", w->bytes);
}

int cmd_info(struct cli *cli)
{
    struct ttf_reader *reader = NULL;
    const struct ttf_reader_summary *s;
    const struct ttf_manifest *m;
    char digest[65] = "";
    struct walk w;
    int r = ttf_reader_open(cli->io, cli->opt.args[0], &reader, &cli->err);

    if (r < 0)
        return r;
    m = ttf_reader_manifest(reader);
    s = ttf_reader_summary(reader);
    r = walk_slots(cli, reader, &w);
    if (r < 0)
        goto out;
    cli_say(cli, "%sdataset           %s", m->simulated ? "SIMULATED\n" : "", cli->opt.args[0]);
    if (*m->title)
        cli_say(cli, "title             %s", m->title);
    cli_say(cli, "uuid              %s", m->uuid);
    ttf_json_kstring(&cli->out, "dataset", cli->opt.args[0]);
    ttf_json_kstring(&cli->out, "title", m->title);
    ttf_json_kstring(&cli->out, "uuid", m->uuid);
    ttf_json_kstring(&cli->out, "box_serial", m->box_serial);
    ttf_json_kstring(&cli->out, "software", m->software);
    ttf_json_kbool(&cli->out, "simulated", m->simulated);
    put_streams(cli, m);
    put_slots(cli, reader);
    put_walk(cli, &w);
    put_origin(cli, m);
    if (s->sealed && ttf_reader_digest(reader, digest, NULL) == 0)
        cli_say(cli, "sealed            digest %s", digest);
    else
        cli_say(cli, "sealed            no: unfinished%s",
                s->unterminated ? ", its last line is not whole (a crash)" : "");
    ttf_json_kbool(&cli->out, "sealed", s->sealed);
    ttf_json_kbool(&cli->out, "unterminated", s->unterminated);
    if (*digest)
        ttf_json_kstring(&cli->out, "digest", digest);
    cli_say_elsewhere(cli, reader);
    r = cli_say_people(cli, cli->opt.args[0]);
out:
    ttf_reader_close(reader);
    return r;
}
