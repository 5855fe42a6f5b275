/* SPDX-License-Identifier: Apache-2.0 */
/* options.c: one line per option; see options.h. */
#include "options.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/config/units.h"

#define O(member) offsetof(struct cli_options, member)

static const struct cli_option_def OPTIONS[OPT_COUNT] = {
    [OPT_BOARD] = {"board", 'b', "NAME", CLI_TEXT, O(board), 0, 0,
                   "the box: a name or a board.yaml (default: sim, the simulated box)"},
    [OPT_SET] = {"set", 0, "KEY=VALUE", CLI_SET, 0, 0, 0,
                 "change a key of the board for this run, as sim.optics.blur=0px; may be repeated"},
    [OPT_SCENE] = {"scene", 0, "NAME", CLI_TEXT, O(scene), 0, 0,
                   "what a simulated camera looks at: a procedural sample, 'white' (an even "
                   "target), a folder of pictures or a dataset"},
    [OPT_OUTPUT] = {"output", 'o', "PATH", CLI_TEXT, O(output), 0, 0, "where the result goes"},
    [OPT_CALIBRATION] = {"calibration", 'c', "CAL", CLI_TEXT, O(calibration), 0, 0,
                         "a calibration folder, made by 'ttfbox calibrate'"},
    [OPT_PLAN] = {"plan", 'p', "PLAN", CLI_TEXT, O(plan), 0, 0,
                  "take exposure and lamps from this plan's first shot"},
    [OPT_SHOT] = {"shot", 0, "STREAM", CLI_TEXT, O(shot), 0, 0,
                  "with --plan: take this stream's shot instead of the first"},
    [OPT_EXPOSURE] = {"exposure", 0, "TIME", CLI_TIME, O(exposure_ns), 1000, 1e12,
                      "the exposure time, as 20ms (default: the plan's, else 20ms)"},
    [OPT_REFLECTANCE] = {"reflectance", 0, "SHARE", CLI_DECIMAL, O(reflectance), 0.01, 1,
                         "the even target's reflectance, 0..1 (default: 0.9; the simulated "
                         "'white' is known and needs none)"},
    [OPT_CORNERS] =
        {"corners", 0, "X,Y,...", CLI_TEXT, O(corners), 0, 0,
         "eight numbers: x and y in the frame's pixels of the corners of the chart's "
         "field of patches, from 'dark skin' along the first row, clockwise (the page's "
         "live view picks them; of the simulated 'chart' they are known)"},
    [OPT_PITCH] = {"pitch", 0, "MM", CLI_DECIMAL, O(pitch_mm), 1e-3, 1e4,
                   "millimetres from the middle of a dot to that of the next one in its row"},
    [OPT_VALUES] = {"values", 0, "FILE", CLI_TEXT, O(values), 0, 0,
                    "L*, a* and b* (D50) of the chart's 24 patches, a line each, or a CGATS file "
                    "(default: the ColorChecker Classic since November 2014; the simulated 'chart' "
                    "is known)"},
    [OPT_REHEARSE] = {"rehearse", 0, "N", CLI_WHOLE, O(rehearse), 1, 1000,
                      "try N slots at once and report; the dataset stays unsealed"},
    [OPT_NO_SPEED_CHECK] = {"no-speed-check", 0, NULL, CLI_FLAG, O(no_speed_check), 0, 0,
                            "do not measure how fast the disk writes"},
    [OPT_SCRIPT] =
        {"script", 0, "FILE", CLI_TEXT, O(script), 0, 0,
         "what is asked of the run meanwhile: lines of SLOT and pause [REASON], "
         "continue, stop, count N, until INSTANT, interval TIME, plan FILE or note TEXT"},
    [OPT_AS_GIVEN] = {"plan-as-given", 0, NULL, CLI_FLAG, O(as_given), 0, 0,
                      "go back to this plan although the dataset has moved on from it"},
    [OPT_SLOTS] = {"slots", 0, "RANGE", CLI_TEXT, O(slots), 0, 0,
                   "the slots it is about, as 12-20; several with commas"},
    [OPT_TAG] = {"tag", 0, "TAG", CLI_TEXT, O(tag), 0, 0,
                 "exclude, reference or your own; several with commas"},
    [OPT_AUTHOR] = {"author", 0, "NAME", CLI_TEXT, O(author), 0, 0, "who says so"},
    [OPT_REGION] = {"region", 0, "X,Y,WxH", CLI_TEXT, O(region), 0, 0,
                    "its part of the primary stream's picture: pixels from the top left corner, as "
                    "120,80,400x300"},
    [OPT_TREATMENT] = {"treatment", 0, "TEXT", CLI_WORDS, O(treatment), 0, 0,
                       "what is done to it; an empty text takes it back"},
    [OPT_TABLE] = {"table", 0, "FILE", CLI_TEXT, O(table), 0, 0,
                   "many at once, as a spreadsheet saves them (CSV): the first line names the "
                   "columns id, x, y, width, height, title (or species, material), treatment"},
    [OPT_REMOVE] = {"remove", 0, NULL, CLI_FLAG, O(remove), 0, 0, "take this sample out again"},
    [OPT_THREADS] = {"threads", 't', "N", CLI_WHOLE, O(threads), 0, 256,
                     "computing threads (default: one per processor); never changes a result"},
    [OPT_SEED] = {"seed", 0, "N", CLI_SEED, O(seed), 0, 9.2e18,
                  "the seed of all chance; the same seed gives the same bits"},
    [OPT_INTERVAL] = {"interval", 'i', "TIME", CLI_TIME, O(interval_ns), 1e6, 366e9 * 86400,
                      "the time from frame to frame, as 10min"},
    [OPT_ORDER] = {"order", 0, "HOW", CLI_TEXT, O(order), 0, 0,
                   "natural (by name, default), given, exif-time or name-time"},
    [OPT_TRANSFER] = {"transfer", 0, "CURVE", CLI_TEXT, O(transfer), 0, 0,
                      "auto (as the files say, default), srgb or linear"},
    [OPT_TITLE] = {"title", 0, "TEXT", CLI_WORDS, O(title), 0, 0, "a line for people"},
    [OPT_BUNDLE] = {"bundle", 0, "FILE", CLI_TEXT, O(bundle), 0, 0,
                    "put what was seen into an archive (tar.gz) to attach to a report; it holds no "
                    "secrets"},
    [OPT_ROOT] = {"root", 0, "DIR", CLI_TEXT, O(root), 0, 0,
                  "look at the files below DIR (sys, dev, proc) instead of this machine's, and ask "
                  "no device"},
    [OPT_MM_PER_PX] = {"mm-per-px", 0, "MM", CLI_DECIMAL, O(mm_per_px), 1e-6, 1e3,
                       "millimetres per pixel"},
    [OPT_TO] = {"to", 0, "KIND", CLI_TEXT, O(to), 0, 0,
                "mp4, gif, y4m, png, tiff, npy or sheet (default: by the output's ending)"},
    [OPT_GAPS] = {"gaps", 0, "HOW", CLI_TEXT, O(gaps), 0, 0,
                  "what stands for slots without an image: hold (default), fail or interpolate"},
    [OPT_START] = {"start", 0, "N", CLI_WHOLE, O(start), 0, 1e9,
                   "number of the first file (default: 1001)"},
    [OPT_EVERY] = {"every", 0, "N", CLI_WHOLE, O(every), 1, 1e6, "take each N-th slot only"},
    [OPT_FRAMES] = {"frames", 0, "N", CLI_WHOLE, O(frames), 1, 1e9, "at most N frames"},
    [OPT_FPS] = {"fps", 0, "N", CLI_WHOLE, O(fps), 1, 240,
                 "frames per second of a video (default: 24, gif: 12)"},
    [OPT_WIDTH_MAX] = {"width", 0, "PX", CLI_WHOLE, O(width_max), 16, 65535,
                       "shrink to at most this width, in linear light"},
    [OPT_COLUMNS] = {"columns", 0, "N", CLI_WHOLE, O(columns), 1, 100,
                     "columns of a contact sheet"},
    [OPT_BESIDE] = {"beside", 0, "DATASET", CLI_TEXT, O(beside), 0, 0,
                    "a second dataset shown beside it: what was synthesized from it"},
    [OPT_WHITE] = {"white", 0, "VALUE", CLI_DECIMAL, O(white), 1e-6, 1e6,
                   "value shown as full white (default: 1, a perfect diffuser)"},
    [OPT_NAME] = {"name", 0, "NAME", CLI_TEXT, O(name), 0, 0,
                  "name of numbered files (default: frame)"},
    [OPT_STREAM] = {"stream", 0, "ID", CLI_TEXT, O(stream), 0, 0,
                    "the stream to read (default: the primary one)"},
    [OPT_ROLE] = {"role", 0, "ROLE", CLI_TEXT, O(role), 0, 0,
                  "of each image the file of this role: developed (default), uncertainty or mask"},
    [OPT_BRACKET] = {"bracket", 0, "N", CLI_WHOLE, O(bracket), 0, 99,
                     "of each bracket the image of this number, from 0 (default: the reference)"},
    [OPT_WITH_EXCLUDED] = {"with-excluded", 0, NULL, CLI_FLAG, O(with_excluded), 0, 0,
                           "also slots that a note tags 'exclude'; they are left out otherwise"},
    [OPT_SIZE] = {"size", 's', "WxH", CLI_SIZE, O(size), 0, 0,
                  "the output's size in pixels (default: twice the input's)"},
    [OPT_BLOCK] = {"block", 0, "WxH", CLI_BLOCK, O(block), 0, 0,
                   "a block's size in pixels (default: 64x64), elongated for grass; or auto: from "
                   "the size of what is seen at late times"},
    [OPT_OVERLAP] = {"overlap", 0, "WxH", CLI_SIZE, O(overlap), 0, 0,
                     "overlap of blocks per axis (default: a sixth of the block)"},
    [OPT_TOLERANCE] = {"tolerance", 0, "SHARE", CLI_DECIMAL, O(tolerance), 0, 10,
                       "choose among blocks within this share of the best (default: 0.1)"},
    [OPT_METRIC] = {"metric", 0, "SPACE", CLI_TEXT, O(metric), 0, 0,
                    "compare in display (default, as the paper) or linear values"},
    [OPT_COMPRESS] = {"compress", 0, "HOW", CLI_TEXT, O(compress), 0, 0,
                      "none (default) or deflate: the output's TIFF frames"},
    [OPT_SINK] = {"sink", 0, "KIND", CLI_TEXT, O(sink), 0, 0,
                  "dataset (default), raw (one file of 8-bit RGB frames) or null (nothing: for "
                  "timing)"},
    [OPT_PER_FRAME] = {"per-frame", 0, NULL, CLI_FLAG, O(per_frame), 0, 0,
                       "quilt each frame alone: the baseline that flickers"},
    [OPT_FEATHER] = {"feather", 0, "PX", CLI_WHOLE, O(feather), 0, 64,
                     "blend across the seam over so many pixels, in linear light (default: 0)"},
    [OPT_CHECK] = {"check", 0, NULL, CLI_FLAG, O(check), 0, 0,
                   "read the result back and compare every trajectory with its source's, bit for "
                   "bit"},
    [OPT_RANK] = {"rank", 0, "K", CLI_RANK, O(rank), 1, 64,
                  "numbers that a pixel's life is compressed to for matching (default: 15), or "
                  "full: match all frames"},
    [OPT_RANK_ERROR] =
        {"rank-error", 0, "PERCENT", CLI_DECIMAL, O(rank_error), 1e-6, 100,
         "the smallest rank up to 64 that misses at most so much, instead of --rank"},
    [OPT_SVD] = {"svd", 0, "HOW", CLI_TEXT, O(svd), 0, 0,
                 "compress all channels at once (joint, default) or each alone (channels)"},
    [OPT_FACTORS] = {"factors", 0, "FILE", CLI_TEXT, O(factors), 0, 0,
                     "keep the compression here, and go on from there when the dataset has grown"},
    [OPT_SOURCE] = {"source", 0, "DATASET", CLI_SOURCE, O(sources), 0, 0,
                    "a further input of the same material, as many frames; may be repeated"},
    [OPT_MIRROR] = {"mirror", 0, NULL, CLI_FLAG, O(mirror), 0, 0,
                    "blocks may be mirrored left to right too: grass still grows upwards"},
    [OPT_FLIPS] = {"flips", 0, NULL, CLI_FLAG, O(flips), 0, 0,
                   "blocks may be mirrored either way, left to right and top to bottom"},
    [OPT_ROTATIONS] = {"rotations", 0, NULL, CLI_FLAG, O(rotations), 0, 0,
                       "blocks may be turned by 90, 180 and 270 degrees too"},
    [OPT_TILEABLE] = {"tileable", 0, NULL, CLI_FLAG, O(tileable), 0, 0,
                      "the output's edges fit each other"},
    [OPT_AVOID] = {"avoid", 0, "PX", CLI_WHOLE, O(avoid), 0, 32768,
                   "take no block from within so many pixels of where one nearby was taken"},
    [OPT_JITTER] = {"jitter", 0, "FRAMES", CLI_WHOLE, O(jitter), 0, 1048576,
                    "each block its own time, at most so many frames off (default: 0)"},
    [OPT_JITTER_ROUNDED] = {"jitter-rounded", 0, NULL, CLI_FLAG, O(jitter_rounded), 0, 0,
                            "whole frames only, where times fall between two (default: "
                            "interpolated)"},
    [OPT_JITTER_EVERY] = {"jitter-every", 0, "FRAMES", CLI_WHOLE, O(jitter_every), 1, 1048576,
                          "frames from one step of a block's time to the next (default: 16; 1: at "
                          "every frame, as the paper, which blurs noise over time)"},
    [OPT_RATE_MAP] = {"rate-map", 0, "PICTURE", CLI_TEXT, O(rate_map), 0, 0,
                      "how fast each place ages: white at full pace, black not at all"},
    [OPT_LIGHT] = {"light", 0, "X,Y,Z", CLI_POINT, O(light), -1000, 1000,
                   "ageing by light from here, in widths of the output from its top left corner, "
                   "as 0.5,0.3,0.4"},
    [OPT_NORMALS] = {"normals", 0, "PICTURE", CLI_TEXT, O(normals), 0, 0,
                     "with --light: the surface's normals (tangent space, y up)"},
    [OPT_HEIGHTS] = {"heights", 0, "PICTURE", CLI_TEXT, O(heights), 0, 0,
                     "with --light: the surface's heights (grey)"},
    [OPT_HEIGHT_SCALE] = {"height-scale", 0, "S", CLI_DECIMAL, O(height_scale), -1000, 1000,
                          "the height that white stands for, in widths of the output (default: "
                          "0.1)"},
    [OPT_CURVATURE] = {"curvature", 0, "WHAT", CLI_TEXT, O(curvature), 0, 0,
                       "ageing by curvature: of 'sigmoid', of a curve (FILE.csv, lines x,y), or of "
                       "a picture of heights"},
    [OPT_RATE_OFFSET] = {"rate-offset", 0, "N", CLI_DECIMAL, O(rate_offset), -1000000, 1000000,
                         "added to every rate (default: 0)"},
    [OPT_RATE_GAIN] = {"rate-gain", 0, "N", CLI_DECIMAL, O(rate_gain), -1000000, 1000000,
                       "what every rate is multiplied by before (default: 1)"},
    [OPT_STABILISE] = {"stabilise", 0, NULL, CLI_FLAG, O(stabilise), 0, 0,
                       "first take out the camera's nudges; crops the input a little"},
    [OPT_DEFLICKER] = {"deflicker", 0, NULL, CLI_FLAG, O(deflicker), 0, 0,
                       "then even out the light from frame to frame"},
    [OPT_DEFLICKER_WINDOW] = {"deflicker-window", 0, "N", CLI_WHOLE, O(deflicker_window), 3, 9999,
                              "with --deflicker: over so many frames, odd (default: 9)"},
    [OPT_FLATTEN] = {"flatten", 0, NULL, CLI_FLAG, O(flatten), 0, 0,
                     "then take the slow gradient of light out of the picture"},
    [OPT_FLATTEN_SIGMA] =
        {"flatten-sigma", 0, "PX", CLI_DECIMAL, O(flatten_sigma), 0.5, 32768,
         "with --flatten: what is slow (default: half the larger side of a block)"},
    [OPT_KEEP_GRADIENT] =
        {"keep-gradient", 0, NULL, CLI_FLAG, O(keep_gradient), 0, 0,
         "with --flatten: lay the gradient over the output again (the report's figures are of "
         "the output before)"},
    [OPT_SAVE_MAP] = {"save-map", 0, "FILE", CLI_TEXT, O(save_map), 0, 0,
                      "write where every block came from, and the pace, as JSON"},
    [OPT_MAP] = {"map", 0, "FILE", CLI_TEXT, O(map), 0, 0,
                 "lay blocks as such a file says, searching for none; inputs must be of its sizes. "
                 "Another control of the pace takes the place of its own"},
    [OPT_AGREEMENT] = {"agreement", 0, "N", CLI_WHOLE, O(agreement), 1, 1000000,
                       "compare about N of the matches with those over all frames, for the report"},
    [OPT_FIGURES] = {"figures", 0, NULL, CLI_FLAG, O(figures), 0, 0,
                     "measure the result for the report (default of --sink dataset)"},
    [OPT_NO_FIGURES] = {"no-figures", 0, NULL, CLI_FLAG, O(no_figures), 0, 0,
                        "do not (default of --sink raw and null): faster"},
    [OPT_PREVIEW] = {"preview", 0, NULL, CLI_FLAG, O(preview), 0, 0,
                     "smaller and of fewer frames, within --memory and --time"},
    [OPT_MEMORY] = {"memory", 0, "SIZE", CLI_BYTES, O(memory_bytes), 1048576, 1e15,
                    "refuse more matching data than this; with --preview: all that is held "
                    "(default: 64MiB)"},
    [OPT_TIME] = {"time", 0, "TIME", CLI_TIME, O(time_ns), 1e8, 1e15,
                  "with --preview: about how long it may take (default: 10s)"},
    [OPT_LEAST] = {"least", 0, "RATE", CLI_DECIMAL, O(least), 0, 1,
                   "how fast the darkest shadow ages (default: 0.2)"},
    [OPT_THRESHOLD] = {"threshold", 0, "SHARE", CLI_DECIMAL, O(threshold), 0, 0.999,
                       "how far from the ground's colour the object begins, 0 to 1 (default: 0, "
                       "found)"},
    [OPT_SOFTEN] = {"soften", 0, "PX", CLI_DECIMAL, O(soften), 0, 64,
                    "softness of the object's edge (default: 1)"},
    [OPT_LISTEN] =
        {"listen", 0, "WHERE", CLI_TEXT, O(listen), 0, 0,
         "ADDRESS:PORT, as 0.0.0.0:8417 or [::1]:8417 (port 0: any free one), INTERFACE:PORT, as "
         "usb0:8417, or unix:PATH (default: 127.0.0.1:8417)"},
    [OPT_TOKEN_FILE] = {"token-file", 0, "FILE", CLI_TEXT, O(token_file), 0, 0,
                        "the file with the token; made if it is not there"},
    [OPT_BOX] =
        {"box", 0, "WHERE", CLI_TEXT, O(box), 0, 0,
         "the box: http://ADDRESS:PORT, unix:PATH, usb (the one that is plugged in) or usb:SERIAL"},
    [OPT_USB] = {"usb", 0, NULL, CLI_FLAG, O(usb), 0, 0,
                 "the box at this machine's USB: --box usb"},
    [OPT_ONLY] = {"only", 0, "NAMES", CLI_TEXT, O(only), 0, 0,
                  "these datasets alone, several with commas (default: all)"},
    [OPT_FOLLOW] = {"follow", 0, NULL, CLI_FLAG, O(follow), 0, 0,
                    "go on until they are sealed, as they grow"},
    [OPT_LIST] = {"list", 0, NULL, CLI_FLAG, O(list), 0, 0, "only say what the box has, as JSON"},
    [OPT_MAN] = {"man", 0, NULL, CLI_FLAG, O(man), 0, 0, "print the manual page as troff source"},
    [OPT_JSON] = {"json", 0, NULL, CLI_FLAG, O(json), 0, 0,
                  "print the result as one line of JSON on standard output"},
    [OPT_QUIET] = {"quiet", 'q', NULL, CLI_FLAG, O(quiet), 0, 0, "no progress bar"},
};

