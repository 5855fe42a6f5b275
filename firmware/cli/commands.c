/* SPDX-License-Identifier: Apache-2.0 */
/* commands.c: every command's words; see commands.h. */
#include "commands.h"

#include <string.h>

#define BOARD_OPTIONS                                      \
    {OPT_BOARD, NULL}, {OPT_SET, NULL}, {OPT_SCENE, NULL}, \
    {                                                      \
        OPT_SEED, NULL                                     \
    }

#define PREPARE_OPTIONS                                                         \
    {OPT_STABILISE, NULL}, {OPT_DEFLICKER, NULL}, {OPT_DEFLICKER_WINDOW, NULL}, \
        {OPT_FLATTEN, NULL}, {OPT_FLATTEN_SIGMA, NULL},                         \
    {                                                                           \
        OPT_KEEP_GRADIENT, NULL                                                 \
    }

#define BLOCK_OPTIONS                                                                \
    {OPT_BLOCK, NULL}, {OPT_OVERLAP, NULL}, {OPT_FEATHER, NULL}, {OPT_MIRROR, NULL}, \
        {OPT_FLIPS, NULL}, {OPT_ROTATIONS, NULL}, {OPT_AVOID, NULL},                 \
    {                                                                                \
        OPT_SEED, NULL                                                               \
    }

#define MATCH_OPTIONS                                                                    \
    {OPT_TOLERANCE, NULL}, {OPT_METRIC, NULL}, {OPT_RANK, NULL}, {OPT_RANK_ERROR, NULL}, \
        {OPT_SVD, NULL},                                                                 \
    {                                                                                    \
        OPT_FACTORS, NULL                                                                \
    }

