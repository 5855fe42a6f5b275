/* SPDX-License-Identifier: Apache-2.0 */
/* commands_data.c: the words of what handles datasets: brought in, looked at, handed over, taken out. */
#include "commands_private.h"

static const struct cli_command ROWS[] = {
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
            "token (Authorization: Bearer TOKEN). The address of an INTERFACE is followed when it "
            "changes; it must have one at the start. Nothing is ever written into FOLDER. What can "
            "be asked for: firmware/http/openapi.yaml.",
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
                    {OPT_ROLE, NULL},
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
};

const struct cli_commands cli_commands_data = {ROWS, TTF_COUNT_OF(ROWS)};