const struct cli_option_def *cli_option_def(enum cli_option option)
{
    return &OPTIONS[option];
}

void cli_options_defaults(struct cli_options *options)
{
    memset(options, 0, sizeof *options);
    options->tolerance = 0.1;
    options->rank = 15;
    options->jitter_every = 16;
    options->bracket = -1;
    options->deflicker_window = 9;
    options->height_scale = 0.1;
    options->rate_gain = 1;
    options->time_ns = 10 * TTF_NS_PER_S;
    options->least = 0.2;
    options->soften = 1;
}

/* Puts "--name" in front of what units.c found wrong. */
static int named(const struct cli_option_def *def, struct ttf_err *err)
{
    if (err)
        snprintf(err->where, sizeof err->where, "--%s", def->name);
    return -EINVAL;
}

static int check_range(const struct cli_option_def *def, double value, const char *text,
                       struct ttf_err *err)
{
    char lo[40], hi[40];

    if (value >= def->lo && value <= def->hi)
        return 0;
    if (def->type == CLI_TIME) {
        ttf_unit_format(TTF_UNIT_TIME, (int64_t)def->lo, lo, sizeof lo);
        ttf_unit_format(TTF_UNIT_TIME, (int64_t)def->hi, hi, sizeof hi);
    } else if (def->type == CLI_BYTES) {
        ttf_unit_format(TTF_UNIT_BYTES, (int64_t)def->lo, lo, sizeof lo);
        ttf_unit_format(TTF_UNIT_BYTES, (int64_t)def->hi, hi, sizeof hi);
    } else {
        snprintf(lo, sizeof lo, "%g", def->lo);
        snprintf(hi, sizeof hi, "%g", def->hi);
    }
    ttf_err_set(err, -EINVAL, NULL, "%.60s is out of its range", text);
    ttf_err_hint(err, "%s: from %s to %s", def->text, lo, hi);
    return named(def, err);
}