static const struct cli_command COMMANDS[] = {
    {
        .name = "plan check",
        .args = "PLAN",
        .summary = "check a capture plan against a box, before anything is photographed",
        .text =
            "Reads the plan (YAML), checks it by itself and against the board, and prints slots, "
            "the end, storage, lamp hours, switchings and memory. With -o it measures how fast "
            "the folder there takes synced writes, and refuses an interval or a length that it "
            "cannot hold, naming the best it can.\n\n"
            "What is wrong is named with file, line and column, and ends with exit code 2.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_plan_check,
        .options = {BOARD_OPTIONS,
                    {OPT_OUTPUT, "the dataset that will be made: measures the disk there"},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox plan check boards/sim/plans/grass-week.yaml",
                      "what a week of growing grass needs"},
                     {"ttfbox plan check week.yaml -o /data/grass",
                      "the same, measuring the disk under /data"}},
    },
    {
        .name = "board probe",
        .args = "",
        .summary = "show what answers on this box",
        .text = "Makes the box's devices as its description says and asks each of them: camera "
                "modes and limits, lamps, sensors, clock, panel, watchdog. Of a box with real "
                "devices it looks at the machine, too, and says what is wrong and what to do: no "
                "camera and why, GPIO lines that are something else or somebody else's, who holds "
                "the USB device controller, a clock that forgets, a sagging supply, and with -o "
                "the disk under a folder. Exit code 1 if a device that the board names does not "
                "answer, or a problem was found.",
        .run = cmd_board_probe,
        .options = {BOARD_OPTIONS,
                    {OPT_OUTPUT, "a folder whose disk is looked at, too, and measured"},
                    {OPT_BUNDLE, NULL},
                    {OPT_ROOT, NULL},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox board probe --board sim", "the simulated box"},
                     {"ttfbox board probe --board rpi4 -o /var/lib/ttfbox --bundle report.tar.gz",
                      "a real one and its disk, with an archive for whoever helps"}},
    },
    {
        .name = "calibrate dark",
        .args = "",
        .summary = "measure the sensor's dark signal and hot pixels",
        .text = "Turns all lamps off, averages frames of the shot's exposure (64, or --frames) and "
                "keeps black level, dark signal and hot pixels in the calibration folder CAL. "
                "Refused with a reason if the frames are not dark.\n\n"
                "CAL may exist already and hold a flat: it is completed.",
        .run = cmd_calibrate_dark,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_OUTPUT, "the calibration folder CAL"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate dark --plan week.yaml -o cal", "for the plan's exposure"}},
    },
    {
        .name = "calibrate flat",
        .args = "",
        .summary = "measure what an even target looks like under the plan's lamps",
        .text = "Put an even white target in the sample's place first; on a simulated box say "
                "--scene white. Turns the shot's lamps on, waits until they have settled, averages "
                "frames (64, or --frames) and keeps the gain of every pixel in CAL, so that a "
                "perfect diffuser becomes value 1 wherever it lies. Refused with a reason if the "
                "frames are saturated, too dark, or more uneven than 8 to 1.\n\n"
                "Make the dark first, in the same CAL: it is subtracted.",
        .run = cmd_calibrate_flat,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_REFLECTANCE, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_OUTPUT, "the calibration folder CAL"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate flat --plan week.yaml --scene white -o cal",
                      "in the simulated box"}},
    },
    {
        .name = "calibrate chart",
        .args = "",
        .summary = "measure how the camera's colours become those of a display",
        .text =
            "Photographs a colour chart of 24 patches in the sample's place, under the lamps and "
            "at "
            "the exposure of the flat, which CAL must hold, and fits the matrix that brings the "
            "camera's colours to sRGB's: grey stays grey. Says how far the patches are off before "
            "and after (CIEDE2000). Refuses corners that do not fit, saturated or uneven patches, "
            "and a chart of other colours.",
        .run = cmd_calibrate_chart,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_CORNERS, NULL},
                    {OPT_VALUES, NULL},
                    {OPT_OUTPUT, "the calibration folder CAL"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate chart --plan week.yaml -o cal "
                      "--corners 210,118,1630,121,1622,1071,214,1066",
                      NULL},
                     {"ttfbox calibrate chart --scene chart -o cal", "in the simulated box"}},
    },
    {
        .name = "calibrate geometry",
        .args = "",
        .summary = "measure how large a pixel is, and how square the camera looks",
        .text =
            "Photographs a printed grid of dark round dots, --pitch apart in rows and columns and "
            "half as wide, in the sample's place, and says how many millimetres a pixel is there, "
            "how "
            "much that differs over the frame, how the grid is turned, and what the lens bends. "
            "With -o it is kept in CAL, and datasets made with CAL say their scale. Refuses what "
            "is no even grid, or covers too little of the frame.",
        .run = cmd_calibrate_geometry,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_PITCH, NULL},
                    {OPT_FRAMES, "frames to average (default: 64)"},
                    {OPT_OUTPUT, "a calibration folder that has its dark or flat"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate geometry --plan week.yaml --pitch 5 -o cal", NULL},
                     {"ttfbox calibrate geometry --scene dots --pitch 5", "in the simulated box"}},
    },
    {
        .name = "calibrate flicker",
        .args = "",
        .summary = "measure how steady the light is, from frame to frame and within one",
        .text =
            "Takes frames of something still under the plan's lamps at its exposure, one by one, "
            "and "
            "says how much their levels differ, how much bands of rows differ within a frame (a "
            "ripple under a rolling shutter), and how the light drifts; and what to do about it. "
            "With -o the figures are kept in CAL.",
        .run = cmd_calibrate_flicker,
        .options = {BOARD_OPTIONS,
                    {OPT_PLAN, NULL},
                    {OPT_SHOT, NULL},
                    {OPT_EXPOSURE, NULL},
                    {OPT_FRAMES, "frames to take (default: 64)"},
                    {OPT_OUTPUT, "a calibration folder that has its dark or flat"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate flicker --plan week.yaml", NULL}},
    },
    {
        .name = "calibrate report",
        .args = "CAL",
        .summary = "say what a calibration holds",
        .text = "Prints the camera, dark signal, hot pixels, evenness of the light and what each "
                "part was measured with.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_calibrate_report,
        .options = {{OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox calibrate report cal", NULL}},
    },
    {
        .name = "capture",
        .args = "PLAN",
        .summary = "photograph a sample by a plan into a calibrated dataset",
        .text =
            "Checks the plan, measures the disk, locks the exposure and then takes every slot on "
            "its own instant of an absolute grid until the plan is done and the dataset sealed. "
            "Every slot ends as one record: captured, or missed or failed with a reason.\n\n"
            "Run again on an unfinished dataset, it goes on where it was, on the same grid, "
            "whatever stopped it: Ctrl-C (ends within a slot), a kill, a power cut. In the "
            "simulated box a power cut is part of the run: the box comes back by itself after the "
            "board's sim.outage. A dataset of the simulated box says SIMULATED.\n\n"
            "With another plan it goes on by that one from the next slot on; a plan that it has "
            "moved on from leaves it as it is. When its storage fails for good, it goes on in the "
            "plan's storage.second, also when run again.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_capture,
        .options = {BOARD_OPTIONS,
                    {OPT_OUTPUT, "the dataset: new, or unfinished to go on with"},
                    {OPT_CALIBRATION, NULL},
                    {OPT_REHEARSE, NULL},
                    {OPT_NO_SPEED_CHECK, NULL},
                    {OPT_SCRIPT, NULL},
                    {OPT_AS_GIVEN, NULL},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox capture week.yaml --rehearse 3 -o try", "three slots at once"},
                     {"ttfbox capture week.yaml -c cal -o grass", "the week itself"},
                     {"ttfbox capture week.yaml -c cal -o grass", "the same again: goes on"},
                     {"printf '40 pause watering\\n41 continue\\n' >asks; "
                      "ttfbox capture week.yaml -o grass --script asks",
                      "what is asked meanwhile"},
                     {"ttfbox capture week.yaml -o grass --plan-as-given",
                      "back to this plan, after others came"}},
    },
    {
        .name = "note",
        .args = "DATASET [TEXT]",
        .summary = "add a note to a dataset, while it is captured or after",
        .text =
            "A line in notes.jsonl, outside the seal: what somebody saw or did, to which slots. "
            "The dataset itself is not touched.",
        .min_args = 1,
        .max_args = 2,
        .run = cmd_note,
        .options = {{OPT_SLOTS, NULL},
                    {OPT_TAG, NULL},
                    {OPT_AUTHOR, NULL},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox note grass \"watered\" --slots 144", NULL},
                     {"ttfbox note grass --tag exclude --slots 30-42", NULL}},
    },
    {
        .name = "import",
        .args = "FILES...",
        .summary = "make a dataset of pictures, a TIFF stack or a video",
        .text = "Pictures (PNG, JPEG, TIFF) in the natural order of their names, or by the time "
                "they were taken; the pages of TIFF stacks; the frames of one video. 8-bit sRGB "
                "pictures come back to the bit when exported again. A video says its own interval, "
                "pictures ordered by time too; otherwise --interval must say it.",
        .min_args = 1,
        .max_args = 1000000,
        .run = cmd_import,
        .options = {{OPT_OUTPUT, "the new dataset"},
                    {OPT_INTERVAL, NULL},
                    {OPT_ORDER, NULL},
                    {OPT_TRANSFER, NULL},
                    {OPT_TITLE, NULL},
                    {OPT_MM_PER_PX, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox import copper/*.png --interval 1min -o copper-ttf", NULL},
                     {"ttfbox import *.jpg --order exif-time -o banana",
                      "by when they were taken"}},
    },
    {
        .name = "info",
        .args = "DATASET",
        .summary = "say what a dataset holds",
        .text = "Prints streams, slots and their results, segments, calibrations, size, whether it "
                "is sealed, its digest, and where it came from. Changes nothing.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_info,
        .options = {{OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox info grass", NULL},
                     {"ttfbox info grass --json | jq .slots", "for programs"}},
    },
    {
        .name = "verify",
        .args = "DATASET",
        .summary = "check every byte of a dataset",
        .text = "Checks records, checksums, files and the seal. Damage is named by file and slot "
                "and ends with exit code 3; what a crash leaves and the next capture puts right is "
                "reported with exit code 0. Changes nothing. Without this program: "
                "sha256sum --strict -c SHA256SUMS in the dataset's folder.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_verify,
        .options = {{OPT_THREADS, NULL}, {OPT_JSON, NULL}, {OPT_QUIET, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox verify grass", NULL}},
    },
    {
        .name = "serve",
        .args = "FOLDER",
        .summary = "offer a folder of datasets to browsers and programs by HTTP",
        .text =
            "Lists the datasets of FOLDER and gives their records, files and archives, by ranges "
            "and with checksums; what a dataset gets while it is captured is there at once. "
            "Programs of this machine may read freely; a listener that others reach asks them for "
            "a "
            "token (Authorization: Bearer TOKEN). Nothing is ever written into FOLDER. What can be "
            "asked for: firmware/http/openapi.yaml.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_serve,
        .options = {{OPT_LISTEN, NULL}, {OPT_TOKEN_FILE, NULL}, {OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox serve datasets", NULL},
                     {"curl http://127.0.0.1:8417/api/v1/datasets", "what there is"},
                     {"curl -O http://127.0.0.1:8417/api/v1/datasets/grass/tar", "all of one"}},
    },
    {
        .name = "token",
        .args = "[CONFIG]",
        .summary = "print the token of the box that this machine is",
        .text = "A browser at the box's page is asked for it once, a program sends it as "
                "Authorization: Bearer TOKEN: for reading from elsewhere than the cable, for live "
                "view, and for whatever changes the box. CONFIG is the configuration of ttfboxd "
                "(default: /etc/ttfbox/ttfboxd.yaml), which says where the token lies. Whoever has "
                "the file replaced by another token, and ttfboxd started again, has all others "
                "shut out.",
        .min_args = 0,
        .max_args = 1,
        .run = cmd_token,
        .options = {{OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"sudo ttfbox token", NULL}},
    },
    {
        .name = "usb list",
        .args = "",
        .summary = "say which boxes are plugged in",
        .text = "Names each box at this machine's USB by its serial, with which 'ttfbox pull --box "
                "usb:SERIAL' finds it, and says of each whether you may use it.",
        .min_args = 0,
        .max_args = 0,
        .run = cmd_usb_list,
        .options = {{OPT_JSON, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox usb list", NULL}},
    },
    {
        .name = "usb token",
        .args = "",
        .summary = "have the box at USB show its token, which it does once",
        .text =
            "A box that nobody can log in to shows the token that it made at its first start to "
            "the first who asks at its cable, and never again. Keep it: 'ttfbox pull "
            "--token-file' and a browser at the box's page take it. If it was shown already and "
            "not to you, somebody else may change the box: write a token of your own on its "
            "card (settings/token).",
        .min_args = 0,
        .max_args = 0,
        .run = cmd_usb_token,
        .options = {{OPT_BOX, "usb (default: the one that is plugged in) or usb:SERIAL"},
                    {OPT_TOKEN_FILE, "a new file, for you alone, that the token is written into"},
                    {OPT_JSON, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox usb token", NULL},
                     {"ttfbox usb token --token-file box-token",
                      "and ttfbox pull --usb --token-file box-token"}},
    },
    {
        .name = "usb",
        .args = "",
        .summary = "join a box's HTTP interface at USB to an address of this machine",
        .text =
            "A browser, curl and whatever else speaks HTTP reach the box there as over a network. "
            "What comes is passed on as it is. Whoever can connect may read what the box has: "
            "unix:PATH is yours alone, 127.0.0.1:PORT and [::1]:PORT are every user's of this "
            "machine, "
            "and others are not taken. A box "
            "that is "
            "unplugged is found again when it is back. 'ttfbox pull --usb' needs none of this.",
        .min_args = 0,
        .max_args = 0,
        .run = cmd_usb,
        .options = {{OPT_BOX, "usb (default: the one that is plugged in) or usb:SERIAL"},
                    {OPT_LISTEN, "where (default: unix:$XDG_RUNTIME_DIR/ttfbox-usb)"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples =
            {{"ttfbox usb", NULL},
             {"curl --unix-socket $XDG_RUNTIME_DIR/ttfbox-usb http://localhost/api/v1/datasets",
              NULL},
             {"ttfbox usb --listen 127.0.0.1:8418", "then http://127.0.0.1:8418 in a browser"}},
    },
    {
        .name = "pull",
        .args = "[DEST]",
        .summary = "bring a box's datasets here, verified, also while they grow",
        .text =
            "Lays each dataset at DEST/NAME (default: here). A file gets its name when its SHA-256 "
            "is "
            "the recorded one, a record is added behind its files, the seal comes last: what is "
            "here is a dataset at any moment. Run again, it goes on where it was, at the byte. "
            "Files that are damaged on the box are named and left out (exit 3). Nothing that is "
            "here already is overwritten by another dataset.",
        .min_args = 0,
        .max_args = 1,
        .run = cmd_pull,
        .options = {{OPT_BOX, NULL},
                    {OPT_USB, NULL},
                    {OPT_ONLY, NULL},
                    {OPT_FOLLOW, NULL},
                    {OPT_LIST, NULL},
                    {OPT_TOKEN_FILE, "the file with the box's token"},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox pull datasets --usb", "of the box that is plugged in"},
                     {"ttfbox pull datasets --box usb:0007", "of several, that one"},
                     {"ttfbox pull datasets --box http://192.168.7.1:8417", NULL},
                     {"ttfbox pull --box http://192.168.7.1:8417 --only grass --follow",
                      "until it is sealed"}},
    },
    {
        .name = "develop",
        .args = "DATASET",
        .summary = "develop a dataset's raw frames anew, with another calibration",
        .text = "Reads the raw frames and writes a new dataset, derived from the old one, which is "
                "not changed. The same raw frames and calibration give the same bits on every "
                "machine.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_develop,
        .options = {{OPT_OUTPUT, "the new dataset"},
                    {OPT_CALIBRATION, NULL},
                    {OPT_FRAMES, NULL},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox develop grass -c better-cal -o grass-2", NULL}},
    },
    {
        .name = "export",
        .args = "DATASET",
        .summary = "turn a dataset into a video, pictures, an array or a contact sheet",
        .text =
            "mp4, gif and y4m videos; png and tiff folders of pictures numbered without holes; "
            "npy, "
            "one array n x h x w x 3 of linear 16-bit values (of a stream of floats, of its "
            "floats, as "
            "are tiffs); sheet, one picture of frames spread "
            "over the time. Slots without an image, and those that a note tags 'exclude', are "
            "filled "
            "as --gaps says, and a .json beside the output names every frame that was invented.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_export,
        .options = {{OPT_OUTPUT, "the file, or the folder of pictures"},
                    {OPT_TO, NULL},
                    {OPT_GAPS, NULL},
                    {OPT_START, NULL},
                    {OPT_EVERY, NULL},
                    {OPT_FRAMES, NULL},
                    {OPT_FPS, NULL},
                    {OPT_WIDTH_MAX, NULL},
                    {OPT_COLUMNS, NULL},
                    {OPT_WHITE, NULL},
                    {OPT_NAME, NULL},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox export grass -o grass.mp4", "a video"},
                     {"ttfbox export grass --to sheet -o sheet.png", "a contact sheet"},
                     {"ttfbox export grass --to png -o frames", "frames/frame.1001.png, ..."}},
    },
    {
        .name = "view",
        .args = "DATASET",
        .summary = "make one HTML file to look at a dataset with, offline",
        .text =
            "The file holds the texture's frames and all it needs: it opens in any browser by a "
            "double click, without a network. Time and exposure by sliders, on a plane or a "
            "sphere; a click on a pixel plots its life, p(t) of each channel. It has at most 30 "
            "MB: "
            "frames are left out evenly and pictures made smaller as far as that needs, which the "
            "file says. Pictures are exact (8-bit sRGB, PNG) where they fit, else JPEG.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_view,
        .options = {{OPT_OUTPUT, "the HTML file"},
                    {OPT_BESIDE, NULL},
                    {OPT_FRAMES, "at most N frames, up to 256 (default: 240)"},
                    {OPT_WIDTH_MAX, "longest side of a picture, up to 2048 (default: what fits)"},
                    {OPT_WHITE, "value of the brightest code (default: the brightest there is)"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox view grass -o grass.html", "a time-lapse to look at"},
                     {"ttfbox view grass --beside lawn -o both.html",
                      "what was captured beside what was synthesized from it"}},
    },
    {
        .name = "synth quilt",
        .args = "INPUT",
        .summary = "synthesize a larger time-varying texture by quilting",
        .text =
            "INPUT is a dataset or a picture. Blocks are cuboids: the same spatial block for all "
            "frames, cut along one seam that is best over all of them; frames are copied, so every "
            "pixel of the output lives the life of one pixel of the input. The output is a dataset "
            "again, derived from the input, with report.json: coherence, seams, times.\n\n"
            "--rate-map, --light and --curvature let places age at different paces; the output is "
            "then as long as its fastest pixel takes.\n\n"
            "--check reads the result back and compares every pixel's life with its source's.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_synth_quilt,
        .options = {{OPT_GROUP, "Result:"},
                    {OPT_OUTPUT, "the new dataset, or the file of --sink raw"},
                    {OPT_SIZE, NULL},
                    {OPT_SINK, NULL},
                    {OPT_COMPRESS, NULL},
                    {OPT_CHECK, NULL},
                    {OPT_FIGURES, NULL},
                    {OPT_NO_FIGURES, NULL},
                    {OPT_AGREEMENT, NULL},
                    {OPT_PREVIEW, NULL},
                    {OPT_MEMORY, NULL},
                    {OPT_TIME, NULL},
                    {OPT_GROUP, "Input:"},
                    {OPT_FRAMES, "the first N frames only"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_SOURCE, NULL},
                    PREPARE_OPTIONS,
                    {OPT_GROUP, "Blocks:"},
                    BLOCK_OPTIONS,
                    {OPT_PER_FRAME, NULL},
                    {OPT_TILEABLE, NULL},
                    {OPT_SAVE_MAP, NULL},
                    {OPT_MAP, NULL},
                    {OPT_GROUP, "Matching:"},
                    MATCH_OPTIONS,
                    {OPT_GROUP, "Time:"},
                    {OPT_JITTER, NULL},
                    {OPT_JITTER_ROUNDED, NULL},
                    {OPT_JITTER_EVERY, NULL},
                    {OPT_RATE_MAP, NULL},
                    {OPT_LIGHT, NULL},
                    {OPT_NORMALS, NULL},
                    {OPT_HEIGHTS, NULL},
                    {OPT_HEIGHT_SCALE, NULL},
                    {OPT_CURVATURE, NULL},
                    {OPT_RATE_OFFSET, NULL},
                    {OPT_RATE_GAIN, NULL},
                    {OPT_GROUP, "All commands:"},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox synth quilt grass --size 1024x1024 --block 48x96 -o meadow",
                      "elongated blocks for grass"},
                     {"ttfbox synth quilt copper-ttf --size 512x512 --check -o big",
                      "and prove that it was copied"},
                     {"ttfbox synth quilt snow --rate-map logo.png --jitter 3 -o sign",
                      "snow settles later where the picture is dark"},
                     {"ttfbox synth quilt grass --preview --memory 64MiB --time 10s -o look",
                      "a first look"}},
    },
    {
        .name = "synth composite",
        .args = "PHOTO DATASET",
        .summary = "lay a photographed object and its shadow over a growing texture",
        .text =
            "PHOTO shows one object on a plain ground that is a little darker where the object's "
            "shadow falls. A texture of the photograph's size (or --size) is quilted from DATASET; "
            "where the shadow is, it ages more slowly and is darker; the object lies over it. The "
            "output is a dataset, derived from DATASET, with report.json, whose figures are of the "
            "texture before shadow and object.",
        .min_args = 2,
        .max_args = 2,
        .run = cmd_synth_composite,
        .options = {{OPT_GROUP, "Result:"},
                    {OPT_OUTPUT, "the new dataset, or the file of --sink raw"},
                    {OPT_SIZE, "the output's size in pixels (default: the photograph's)"},
                    {OPT_SINK, NULL},
                    {OPT_COMPRESS, NULL},
                    {OPT_FIGURES, NULL},
                    {OPT_NO_FIGURES, NULL},
                    {OPT_PREVIEW, NULL},
                    {OPT_MEMORY, NULL},
                    {OPT_TIME, NULL},
                    {OPT_GROUP, "Object and shadow:"},
                    {OPT_LEAST, NULL},
                    {OPT_THRESHOLD, NULL},
                    {OPT_SOFTEN, NULL},
                    {OPT_GROUP, "Input:"},
                    {OPT_FRAMES, "the first N frames only"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_SOURCE, NULL},
                    PREPARE_OPTIONS,
                    {OPT_GROUP, "Blocks:"},
                    BLOCK_OPTIONS,
                    {OPT_SAVE_MAP, NULL},
                    {OPT_GROUP, "Matching:"},
                    MATCH_OPTIONS,
                    {OPT_GROUP, "Time:"},
                    {OPT_JITTER, NULL},
                    {OPT_JITTER_ROUNDED, NULL},
                    {OPT_JITTER_EVERY, NULL},
                    {OPT_GROUP, "All commands:"},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox synth composite bench.jpg grass --block 32x64 -o bench-lawn",
                      "grass grows more slowly in the bench's shadow"}},
    },
    {
        .name = "synth rank",
        .args = "INPUT",
        .summary = "measure how well a sequence compresses, rank by rank",
        .text =
            "Writes one line for each rank k from 0: k, the error e_k (the root of what rank k "
            "misses over the root of all), and the root mean square of that, over full scale. A "
            "plot is written beside it: curve.svg beside curve.csv.",
        .min_args = 1,
        .max_args = 1,
        .run = cmd_synth_rank,
        .options = {{OPT_OUTPUT, "the table, as curve.csv"},
                    {OPT_RANK, "the last rank, 1 to 64 (default: 64)"},
                    {OPT_SVD, NULL},
                    {OPT_METRIC, NULL},
                    {OPT_FRAMES, "the first N frames only"},
                    {OPT_STREAM, NULL},
                    {OPT_BRACKET, NULL},
                    {OPT_WITH_EXCLUDED, NULL},
                    {OPT_THREADS, NULL},
                    {OPT_JSON, NULL},
                    {OPT_QUIET, NULL},
                    {OPT_END, NULL}},
        .examples = {{"ttfbox synth rank grass -o curve.csv", NULL}},
    },
    {
        .name = "help",
        .args = "[COMMAND]",
        .summary = "explain the program or a command",
        .text = "The same texts as --help; with --man as the source of the manual page.",
        .max_args = 3,
        .run = cmd_help,
        .options = {{OPT_MAN, NULL}, {OPT_END, NULL}},
        .examples = {{"ttfbox help --man capture | man -l -", "read the manual page"}},
    },
};

const struct cli_command *cli_command(unsigned i)
{
    return i < TTF_COUNT_OF(COMMANDS) ? &COMMANDS[i] : NULL;
}

/* How many of the words the name takes up, or 0. */
static int match(const char *name, int n, char *const *words)
{
    int used = 0;

    while (*name) {
        size_t length = strcspn(name, " ");

        if (used == n || strlen(words[used]) != length || strncmp(words[used], name, length) != 0)
            return 0;
        used++;
        name += length;
        name += *name == ' ';
    }
    return used;
}

const struct cli_command *cli_command_find(int n, char *const *words, int *ret_words,
                                           bool *ret_group)
{
    *ret_group = false;
    for (unsigned i = 0; i < TTF_COUNT_OF(COMMANDS); i++) {
        const char *name = COMMANDS[i].name;
        size_t length = strcspn(name, " ");
        int used = match(name, n, words);

        if (used) {
            *ret_words = used;
            return &COMMANDS[i];
        }
        if (n && strlen(words[0]) == length && strncmp(name, words[0], length) == 0)
            *ret_group = true;
    }
    return NULL;
}
