#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The file of `ttfbox view` in a browser. TTFBOX_SHOTS: a folder for pictures of what was seen.
. "$(dirname "$0")/../cli/cli.bash"

mkdir in
"$PYTHON" "$HERE/pictures.py" make in 6 60 48 || fail "making pictures"
expect 0 "$TTFBOX" import in/*.png --interval 1h -o d
expect 0 "$TTFBOX" synth quilt d --size 100x80 --block 16x16 -o large
expect 0 "$TTFBOX" view d --beside large -o both.html
node "$SOURCE/tests/web/view.mjs" "$WORK/both.html" ${TTFBOX_SHOTS:+"$TTFBOX_SHOTS"} || exit 1