static int take_set(struct cli_options *options, const struct cli_option_def *def,
                    const char *value, struct ttf_err *err)
{
    const char *equals = strchr(value, '=');
    char *copy;

    if (!equals || equals == value) {
        ttf_err_set(err, -EINVAL, NULL, "'%.60s' sets nothing", value);
        ttf_err_hint(err, "write KEY=VALUE, as --set sim.optics.blur=0px");
        return named(def, err);
    }
    if (options->n_sets == CLI_SETS_MAX) {
        ttf_err_set(err, -EINVAL, NULL, "more than %d of them", CLI_SETS_MAX);
        return named(def, err);
    }
    copy = strdup(value);
    if (!copy)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    copy[equals - value] = '\0';
    options->set_texts[options->n_sets] = copy;
    options->sets[options->n_sets++] =
        (struct ttf_board_set){.path = copy, .value = copy + (equals - value) + 1};
    return 0;
}

static int take_source(struct cli_options *options, const struct cli_option_def *def,
                       const char *value, struct ttf_err *err)
{
    if (options->n_sources == CLI_SOURCES_MAX) {
        ttf_err_set(err, -EINVAL, NULL, "more than %d of them", CLI_SOURCES_MAX);
        return named(def, err);
    }
    options->sources[options->n_sources++] = value;
    return 0;
}

/* Three numbers, apart by commas. */
static int take_point(const struct cli_option_def *def, const char *value, double *ret,
                      struct ttf_err *err)
{
    const char *at = value;
    double point[3];
    char part[40];

    for (int i = 0; i < 3; i++) {
        size_t n = strcspn(at, ",");

        if (n >= sizeof part || (at[n] == ',') != (i < 2)) {
            ttf_err_set(err, -EINVAL, NULL, "'%.60s' is no point", value);
            ttf_err_hint(err, "write %s, as 0.5,0.3,0.4", def->arg);
            return named(def, err);
        }
        memcpy(part, at, n);
        part[n] = '\0';
        if (ttf_number_parse(part, &point[i], err) < 0)
            return named(def, err);
        if (check_range(def, point[i], part, err) < 0)
            return -EINVAL;
        at += n + 1;
    }
    memcpy(ret, point, sizeof point);
    return 0;
}

/* Numbers and quantities of one value. */
static int take_number(struct cli_options *options, const struct cli_option_def *def,
                       const char *value, struct ttf_err *err)
{
    char *at = (char *)options + def->offset;
    int64_t whole = 0;
    double number = 0;
    int r;

    if (def->type == CLI_TIME)
        r = ttf_unit_parse(TTF_UNIT_TIME, value, &whole, err);
    else if (def->type == CLI_BYTES)
        r = ttf_unit_parse(TTF_UNIT_BYTES, value, &whole, err);
    else if (def->type == CLI_DECIMAL)
        r = ttf_number_parse(value, &number, err);
    else
        r = ttf_integer_parse(value, &whole, err);
    if (r < 0)
        return named(def, err);
    if (check_range(def, def->type == CLI_DECIMAL ? number : (double)whole, value, err) < 0)
        return -EINVAL;
    if (def->type == CLI_DECIMAL)
        *(double *)at = number;
    else
        *(int64_t *)at = whole;
    return 0;
}

static int take_value(struct cli_options *options, const struct cli_option_def *def,
                      const char *value, struct ttf_err *err)
{
    char *at = (char *)options + def->offset;

    switch (def->type) {
    case CLI_FLAG:
        *(bool *)at = true;
        return 0;
    case CLI_TEXT:
    case CLI_WORDS:
        *(const char **)at = value;
        return 0;
    case CLI_SOURCE:
        return take_source(options, def, value, err);
    case CLI_BLOCK:
        options->block_auto = strcmp(value, "auto") == 0;
        if (options->block_auto)
            return 0;
        /* fall through */
    case CLI_SIZE:
        return ttf_size_parse(value, (uint32_t *)at, (uint32_t *)at + 1, err) < 0 ? named(def, err)
                                                                                  : 0;
    case CLI_POINT:
        return take_point(def, value, (double *)at, err);
    case CLI_SET:
        return take_set(options, def, value, err);
    case CLI_RANK:
        if (strcmp(value, "full") == 0) {
            *(int64_t *)at = 0;
            return 0;
        }
        break;
    case CLI_SEED:
        options->has_seed = true;
        break;
    default:
        break;
    }
    return take_number(options, def, value, err);
}

int cli_option_take(struct cli_options *options, enum cli_option option, const char *value,
                    struct ttf_err *err)
{
    const struct cli_option_def *def = &OPTIONS[option];
    const char *typed = value ? value : "";

    if (def->arg && !*typed && def->type != CLI_WORDS) {
        ttf_err_set(err, -EINVAL, NULL, "is empty");
        ttf_err_hint(err, "%s", def->text);
        return named(def, err);
    }
    options->given[option] = typed;
    return take_value(options, def, typed, err);
}

void cli_options_free(struct cli_options *options)
{
    for (unsigned i = 0; i < options->n_sets; i++)
        free(options->set_texts[i]);
    options->n_sets = 0;
}
